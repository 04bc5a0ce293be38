"""Whoever is ended by a signal leaves the other in the state that docs/adapter.md names ("When one of the two ends").

    python3 tests/interop/killed_peers_test.py build/bin
"""

import json
import os
import random
import signal
import subprocess
import sys
import time

from judge import BIN, check, own_address, run, running_drive, scanner

# Those that end a process, and whether the scanner has something to say about it first.
IN_ORDER = [signal.SIGINT, signal.SIGTERM]
AT_ONCE = [signal.SIGKILL, signal.SIGHUP, signal.SIGQUIT, signal.SIGABRT, signal.SIGSEGV, signal.SIGALRM, signal.SIGUSR1]
LOST = 3  # exit code of the scanner
PATIENCE = 10.0
# A drive may be gone before its first datagram. Its owner waits as long for that one as the standard has it, and then ends.
FIRST_DATAGRAM = 10.0
SEED = int(os.environ.get("SERVOBUS_SEED", str(random.SystemRandom().randrange(1 << 32))))


def identity(address):
    return scanner("identity", address, quiet=True)


def values(address, *names):
    said = json.loads(scanner("get", address, *names, "--json", quiet=True))
    return {each["name"]: each["value"] for each in said["values"]}


def wait_until(condition, sentence):
    deadline = time.monotonic() + PATIENCE
    while not condition():
        check(time.monotonic() < deadline, sentence)
        time.sleep(0.02)


def stands(address):
    first = values(address, "PositionActualValue")
    time.sleep(0.05)
    return first == values(address, "PositionActualValue")


def start_moving(address, target):
    mover = subprocess.Popen([BIN / "servobus-scanner", "axis", address, "move", str(target), "--io", "--speed", "20000"],
                             stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wait_until(lambda: mover.poll() is None and not stands(address), "the axis does not begin to move")
    return mover


def end(process, number):
    process.send_signal(number)
    try:
        return process.wait(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        sys.exit(f"FAILED: a scanner did not end within {PATIENCE:.0f} s of {number.name}")


def scanner_ends(address, number, rng):
    target = rng.choice([60000, 80000])
    mover = start_moving(address, target)
    time.sleep(rng.random() / 4)
    code = end(mover, number)
    # On a machine that is held up the connection may be lost before the signal comes; that ends the same.
    if number in AT_ONCE and code != LOST:
        check(code == -number, f"a scanner ended by {number.name} has exit code {code}")
    wait_until(lambda: "owned" not in identity(address), f"after {number.name} the connection of its owner stays open")
    wait_until(lambda: stands(address), f"after {number.name} the axis goes on moving")
    check(abs(values(address, "PositionActualValue")["PositionActualValue"] - target) > 100,
          f"after {number.name} the motion went on to its end")
    status = scanner("axis", address, "status", quiet=True)
    check("Quick stop active" in status, f"after {number.name} the drive is not in Quick stop active:\n{status}")
    scanner("axis", address, "enable", quiet=True)
    scanner("axis", address, "move", "0", "--speed", "400000", quiet=True)


def drive_ends(address, number, options, expected):
    """An I/O connection and an explicit request at the moment at which the drive is gone."""
    drive = subprocess.Popen([BIN / "servobus-adapter", "--bind", address, "--log-level", "error"],
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
    try:
        drive.stdout.readline()
        owner = subprocess.Popen([BIN / "servobus-scanner", "io", address, "--rpi", "5", "--no-reopen", *options],
                                 stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        wait_until(lambda: "owned" in identity(address), "nobody owns the drive")
        drive.send_signal(number)
        drive.wait(timeout=PATIENCE)
        words = owner.communicate(timeout=FIRST_DATAGRAM + PATIENCE)[1]
        check(owner.returncode == expected, f"after the drive's {number.name} the owner ended with {owner.returncode}: {words}")
        check("was lost" in words, f"after the drive's {number.name} the owner said: {words}")
        run(BIN / "servobus-scanner", "get", address, "Statusword", expect=3, quiet=True)
    finally:
        if drive.poll() is None:
            drive.kill()
            drive.wait()
        drive.stdout.close()


def main():
    print("seed", SEED)
    rng = random.Random(SEED)
    address = own_address()
    with running_drive(address, "--log-level", "error"):
        scanner("axis", address, "reference", quiet=True)
        scanner("axis", address, "move", "0", quiet=True)
        for number in IN_ORDER + AT_ONCE:
            scanner_ends(address, number, rng)
    for number in IN_ORDER + AT_ONCE:
        # At once again at the same address: nothing of the one before is left.
        drive_ends(address, number, [], expected=3)
    print("ended by", ", ".join(number.name for number in IN_ORDER + AT_ONCE))


main()
