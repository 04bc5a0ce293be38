#!/usr/bin/env python3
"""The npm package st-ethernet-ip must hold an I/O connection to the drive: its implicit scanner owns 101/100.

It sends a datagram for each one that it gets, at 10 ms. The drive must take its outputs while it owns them, show inputs
that follow, and be free again after its Forward_Close.
"""

import json
import os
import subprocess
import time
from contextlib import contextmanager

from judge import HERE, check, enter_own_network, own_address, running_drive, scanner

SPEED_OFFSET = 4  # SpeedJogOrProfilePositionMode in 101
CONTROLWORD_OFFSET = 16
STATUSWORD_OFFSET = 0
READY_TO_SWITCH_ON, OPERATION_ENABLED, MASK = 0x21, 0x27, 0x6F  # DS402


class Implicit:
    """The package's scanner, in its process."""

    def __init__(self, process):
        self.process = process
        self.packets = 0
        self.inputs = b""
        self.events = []

    def tell(self, line):
        print("<", line, flush=True)
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def until(self, condition, what, seconds=10):
        deadline = time.monotonic() + seconds
        while not condition():
            check(time.monotonic() < deadline, f"{what}; {self.packets} packets, inputs {self.inputs.hex()}")
            line = self.process.stdout.readline()
            check(line, f"{what}: the client has ended")
            said = json.loads(line)
            if "packets" not in said:
                print(">", line, end="", flush=True)
            check("error" not in said, said.get("error"))
            self.packets = said.get("packets", self.packets)
            self.inputs = bytes.fromhex(said.get("inputs", self.inputs.hex()))
            self.events.append(said.get("event"))

    def statusword(self):
        return int.from_bytes(self.inputs[STATUSWORD_OFFSET:STATUSWORD_OFFSET + 2], "little")


@contextmanager
def implicit_scanner(address):
    process = subprocess.Popen(["node", HERE / "st_ethernet_ip_io.js", address, "127.0.0.1"], text=True,
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        yield Implicit(process)
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()



if "SERVOBUS_OWN_NETWORK" not in os.environ:
    # It wants UDP 2222 of 127.0.0.1 and no other port, and so may its neighbours.
    os.environ["SERVOBUS_OWN_NETWORK"] = "1"
    enter_own_network()

address = own_address()
with running_drive(address), implicit_scanner(address) as client:
    client.until(lambda: "connected" in client.events, "it does not connect")
    client.until(lambda: client.packets > 50, "there are no inputs")

    # The drive takes what it writes, while it owns the drive ...
    client.tell(f"write {SPEED_OFFSET} 12345")
    deadline = time.monotonic() + 5
    while "12345" not in scanner("get", address, "SpeedJogOrProfilePositionMode"):
        check(time.monotonic() < deadline, "the output does not reach the drive")
    # ... and so does its state machine, which the inputs show.
    for controlword, wanted in ((0x06, READY_TO_SWITCH_ON), (0x07, 0x23), (0x0F, OPERATION_ENABLED)):
        client.tell(f"write {CONTROLWORD_OFFSET} {controlword}")
        client.until(lambda: client.statusword() & MASK == wanted,
                     f"the inputs do not follow controlword {controlword:#x}")
    scanner("io", address, "--connection", "standard", "--duration", "1", expect=4)  # It has an owner.

    client.tell("close")
    client.until(lambda: "closed" in client.events, "it does not close")
    check("disconnected" not in client.events, "the connection was lost on the way")
    check(client.process.wait(timeout=10) == 0, f"it ended with {client.process.returncode}")
    scanner("io", address, "--connection", "standard", "--duration", "0.5")
