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


def enter_own_network():
    """Starts this judge again in a network that nobody else is in, where it owns every port and may capture."""
    rights = [] if os.geteuid() == 0 else ["--map-root-user"]
    os.execvp("unshare", ["unshare", *rights, "--net", "sh", "-c", 'ip link set lo up && exec "$@"', "sh",
                          sys.executable, "-B", "-u", *sys.argv])


def run(*command, expect=0, quiet=False, timeout=40):
    """Runs a program that must exit with `expect`, shows what it printed, and returns its standard output."""
    print("$", *command, flush=True)
    try:
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=timeout,
                              stdin=subprocess.DEVNULL)
    except FileNotFoundError:
        sys.exit(f"FAILED: {command[0]} is not there; scripts/test installs and builds what the judges need")
    print("" if quiet else done.stdout, done.stderr, sep="", flush=True)
    check(done.returncode == expect, f"{command[0]} ended with {done.returncode} and not with {expect}")
    return done.stdout


def scanner(*words, **how):
    return run(BIN / "servobus-scanner", *words, **how)


def answers(address):
    try:
        socket.create_connection((address, PORT), timeout=1).close()
        return True
    except OSError:
        return False


@contextmanager
def captured(capture_filter, file):
    """Captures what of the loopback interface the filter of dumpcap selects."""
    dumpcap = subprocess.Popen(["dumpcap", "-q", "-B", "64", "-i", "lo", "-f", capture_filter, "-w", file],
                               stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        said = []
        while not (said and said[-1].startswith("File:")):
            line = dumpcap.stderr.readline()
            check(line, "the loopback interface cannot be captured; it takes root, or a kernel that grants "
                        "network namespaces to everybody:\n" + "".join(said))
            said.append(line)
        time.sleep(0.5)
        yield
        time.sleep(0.5)
    finally:
        dumpcap.send_signal(signal.SIGINT)
        summary = dumpcap.communicate(timeout=10)[1]
    print(summary)
    check("dropped" not in summary or "(pcap:0/" in summary, "the capture dropped packets")


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
