#!/usr/bin/env python3
"""The class 1 traffic of every connection, as tshark sees it and as the octets say.

tshark must decode each datagram as CIP I/O of a Forward_Open that it has seen, and object to nothing. Then the octets
are read once more without tshark: sequence numbers without a gap, no new data under an old sequence count (R-IO-5),
never faster than granted, nothing after the Forward_Close (R-CON-37), TTL and DSCP as R-IO-11 and R-QOS-5 say.

tshark 4.0 knows a connection from its Forward_Open (enip.fwd_open_in, cip.connection) and decodes its sequence count
(cip.seq), run/idle header (cip.32bitheader) and data (cipio.data). It has no fields yet that judge a connection over
time (cip.analysis); what those would say of gaps and order, the second reading says.

SERVOBUS_CAPTURE_SECONDS says how long each connection runs; 60 makes it the minute that a release is held to.
"""

import os
import signal
import struct
import subprocess
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

from judge import BIN, captured, check, enter_own_network, own_address, run, running_drive, scanner

MALFORMED = "_ws.malformed"
WARNING = "_ws.expert.severity >= 0x600000"
SECONDS = float(os.environ.get("SERVOBUS_CAPTURE_SECONDS", "0.7"))
# A machine that runs other tests may leave a program without a turn for longer than a connection of 1 ms usually lives.
PATIENT = ("--multiplier", "512", "--no-reopen")
PATIENCE = 60 + 30 * SECONDS
OWNERS = ("standard", "iforce", "outputs", "force", "cipsync")
OPENED = 2 * len(OWNERS) + 4
MULTICAST, SCHEDULED_DSCP = 1, 47


def io(connection, *options, rpi="1"):
    scanner("io", address, "--connection", connection, "--rpi", rpi, *PATIENT, "--duration", f"{SECONDS}", *options,
            quiet=True, timeout=PATIENCE)


@contextmanager
def owner():
    """A connection that produces by multicast, for those who only listen (R-CON-32)."""
    process = subprocess.Popen([BIN / "servobus-scanner", "io", address, "--connection", "standard", "--multicast",
                                "--rpi", "1", *PATIENT, "--duration", "36000"],
                               stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    try:
        time.sleep(0.5)
        yield
        check(process.poll() is None, f"the owner ended with {process.returncode} before it was told to")
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=10)


def open_all():
    """Every connection, T->O both ways where it can be."""
    for connection in OWNERS:
        io(connection)
        io(connection, "--multicast", rpi="2")
    io("input-only")
    io("input-only", "--multicast")
    with owner():
        io("listen-only", "--multicast")


def rows(file, display_filter, *fields):
    """The fields of each frame that a filter selects, all their occurrences."""
    words = [word for field in fields for word in ("-e", field)]
    text = run("tshark", "-n", "-r", file, "-Y", display_filter, "-T", "fields", *words, quiet=True, timeout=PATIENCE)
    return [dict(zip(fields, line.split("\t"))) for line in text.splitlines()]


class Direction:
    """One direction of a connection, or of several that share a multicast producer."""

    def __init__(self, name, interval, multicast, header):
        self.name, self.interval, self.multicast, self.header = name, interval, multicast, header
        self.packets = []
        self.closed = None

    def take(self, row):
        """What tshark says of a datagram, and its octets."""
        where = f"{self.name}: frame {row['frame.number']}"
        check(row["frame.protocols"].endswith("cipio") and row["enip.fwd_open_in"] and row["cip.connection"],
              f"{where} is not I/O of a connection for tshark, but {row['frame.protocols']}")
        check(bool(row["cip.32bitheader"]) == self.header, f"{where}: tshark sees another real-time format")
        ttl, dscp = (int(row[field]) for field in ("ip.ttl", "ip.dsfield.dscp"))
        check(ttl == (1 if self.multicast else 64), f"{where} has TTL {ttl}")
        check(dscp == SCHEDULED_DSCP, f"{where} has DSCP {dscp}")

        octets = bytes.fromhex(row["udp.payload"])
        head = struct.unpack_from("<HHHIIHHH", octets)
        check(head[:3] == (2, 0x8002, 8) and head[5:7] == (0x00B1, len(octets) - 18),
              f"{where} is not a sequenced address and a data item")
        check((head[4], head[7]) == (int(row["enip.cpf.sai.seq"]), int(row["cip.seq"])),
              f"{where}: tshark reads other numbers than stand there")
        self.packets.append((int(row["frame.number"]), float(row["frame.time_epoch"]), head[4], head[7], octets[20:]))

    def judge(self):
        check(len(self.packets) > 1, f"{self.name}: there are {len(self.packets)} datagrams")
        pairs = list(zip(self.packets, self.packets[1:]))
        for (_, _, number, count, data), (frame, _, next_number, next_count, next_data) in pairs:
            where = f"{self.name}: frame {frame}"
            check(next_number == (number + 1) % 2**32, f"{where} has sequence number {next_number} after {number}")
            check((next_count - count) % 2**16 in (0, 1), f"{where} has sequence count {next_count} after {count}")
            check(next_count != count or next_data == data, f"{where} has new data under the old count {count}")

        errors = sorted(abs((now[1] - before[1]) * 1e6 - self.interval) for before, now in pairs)
        span = (self.packets[-1][1] - self.packets[0][1]) * 1e6
        print(f"{self.name}: {len(self.packets)} datagrams, granted {self.interval} us, mean {span / len(pairs):.1f} us, "
              f"error p50 {errors[len(errors) // 2]:.0f} us, p99 {errors[len(errors) * 99 // 100]:.0f} us")
        # A machine that is busy makes datagrams late, and who is late sends what was missed at once, up to 16 intervals.
        # More than that were never granted.
        check(len(pairs) <= span / self.interval + 16 + 1, f"{self.name}: more datagrams than the granted interval has room for")
        check(self.closed is not None, f"{self.name} was never closed")
        # What is on its way when the request comes is the originator's affair, who hears of the end by the reply.
        check("T->O" not in self.name or self.packets[-1][0] < self.closed,
              f"{self.name}: frame {self.packets[-1][0]} comes after the reply to the Forward_Close, {self.closed}")


def agreed(file):
    """The directions that the Forward_Opens of a capture have agreed, by connection id, and how many have."""
    triad = ("cip.cm.conn_serial_num", "cip.cm.orig_serial_num")
    requests, closed, directions, opened = {}, {}, {}, 0
    for row in rows(file, "cip.cm.sc == 0x54 or cip.cm.sc == 0x4e", "frame.number", "cip.cm.sc", "cip.rr",
                    "cip.cm.fwo.type", "cip.cm.fwo.consize", "cip.connpoint", "cip.cm.ot_connid", "cip.cm.to_connid",
                    "cip.cm.otapi", "cip.cm.toapi", *triad):
        key = tuple(row[field] for field in triad)
        service, reply = row["cip.cm.sc"].split(",")[0], row["cip.rr"].split(",")[0] in ("1", "True", "0x01")
        if int(service, 0) == 0x4E:
            if reply:
                closed[key] = int(row["frame.number"])
        elif not reply:
            requests[key] = row
        elif row["cip.cm.otapi"]:
            opened += 1
            request = requests[key]
            points = [int(point, 0) for point in request["cip.connpoint"].split(",")[-2:]]
            types = [int(kind) for kind in request["cip.cm.fwo.type"].split(",")]
            name = f"{points[0]}/{points[1]}{' multicast' if types[1] == MULTICAST else ''}"
            for way, id_field, api, kind, header in (("O->T", "cip.cm.ot_connid", "cip.cm.otapi", types[0], points[0] < 254),
                                                     ("T->O", "cip.cm.to_connid", "cip.cm.toapi", types[1], False)):
                direction = directions.setdefault(int(row[id_field], 0), Direction(
                    f"{name} {way}", int(row[api].split(",")[0]), kind == MULTICAST, header))
                direction.keys = [*getattr(direction, "keys", []), key]
    for direction in directions.values():
        direction.closed = max((closed[key] for key in direction.keys if key in closed), default=None)
    return directions, opened


if "SERVOBUS_OWN_NETWORK" not in os.environ:
    # UDP 2222 is there once per address, and every scanner of this machine would like it.
    os.environ["SERVOBUS_OWN_NETWORK"] = "1"
    enter_own_network()

address = own_address()
with tempfile.TemporaryDirectory() as directory:
    capture = Path(directory, "io.pcapng")
    with running_drive(address), captured("udp port 2222 or tcp port 44818", capture):
        open_all()

    bad = rows(capture, f"{MALFORMED} or {WARNING}", "frame.number", "_ws.col.Protocol", "_ws.col.Info")
    check(not bad, f"tshark objects to {len(bad)} frames, first of all to {bad[:3]}")

    directions, opened = agreed(capture)
    check(opened == OPENED, f"{opened} connections were opened, and not {OPENED}")
    for row in rows(capture, "udp.port == 2222", "frame.number", "frame.time_epoch", "frame.protocols", "ip.ttl",
                    "ip.dsfield.dscp", "enip.cpf.sai.connid", "enip.cpf.sai.seq", "cip.seq", "cip.32bitheader",
                    "cip.connection", "enip.fwd_open_in", "udp.payload"):
        check(row["enip.cpf.sai.connid"], f"frame {row['frame.number']} at UDP 2222 has no connection id")
        connection = int(row["enip.cpf.sai.connid"], 0)
        check(connection in directions, f"frame {row['frame.number']} has an id that nobody has agreed: {connection:#x}")
        directions[connection].take(row)
    for direction in directions.values():
        direction.judge()
