"""A drive that is killed at any moment has lost no write that it has acknowledged, and its file is never half there.

Several clients write without a pause; the drive is killed (SIGKILL) at a random moment, also while it starts; the file is
looked at without the drive; the drive is started again and asked. One round in ten asks for factory defaults instead.

    SERVOBUS_KILLS=1000 python3 tests/interop/killed_drive_test.py build/bin     as many kills (60 unless given)
    SERVOBUS_SEED=7                                                              the same moments again, as far as a
                                                                                 machine can
"""

import json
import os
import random
import selectors
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

from judge import BIN, check

KILLS = int(os.environ.get("SERVOBUS_KILLS", "60"))
SEED = int(os.environ.get("SERVOBUS_SEED", str(random.SystemRandom().randrange(1 << 32))))
SERIAL = 0x00C0FFEE
LONGEST_STREAM = 0.08  # seconds of writing before a kill
PATIENCE = 20.0
AHEAD = 4  # requests of one client that wait for their replies

REGISTER, SEND_RR_DATA = 0x65, 0x6F
GET, SET, RESET = 0x0E, 0x10, 0x05


def dint(value):
    return struct.pack("<i", value)


def uint(value):
    return struct.pack("<H", value)


def cip_string(text):
    return uint(len(text)) + text.encode() + b"\0" * (len(text) % 2)


class Cell:
    """An attribute that one client writes: one value after the other, so that each tells when it was written."""

    def __init__(self, path, encode, values, delivered):
        self.path, self.encode, self.values = bytes.fromhex(path), encode, values
        self.kept = encode(delivered)  # what must be there at least
        self.delivered = self.kept
        self.under_way = []  # what may be there instead: sent, and not acknowledged
        self.written = 0

    def next_value(self):
        self.written += 1
        return self.encode(self.values(self.written))

    def found(self, value):
        check(value == self.kept or value in self.under_way,
              f"{self.path.hex(' ')} is {value.hex(' ')}; acknowledged was {self.kept.hex(' ')}, under way were "
              f"{[each.hex(' ') for each in self.under_way]}")
        survived = value != self.kept
        self.kept, self.under_way = value, []
        return survived


CELLS = [
    Cell("20 66 24 01 30 41", dint, lambda n: 1000 + n, 100_000),  # speed
    Cell("20 66 24 01 30 43", dint, lambda n: 20_000 + n, 1_000_000),  # acceleration
    Cell("20 F5 24 01 30 06", cip_string, lambda n: f"drive-{n}", ""),  # host name
    Cell("20 F5 24 01 30 0D", uint, lambda n: 600 + n % 3000, 120),  # inactivity timeout
    Cell("20 64 24 01 30 00", dint, lambda n: 1 + n % 100, 20),  # S-curve
]


def frame(command, session, data):
    return struct.pack("<HHII8sI", command, len(data), session, 0, b"kill-tst", 0) + data


def request(session, service, path, data=b""):
    message = bytes([service, len(path) // 2]) + path + data
    items = struct.pack("<IHHHHHH", 0, 0, 2, 0, 0, 0xB2, len(message)) + message
    return frame(SEND_RR_DATA, session, items)


class Client:
    """One session."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.received = b""
        self.socket.sendall(frame(REGISTER, 0, b"\1\0\0\0"))
        self.session = struct.unpack_from("<I", self.whole_frame(), 4)[0]

    def frames(self):
        """The frames that have come whole."""
        while len(self.received) >= 24:
            size = 24 + struct.unpack_from("<H", self.received, 2)[0]
            if len(self.received) < size:
                return
            whole, self.received = self.received[:size], self.received[size:]
            yield whole

    def whole_frame(self):
        while True:
            for whole in self.frames():
                return whole
            more = self.socket.recv(65536)
            if not more:
                raise ConnectionError("closed")
            self.received += more

    def send(self, service, path, data=b""):
        self.socket.sendall(request(self.session, service, path, data))

    def call(self, service, path, data=b""):
        self.send(service, path, data)
        return reply_of(self.whole_frame())


def reply_of(whole):
    """General status and data of a message router reply."""
    check(struct.unpack_from("<I", whole, 8)[0] == 0, f"encapsulation status in {whole.hex(' ')}")
    message = whole[24 + 16:]
    return message[2], message[4 + 2 * message[3]:]


class Drive:
    """The program, which has said that it listens."""

    def __init__(self, directory):
        self.log = open(directory.parent / "log", "w+", encoding="utf-8")
        self.process = subprocess.Popen(
            [BIN / "servobus-adapter", "--port", "0", "--state", directory, "--serial", str(SERIAL), "--ready-json"],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self.log)

    def port(self):
        line = self.process.stdout.readline()
        check(line, "the drive does not start:\n" + self.said())
        return json.loads(line)["drives"][0]["port"]

    def said(self):
        self.log.seek(0)
        return self.log.read()

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait(PATIENCE)
        self.process.stdout.close()
        said = self.said()
        self.log.close()
        check("of no use" not in said and "cannot be stored" not in said, "the drive complains:\n" + said)


def stream(port, seconds):
    """Each client writes its cell until the time is over; returns how many writes were acknowledged."""
    selector = selectors.DefaultSelector()
    for cell in CELLS:
        client = Client(port)
        client.socket.setblocking(False)
        selector.register(client.socket, selectors.EVENT_READ, (client, cell))
        for _ in range(AHEAD):
            write(client, cell)
    acknowledged = 0
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        for key, _ in selector.select(left):
            client, cell = key.data
            client.received += client.socket.recv(65536)
            for whole in client.frames():
                status, _ = reply_of(whole)
                check(status == 0, f"a write was refused with 0x{status:02X}")
                cell.kept = cell.under_way.pop(0)
                acknowledged += 1
                write(client, cell)
    return acknowledged, selector


def write(client, cell):
    value = cell.next_value()
    cell.under_way.append(value)
    client.send(SET, cell.path, value)


def take_late(selector):
    """What the drive had sent before it was killed counts as well."""
    late = 0
    for key in list(selector.get_map().values()):
        client, cell = key.data
        client.socket.settimeout(PATIENCE)
        try:
            while more := client.socket.recv(65536):
                client.received += more
        except ConnectionError:
            pass
        for whole in client.frames():
            check(reply_of(whole)[0] == 0, "a write was refused")
            cell.kept = cell.under_way.pop(0)
            late += 1
        client.socket.close()
    selector.close()
    return late


def look_at_file(directory):
    """Without the drive: the line, its length, its CRC-32, and JSON."""
    file = directory / f"drive-{SERIAL:08X}.state"
    if not file.exists():
        return
    head, payload = file.read_bytes().split(b"\n", 1)
    magic, version, checksum, size = head.split()
    check((magic, version) == (b"servobus-state", b"1"), f"the file begins with {head}")
    check(int(size) == len(payload), f"the file should have {int(size)} octets and has {len(payload)}")
    check(int(checksum, 16) == zlib.crc32(payload), "the checksum of the file is wrong")
    json.loads(payload)


def ask(port, counts):
    client = Client(port)
    status, word = client.call(GET, bytes.fromhex("20 01 24 01 30 05"))
    check(status == 0 and word[0] & 0xF0 == 0x30, f"the Identity says {word.hex(' ')}")
    values = []
    for cell in CELLS:
        status, value = client.call(GET, cell.path)
        check(status == 0, f"a read was refused with 0x{status:02X}")
        values.append(value)
    client.socket.close()
    if counts.pop("undecided", False):
        outcomes = {value == cell.delivered for cell, value in zip(CELLS, values) if cell.kept != cell.delivered}
        check(len(outcomes) < 2, "some cells are as delivered, and others are not")
    for cell, value in zip(CELLS, values):
        counts["survived"] += cell.found(value)


def reset(port, chance, counts):
    """Factory defaults, and a kill while they are on their way. Until they are acknowledged both states are right, but
    not a mixture."""
    client = Client(port)
    client.send(RESET, bytes.fromhex("20 01 24 01"), b"\1")
    client.socket.settimeout(chance.uniform(0, 2 * LONGEST_STREAM))
    try:
        check(reply_of(client.whole_frame())[0] == 0, "factory defaults were refused")
        for cell in CELLS:
            cell.kept, cell.under_way = cell.delivered, []
        counts["resets"] += 1
        time.sleep(chance.uniform(0, 2 * LONGEST_STREAM))
    except (TimeoutError, socket.timeout, BlockingIOError):
        for cell in CELLS:
            cell.under_way = [cell.delivered]
        counts["undecided"] = True
    return client


def one_kill(directory, chance, counts):
    drive = Drive(directory)
    if chance.random() < 0.1:
        time.sleep(chance.uniform(0, 0.05))  # while it starts
        drive.kill()
        counts["early"] += 1
        return
    port = drive.port()
    ask(port, counts)
    if chance.random() < 0.1:
        client = reset(port, chance, counts)
        drive.kill()
        client.socket.close()
        return
    acknowledged, selector = stream(port, chance.uniform(0, LONGEST_STREAM))
    drive.kill()
    counts["acknowledged"] += acknowledged + take_late(selector)
    counts["lost"] += sum(len(cell.under_way) for cell in CELLS)


def main():
    print(f"{KILLS} kills, SERVOBUS_SEED={SEED}", flush=True)
    chance = random.Random(SEED)
    counts = dict.fromkeys(("acknowledged", "lost", "survived", "resets", "early"), 0)
    top = Path(tempfile.mkdtemp(prefix="servobus-killed-"))
    begin = time.monotonic()
    try:
        for _ in range(KILLS):
            one_kill(top / "state", chance, counts)
            look_at_file(top / "state")
        drive = Drive(top / "state")
        ask(drive.port(), counts)
        drive.kill()
        others = sorted(file.name for file in (top / "state").iterdir())
        check(set(others) <= {"lock", f"drive-{SERIAL:08X}.state", f"drive-{SERIAL:08X}.state.new", "trial.new"},
              f"there are other files: {others}")
    finally:
        shutil.rmtree(top)
    check(counts["acknowledged"] > KILLS, "hardly anything was written")
    print(f"{KILLS} kills in {time.monotonic() - begin:.0f} s, {counts['early']} of them while the drive started: "
          f"{counts['acknowledged']} writes and {counts['resets']} resets were acknowledged and none is lost; of "
          f"{counts['lost']} writes under way, {counts['survived']} cells had a later one")


if __name__ == "__main__":
    sys.exit(main())
