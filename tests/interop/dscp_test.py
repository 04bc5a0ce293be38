#!/usr/bin/env python3
"""The DSCP of what an adapter and a scanner send, as a capture sees it (R-QOS-5).

Class 1 data by its priority, and everything at TCP and UDP 44818 as explicit messages. Other values count from the next
restart of the drive on, and not before (R-QOS-4).
"""

import os
import tempfile
import time
from pathlib import Path

from judge import captured, check, enter_own_network, own_address, run, running_drive, scanner

PRIORITIES = ("urgent", "scheduled", "high", "low")
USUAL = {"urgent": 55, "scheduled": 47, "high": 43, "low": 31, "explicit": 27}
CHOSEN = {"urgent": 1, "scheduled": 2, "high": 3, "low": 4, "explicit": 5}
ATTRIBUTES = {"urgent": 4, "scheduled": 5, "high": 6, "low": 7, "explicit": 8}
FIELDS = ("frame.number", "ip.src", "ip.dsfield.dscp", "tcp.srcport", "tcp.len", "tcp.flags.syn", "udp.srcport",
          "udp.dstport", "enip.cpf.sai.connid")


def traffic():
    """Explicit messages over TCP and UDP, and I/O data of each priority in turn."""
    scanner("get", address, "SCurve", quiet=True)
    scanner("discover", "--host", address, quiet=True)
    for priority in PRIORITIES:
        scanner("io", address, "--connection", "standard", "--rpi", "5", "--multiplier", "512", "--priority", priority,
                "--duration", "0.2", quiet=True)


def seen(file):
    """The DSCP values of a capture: of explicit messages by sender and protocol, of I/O data by direction in the order
    in which its connections appear."""
    words = [word for field in FIELDS for word in ("-e", field)]
    text = run("tshark", "-n", "-r", file, "-T", "fields", *words, quiet=True)
    explicit, data = {}, {True: {}, False: {}}
    for line in text.splitlines():
        row = dict(zip(FIELDS, line.split("\t")))
        from_drive, dscp = row["ip.src"] == address, int(row["ip.dsfield.dscp"])
        if row["enip.cpf.sai.connid"]:
            data[from_drive].setdefault(row["enip.cpf.sai.connid"], set()).add(dscp)
        elif "44818" in (row["udp.srcport"], row["udp.dstport"]):
            explicit.setdefault((from_drive, "UDP"), set()).add(dscp)
        elif row["tcp.srcport"] and (int(row["tcp.len"]) > 0 or from_drive and row["tcp.flags.syn"] in ("1", "True")):
            # The handshake of a client is the system's, which does not know yet what the connection is for.
            explicit.setdefault((from_drive, "TCP"), set()).add(dscp)
    return explicit, {who: list(values.values()) for who, values in data.items()}


def judge(name, expected):
    file = Path(directory, f"{name}.pcapng")
    with captured("tcp port 44818 or udp port 44818 or udp port 2222", file):
        traffic()
    explicit, data = seen(file)
    print(f"{name}: explicit {explicit}, T->O {data[True]}, O->T {data[False]}")
    for protocol in ("TCP", "UDP"):
        check(explicit.get((True, protocol)) == {expected["explicit"]},
              f"{name}: the drive's {protocol} messages have {explicit.get((True, protocol))}")
        check(explicit.get((False, protocol)) == {USUAL["explicit"]},
              f"{name}: the scanner's {protocol} messages have {explicit.get((False, protocol))}")
    for who, values in ((True, expected), (False, USUAL)):
        check(data[who] == [{values[priority]} for priority in PRIORITIES],
              f"{name}: {'T->O' if who else 'O->T'} data of {', '.join(PRIORITIES)} has {data[who]}")


if "SERVOBUS_OWN_NETWORK" not in os.environ:
    os.environ["SERVOBUS_OWN_NETWORK"] = "1"
    enter_own_network()

address = own_address()
with tempfile.TemporaryDirectory() as directory, running_drive(address):
    judge("usual", USUAL)
    for name, value in CHOSEN.items():
        scanner("set", address, f"0x48/1/{ATTRIBUTES[name]}=USINT:{value}", quiet=True)
    judge("chosen", USUAL)
    scanner("call", address, "Reset", "1/1", quiet=True)
    time.sleep(0.5)
    judge("restarted", CHOSEN)
