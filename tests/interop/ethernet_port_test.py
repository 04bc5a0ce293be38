#!/usr/bin/env python3
"""What a drive tells of its Ethernet port on a real interface: the Ethernet Link object (R-ETH) beside what the kernel
says of the same interface, in a network of two ends that this judge makes itself."""

import json
import os
import signal
import subprocess
import time

from judge import BIN, check, enter_own_network, run, running_drive

DRIVE, CLIENT, MAC = "10.77.0.1", "10.77.0.2", "02:11:22:33:44:55"
IN_OCTETS, IN_UNICAST, OUT_OCTETS, OUT_UNICAST = 0, 1, 6, 7
LOOK = 0.15  # the drive looks at its interface at most every 100 ms


def there(*command, **how):
    """Runs a program at the other end of the cable."""
    return run("nsenter", f"--net=/proc/{other.pid}/ns/net", *command, **how)


def attribute(number, instance=1):
    time.sleep(LOOK)
    answer = json.loads(there(BIN / "servobus-scanner", "get", DRIVE, f"0xF6/{instance}/{number}", "--json", quiet=True))
    return bytes.fromhex(answer["values"][0]["raw"])


def numbers(octets):
    return [int.from_bytes(octets[i:i + 4], "little") for i in range(0, len(octets), 4)]


def kernel():
    """Received octets and packets, sent octets and packets, as the kernel counts them."""
    said = json.loads(run("ip", "-json", "-statistics", "link", "show", "drive", quiet=True))[0]["stats64"]
    return said["rx"]["bytes"], said["rx"]["packets"], said["tx"]["bytes"], said["tx"]["packets"]


def judge():
    check(attribute(3) == bytes.fromhex(MAC.replace(":", "")), "the drive has not the MAC address of its interface")
    check(attribute(3, 2) == attribute(3), "R-ETH-3: both ports have one MAC address")
    speed = json.loads(run("ip", "-json", "-details", "link", "show", "drive", quiet=True))[0]
    check(speed["operstate"] == "UP", "the cable is not plugged in")
    # A veth pair says 10 Gbit/s, full duplex, nothing negotiated.
    check(numbers(attribute(1)) == [10_000], f"the speed is {numbers(attribute(1))}")
    check(numbers(attribute(2)) == [0b0010011], f"the flags are {numbers(attribute(2))}")
    check(numbers(attribute(1, 2)) == [0] and numbers(attribute(2, 2)) == [0], "something is plugged into port 2")

    before, kernel_before = numbers(attribute(4)), kernel()
    there(BIN / "servobus-scanner", "dump", DRIVE, quiet=True)
    after, kernel_after = numbers(attribute(4)), kernel()
    print("counters:", before, "->", after)
    for place, name in ((IN_OCTETS, "received octets"), (OUT_OCTETS, "sent octets")):
        check(after[place] - before[place] >= 2000, f"{name} have grown by {after[place] - before[place]}")
    for place, name in ((IN_UNICAST, "received packets"), (OUT_UNICAST, "sent packets")):
        check(after[place] - before[place] >= 10, f"{name} have grown by {after[place] - before[place]}")
    # Between the kernel's two answers; what the drive's own answer adds comes later.
    for place, low, high in zip((IN_OCTETS, OUT_OCTETS), kernel_before[::2], kernel_after[::2]):
        check(low <= after[place] <= high, f"counter {place} is {after[place]}, and the kernel says {low} to {high}")
    check(numbers(attribute(4, 2)) == [0] * 11, "port 2 has counted something")


if "SERVOBUS_OWN_NETWORK" not in os.environ:
    os.environ["SERVOBUS_OWN_NETWORK"] = "1"
    enter_own_network()

other = subprocess.Popen(["unshare", "--net", "sleep", "120"], stdin=subprocess.DEVNULL)
try:
    time.sleep(0.3)  # until it is in a network of its own
    run("ip", "link", "add", "drive", "address", MAC, "type", "veth", "peer", "name", "client", "netns", other.pid)
    run("ip", "address", "add", f"{DRIVE}/24", "dev", "drive")
    run("ip", "link", "set", "drive", "up")
    there("ip", "address", "add", f"{CLIENT}/24", "dev", "client")
    there("ip", "link", "set", "client", "up")
    with running_drive(DRIVE):
        judge()
finally:
    other.send_signal(signal.SIGKILL)
    other.wait()
