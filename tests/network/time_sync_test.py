#!/usr/bin/env python3
"""The Time Sync object beside real PTP: a grandmaster and a slave, each a ptp4l in a namespace of its own, and the drive
beside the slave. What the drive tells by the wire is compared with what pmc is told by the same ptp4l.

    time_sync_test.py DIRECTORY_OF_THE_PROGRAMS LIBRARY

The library (untouched_clock.cpp) is preloaded into both ptp4l: the clock of the machine is not changed. So this is not
about how well a clock is kept right, which is ptp4l's business; both have the same clock, and find that they do.
"""

import os
import re
import shutil
import struct
import sys
import tempfile
import time
from pathlib import Path

from lan import BIN, Client, Session, check, enter_own_world, run_beside_each_other, skip, wait_for

LIBRARY = Path(sys.argv[2]).absolute() if len(sys.argv) > 2 else BIN.parent / "tests" / "network" / "untouched_clock.so"
TIME_SYNC = 0x43
LISTENING, SLAVE = 4, 9
NO_STEPS = 65535
PATIENCE = 20  # s, on a busy machine

# Eight synchronisations a second; a servo that has an opinion after the second one and never jumps.
FAST = """[global]
time_stamping software
logAnnounceInterval -2
logSyncInterval -3
logMinDelayReqInterval -3
announceReceiptTimeout 8
pi_proportional_const 0.7
pi_integral_const 0.3
first_step_threshold 0
step_threshold 0
"""


class Ptp:
    """ptp4l at eth0 of a host."""

    def __init__(self, host, settings):
        self.host = host
        self.socket = host.lan.directory / f"{host.name}.ptp"
        configuration = host.lan.directory / f"{host.name}.ptp.conf"
        configuration.write_text(f"{FAST}{settings}uds_address {self.socket}\n")
        self.process = host.start("env", f"LD_PRELOAD={LIBRARY}", "ptp4l", "-m", "-i", "eth0", "-f", configuration)

    def ask(self, *names):
        """What pmc prints of these data sets: name to value."""
        own = self.host.lan.directory / f"{self.host.name}.pmc"
        done = self.host.run("pmc", "-u", "-b", "0", "-s", self.socket, "-i", own, *(f"GET {name}" for name in names))
        return dict(re.findall(r"^\t\t(\S+) +(\S+)$", done.stdout, re.MULTILINE))

    def state(self):
        return self.ask("PORT_DATA_SET").get("portState")

    def stop(self):
        self.host.stop(self.process)


class Reader:
    """Reads attributes of 0x43 by the wire, and sets the one that a test needs."""

    def __init__(self, host, address):
        self.client = Client(host, address)

    def attributes(self, *numbers):
        """Of one moment: a session reads them one after the other."""
        printed = self.client.scanner("get", *(f"{TIME_SYNC:#x}/1/{number}" for number in numbers)).splitlines()
        return [bytes.fromhex(line.partition("=")[2]) for line in printed]

    def set_max_offset(self, nanoseconds):
        session = Session(self.client.host, self.client.address)
        session.set(TIME_SYNC, 6, struct.pack("<Q", nanoseconds))
        session.close()

    def is_synchronized(self):
        return self.attributes(2) == [b"\1"]


def identity(text):
    """`5e88d9.fffe.77a0b1`, as pmc writes it."""
    return bytes.fromhex(text.replace(".", "").partition("-")[0])


def check_told_alone(reader):
    """Nobody answers: a clock that hears of no other (docs/adapter.md)."""
    synchronized, grandmaster, local, ports, states, steps = reader.attributes(2, 8, 10, 11, 12, 27)
    check(synchronized == b"\0", "it is synchronised without PTP")
    check(grandmaster[:8] == local[:8], "it is not its own grandmaster")
    check(ports == b"\0\0" and states == b"\0\0", f"it has PTP ports: {ports.hex()}, {states.hex()}")
    check(steps == struct.pack("<H", NO_STEPS), f"steps removed {steps.hex()}")


def check_time(reader):
    """System time is the clock of this machine, which shows UTC: this grandmaster's time scale is its own."""
    before = time.time_ns()
    microseconds, nanoseconds, both = reader.attributes(3, 4, 28)
    after = time.time_ns()
    told = struct.unpack("<Q", nanoseconds)[0]
    tolerance = 50_000_000  # ns: a machine under load may be held up between two readings
    check(before - tolerance <= told <= after + tolerance, f"the time is {told} and not {before} to {after}")
    micro = struct.unpack("<Q", microseconds)[0] * 1000
    check(before - tolerance <= micro <= after + tolerance, f"the time is {micro} and not {before} to {after}")
    ahead = (time.time_ns() - time.clock_gettime_ns(time.CLOCK_MONOTONIC)) // 1000
    offset = struct.unpack("<QQ", both)[1]
    check(abs(offset - ahead) < tolerance // 1000, f"the offset is {offset} and not {ahead}")


def check_compared(reader, slave):
    """What does not change while it is looked at is the same; what does is of the same size."""
    told = slave.ask("DEFAULT_DATA_SET", "CURRENT_DATA_SET", "PARENT_DATA_SET", "TIME_PROPERTIES_DATA_SET",
                     "PORT_DATA_SET")
    grandmaster, parent, local = reader.attributes(8, 9, 10)
    check(grandmaster == identity(told["grandmasterIdentity"]) + struct.pack(
        "<8H", int(told["gm.ClockClass"]), int(told["gm.ClockAccuracy"], 16), int(told["gm.OffsetScaledLogVariance"], 16),
        int(told["currentUtcOffset"]), int(told["ptpTimescale"]) << 3 | int(told["currentUtcOffsetValid"]) << 2,
        int(told["timeSource"], 16), int(told["grandmasterPriority1"]), int(told["grandmasterPriority2"])),
        f"grandmaster info {grandmaster.hex()} and not {told}")
    check(parent == identity(told["parentPortIdentity"]) + struct.pack(
        "<HHI", int(told["parentPortIdentity"].rpartition("-")[2]),
        int(told["observedParentOffsetScaledLogVariance"], 16),
        int(told["observedParentClockPhaseChangeRate"], 16)), f"parent info {parent.hex()} and not {told}")
    check(local[:14] == identity(told["clockIdentity"]) + struct.pack(
        "<3H", int(told["clockClass"]), int(told["clockAccuracy"], 16), int(told["offsetScaledLogVariance"], 16)),
        f"local clock info {local.hex()} and not {told}")
    values = reader.attributes(11, 12, 13, 14, 15, 16, 17, 18, 19, 27)
    wanted = [struct.pack("<H", 1), struct.pack("<3H", 1, 1, SLAVE), struct.pack("<3H", 1, 1, 1),
              struct.pack("<2Hh", 1, 1, int(told["logAnnounceInterval"])),
              struct.pack("<2Hh", 1, 1, int(told["logSyncInterval"])), bytes([int(told["priority1"])]),
              bytes([int(told["priority2"])]), bytes([int(told["domainNumber"])]),
              struct.pack("<H", 0x0180),  # ordinary clock, slave only
              struct.pack("<H", int(told["stepsRemoved"]))]
    check(values == wanted, f"{[value.hex() for value in values]} and not {[value.hex() for value in wanted]}")
    offset, delay = (struct.unpack("<q", value)[0] for value in reader.attributes(5, 7))
    largest = 50_000_000  # ns: nothing on this machine takes so long, and a wrong unit is found
    check(abs(offset) < largest and abs(delay) < largest, f"offset {offset} ns, delay {delay} ns")
    return offset, delay


def grandmaster_comes_and_goes(lan):
    """0x43 before there is ptp4l, without a master, with one, and afterwards"""
    master_host = lan.host("grandmaster", "10.79.0.1/24")
    host = lan.host("drive", "10.79.0.5/24")
    scanner = lan.host("scanner", "10.79.0.9/24")
    slave_socket = lan.directory / f"{host.name}.ptp"
    drive = host.start(BIN / "servobus-adapter", "--bind", "10.79.0.5", "--time-sync", "--ptp-socket", slave_socket,
                       "--log-level", "debug")
    wait_for("the drive", lambda: "listens at" in drive.log.read_text(), 10)
    reader = Reader(scanner, "10.79.0.5")
    check_told_alone(reader)
    check_time(reader)
    # A machine under load is no reason for a clock to be off.
    reader.set_max_offset(10**9)

    slave = Ptp(host, "slaveOnly 1\n")
    wait_for("a port that listens", lambda: reader.attributes(12) == [struct.pack("<3H", 1, 1, LISTENING)], PATIENCE)
    check(not reader.is_synchronized(), "it is synchronised without a master")

    master = Ptp(master_host, "priority1 10\nfree_running 1\n")
    wait_for("a slave", lambda: slave.state() == "SLAVE", PATIENCE)
    wait_for("that it is synchronised", reader.is_synchronized, PATIENCE)
    own = master.ask("DEFAULT_DATA_SET")["clockIdentity"]
    check(reader.attributes(8)[0][:8] == identity(own), f"the grandmaster is not {own}")
    offset, delay = check_compared(reader, slave)
    check_time(reader)
    reader.set_max_offset(1)
    wait_for("that 1 ns is too near", lambda: not reader.is_synchronized(), PATIENCE)
    reader.set_max_offset(10**9)
    wait_for("that 1 s is not", reader.is_synchronized, PATIENCE)

    master.stop()
    wait_for("that the master is missed", lambda: not reader.is_synchronized(), PATIENCE)
    steps, states = reader.attributes(27, 12)
    check(steps == struct.pack("<H", NO_STEPS), f"steps removed {steps.hex()}")
    check(states[:4] == struct.pack("<2H", 1, 1) and states[4] != SLAVE, f"port state {states.hex()}")
    again = Ptp(master_host, "priority1 10\nfree_running 1\n")
    wait_for("that it is synchronised again", reader.is_synchronized, PATIENCE)
    slave.stop()
    wait_for("that ptp4l is missed", lambda: not reader.is_synchronized(), PATIENCE)
    check_told_alone(reader)
    again.stop()
    return f"{offset} ns off, {delay} ns away"


if __name__ == "__main__":
    if os.geteuid() != 0:
        skip("ptp4l takes time stamps as root only")
    for tool in ("ptp4l", "pmc"):
        if not shutil.which(tool):
            skip(f"{tool} is not there; scripts/install-dependencies test installs it")
    enter_own_world("ptp4l", "pmc")
    with tempfile.TemporaryDirectory() as directory:
        run_beside_each_other([grandmaster_comes_and_goes], Path(directory))
