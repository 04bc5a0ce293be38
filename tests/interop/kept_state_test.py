"""What a drive keeps, seen from outside the program: the next process has it, a second process may not use it, a disk that
is full refuses a write, a file that is of no use is kept aside.

    python3 tests/interop/kept_state_test.py build/bin
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from judge import BIN, PORT, check, own_address, run, running_drive, scanner

ADDRESS = own_address()


def value(what):
    return json.loads(scanner("get", ADDRESS, what, "--json", quiet=True))["values"][0]["value"]


def identity():
    return json.loads(scanner("identity", ADDRESS, "--json", quiet=True))["identity"]


def refused_to_start(expected, *options):
    done = subprocess.run([BIN / "servobus-adapter", "--bind", ADDRESS, "--port", "0", *options], capture_output=True,
                          text=True, timeout=20, stdin=subprocess.DEVNULL)
    print("$ servobus-adapter", *options, "\n", done.stderr, sep=" ", flush=True)
    check(done.returncode == 2, f"the program ended with {done.returncode} and not with 2")
    check(expected in done.stderr, f"it does not say '{expected}'")
    check(done.stderr.count("\n") == 1, "it says more than one line")


def process_at(address):
    """The process that listens there."""
    listing = run("ss", "-Htlnp", f"src {address}:{PORT}", quiet=True)
    return listing.split("pid=")[1].split(",")[0]


def next_process(state):
    with running_drive(ADDRESS, "--state", state, "--serial", "0x1267"):
        check(identity()["serial_number"] == 0x1267, "--serial does not count")
        scanner("set", ADDRESS, "SCurve=35", "SID=press 7", "@0xF5/1/6=hex:02 00 61 62")
        refused_to_start("is another servobus-adapter's, process ", "--state", state)
    check((state / "drive-00001267.state").exists(), "there is no file")
    with running_drive(ADDRESS, "--state", state, "--serial", "4711"):
        check(value("SCurve") == 35 and value("SID") == "press 7", "the next process has other values")
        host_name = scanner("call", ADDRESS, "0x0E", "0xF5/1/6", "--json", quiet=True)
        check("02 00 61 62" in host_name, "the next process has another host name")
        check(identity()["status"] & 0x00F4 == 0x0034, "the Identity does not say that it is configured")
    with running_drive(ADDRESS, "--state", state, "--serial", "4712"):
        check(value("SCurve") == 20, "another drive has what this one keeps")


def full_disk(state):
    with running_drive(ADDRESS, "--state", state, "--serial", "4711"):
        process = process_at(ADDRESS)
        run("prlimit", "--pid", process, "--fsize=10:unlimited", quiet=True)
        refusal = run(BIN / "servobus-scanner", "set", ADDRESS, "SCurve=77", "--json", expect=4)
        check('"general": 25' in refusal, "the write is not refused with 0x19")
        check(value("SCurve") == 35, "the write that was refused is in force")
        scanner("get", ADDRESS, "TS")
        run("prlimit", "--pid", process, "--fsize=unlimited:unlimited", quiet=True)
        scanner("set", ADDRESS, "SCurve=78")
    with running_drive(ADDRESS, "--state", state, "--serial", "4711"):
        check(value("SCurve") == 78, "what was written afterwards is not there")


def useless_file(state):
    file = state / "drive-00001267.state"
    whole = file.read_bytes()
    file.write_bytes(whole[:-3])
    with running_drive(ADDRESS, "--state", state, "--serial", "4711"):
        check((state / "drive-00001267.state.damaged-1").read_bytes() == whole[:-3], "the file is not kept aside")
        check(identity()["status"] & 0x00F0 == 0x0040, "the Identity does not say that the configuration is bad")
        check(value("SCurve") == 20, "the drive is not as delivered")
        scanner("set", ADDRESS, "SCurve=30")
        check(identity()["status"] & 0x00F4 == 0x0034, "the Identity still says so")
    file.write_bytes(whole)
    with running_drive(ADDRESS, "--state", state, "--serial", "4711"):
        check(value("SCurve") == 78, "a file that was put back is not taken")


def several_drives(state):
    first, second = ADDRESS, ADDRESS.rsplit(".", 1)[0] + "." + str(int(ADDRESS.rsplit(".", 1)[1]) ^ 1)
    with running_drive(first, "--bind", second, "--state", state, "--serial", "100"):
        scanner("set", first, "SCurve=40")
        scanner("set", second, "SCurve=41")
    for number in (100, 101):
        check((state / f"drive-{number:08X}.state").exists(), f"drive {number} has no file")


def main():
    top = Path(tempfile.mkdtemp(prefix="servobus-kept-"))
    try:
        state = top / "state"
        next_process(state)
        full_disk(state)
        useless_file(state)
        several_drives(state)
        refused_to_start("No such file or directory", "--state", str(top / "missing" / "state"))
        (top / "file").write_text("text", encoding="utf-8")
        refused_to_start("Not a directory", "--state", str(top / "file"))
        refused_to_start("there are no 2 serial numbers from 4294967295 on", "--serial", "0xFFFFFFFF", "--count", "2")
    finally:
        shutil.rmtree(top)
    print("What is set is kept, and what cannot be is refused.")


if __name__ == "__main__":
    sys.exit(main())
