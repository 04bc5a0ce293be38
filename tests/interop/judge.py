"""What every judge needs: a running drive on an address of its own, and programs run with their output shown."""

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

PORT = 44818
HERE = Path(__file__).resolve().parent
BIN = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parents[1] / "build" / "bin"


def own_address():
    """A loopback address that no other running judge has."""
    number = os.getpid() & 0xFFFF
    return f"127.77.{number >> 8}.{number & 0xFF}"


def check(condition, sentence):
    if not condition:
        sys.exit(f"FAILED: {sentence}")


def run(*command, expect=0):
    """Runs a program that must exit with `expect`, shows what it printed, and returns its standard output."""
    print("$", *command, flush=True)
    try:
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=40,
                              stdin=subprocess.DEVNULL)
    except FileNotFoundError:
        sys.exit(f"FAILED: {command[0]} is not there; scripts/test installs and builds what the judges need")
    print(done.stdout, done.stderr, sep="", flush=True)
    check(done.returncode == expect, f"{command[0]} ended with {done.returncode} and not with {expect}")
    return done.stdout


def scanner(*words, expect=0):
    return run(BIN / "servobus-scanner", *words, expect=expect)


def answers(address):
    try:
        socket.create_connection((address, PORT), timeout=1).close()
        return True
    except OSError:
        return False


@contextmanager
def running_drive(address, *options):
    """A virtual drive that listens on `address`; afterwards it must end well when it is told to."""
    program = BIN / "servobus-adapter"
    check(program.exists(), f"{program} is not there; build it first")
    drive = subprocess.Popen([program, "--bind", address, "--port", str(PORT), *options], stdin=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 20
        while not answers(address):
            check(drive.poll() is None, f"the drive ended with {drive.returncode} before it listened")
            check(time.monotonic() < deadline, f"the drive does not listen on {address}:{PORT}")
            time.sleep(0.05)
        yield
        check(drive.poll() is None, f"the drive ended with {drive.returncode} while it was in use")
        drive.send_signal(signal.SIGTERM)
        try:
            drive.wait(timeout=10)
        except subprocess.TimeoutExpired:
            sys.exit("FAILED: the drive did not stop within 10 s of SIGTERM")
        check(drive.returncode == 0, f"the drive ended with {drive.returncode} after SIGTERM")
    finally:
        if drive.poll() is None:
            drive.kill()
            drive.wait()
