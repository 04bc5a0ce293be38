#!/usr/bin/env python3
"""The drive as a node of a Device Level Ring, beside a supervisor that is made of octets.

    ring_test.py DIRECTORY_OF_THE_PROGRAMS

The supervisor sends its beacons every 20 ms and not every 400 us, which is too much for Python; what a node waits for is
in the beacons, so that it is the same to it.
"""

import select
import socket
import struct
import tempfile
import threading
import time
from pathlib import Path

from lan import (BIN, MTU, REALTIME, Client, check, enter_own_world, mac_octets, run_beside_each_other,
                 wait_for)

NORMAL, FAULT = 1, 2
BEACON, CHECK_REQUEST, CHECK_RESPONSE, STATUS, LOCATE_FAULT, ANNOUNCE, SIGN_ON, FLUSH = 1, 2, 3, 4, 5, 6, 7, 9
LEARNING_UPDATE = 10
INTERVAL, TIMEOUT = 0.020, 0.200  # s
GROUP = bytes.fromhex("01216c0000")
LINE = bytes(10)
SOL_PACKET, PACKET_AUXDATA, VLAN_VALID = 263, 8, 0x10


def ring_frame(destination, source, kind, sequence, content=b"", port=0, address="10.78.0.1"):
    header = b"\x81\x00\xe0\x00\x80\xe1\x02\x01" + bytes([kind, port]) + socket.inet_aton(address)
    return (destination + source + header + struct.pack(">I", sequence) + content).ljust(64, b"\0")


class Supervisor:
    """Sends beacons on two ports, or on those that it is told, and keeps what it hears there."""

    def __init__(self, host, mac, precedence=0, address="10.78.0.1"):
        self.mac = mac
        self.precedence = precedence
        self.address = address
        self.state = NORMAL
        self.sequence = 0
        self.sockets = [host.packets("port1"), host.packets("port2")]
        for sock in self.sockets:
            sock.setsockopt(SOL_PACKET, PACKET_AUXDATA, 1)
        self.ports = {0, 1}
        self.heard = []
        self.stopped = False
        self.threads = [threading.Thread(target=work, daemon=True) for work in (self.send_beacons, self.listen)]
        for thread in self.threads:
            thread.start()

    def send(self, port, destination, kind, content=b""):
        self.sequence += 1
        try:
            self.sockets[port].send(ring_frame(destination, self.mac, kind, self.sequence, content, 0, self.address))
        except OSError:
            pass  # the cable is out
        return self.sequence

    def send_beacons(self):
        while not self.stopped:
            content = struct.pack(">BBII", self.state, self.precedence, int(INTERVAL * 1e6), int(TIMEOUT * 1e6))
            for port in list(self.ports):
                self.send(port, GROUP + b"\1", BEACON, content)
            time.sleep(INTERVAL)

    def listen(self):
        while not self.stopped:
            for sock in select.select(self.sockets, [], [], 0.1)[0]:
                try:
                    octets, ancillary, _, where = sock.recvmsg(MTU, 256)
                except OSError:
                    continue
                if where[2] == socket.PACKET_OUTGOING or octets[12:14] != b"\x80\xe1":
                    continue
                tag = None
                for _, kind, data in ancillary:
                    status, _, _, _, _, tci, _ = struct.unpack("IIIHHHH", data[:20])
                    if kind == PACKET_AUXDATA and status & VLAN_VALID:
                        tag = tci
                self.heard.append((self.sockets.index(sock), tag, octets))

    def frames(self, kind):
        """(port, tag, octets) of the node's frames of a type."""
        return [entry for entry in list(self.heard) if entry[2][16] == kind]

    def close(self):
        self.stopped = True
        for thread in self.threads:
            thread.join()
        for sock in self.sockets:
            sock.close()


class Ring:
    """A drive with two ports, the other ends of their cables, and a client beside the ring."""

    def __init__(self, lan, *options):
        self.drive = lan.host("drive", "10.78.0.5/24")
        self.station = lan.host("station")
        for number in (1, 2):
            self.drive.ip("link", "add", f"ring{number}", "type", "veth", "peer", "name", f"port{number}", "netns",
                          self.station.name)
            self.drive.ip("link", "set", f"ring{number}", "up")
            self.station.ip("link", "set", f"port{number}", "up")
        self.mac = mac_octets(self.drive.mac())
        self.scanner = lan.host("scanner", "10.78.0.9/24")
        process = self.drive.start(BIN / "servobus-adapter", "--bind", "10.78.0.5", "--ring-ports", "ring1,ring2",
                                   *REALTIME, *options)
        wait_for("the drive", lambda: "listens at" in process.log.read_text(), 10)
        self.client = Client(self.scanner, "10.78.0.5")

    def attributes(self, *numbers):
        """Of the DLR object, as the scanner reads them by the wire."""
        lines = self.client.scanner("get", *(f"0x47/1/{number}" for number in numbers)).splitlines()
        return [bytes.fromhex(line.partition("=")[2]) for line in lines]

    def told(self):
        """Topology, status and active supervisor."""
        topology, status, supervisor = self.attributes(1, 2, 10)
        return topology[0], status[0], supervisor

    def wait(self, what, topology, status, supervisor):
        wait_for(f"{what}: {topology}, {status}, {supervisor.hex()}",
                 lambda: self.told() == (topology, status, supervisor), 3)


def active(supervisor):
    return bytes(reversed(socket.inet_aton(supervisor.address))) + supervisor.mac


def beacon_based_node(lan):
    """Closed, broken, another supervisor, silence: what the DLR object tells by the wire"""
    ring = Ring(lan)
    check(ring.told() == (0, 0, LINE), "a line before the first beacon")
    check(ring.attributes(12) == [b"\x82\0\0\0"], "capability of a beacon-based node")
    first = Supervisor(ring.station, bytes.fromhex("020000000001"))
    ring.wait("a closed ring", 1, 0, active(first))

    first.send(0, GROUP + b"\2", SIGN_ON, struct.pack(">H", 1) + first.mac + socket.inet_aton(first.address))
    port, tag, octets = wait_for("the sign-on", lambda: first.frames(SIGN_ON), 2)[0]
    check(port == 1 and tag == 0xE000, f"the sign-on has come by port {port + 1} with tag {tag}")
    check(octets[26:48] == struct.pack(">H", 2) + first.mac + socket.inet_aton(first.address) + ring.mac
          + socket.inet_aton("10.78.0.5"), f"the sign-on is {octets.hex()}")

    ring.station.ip("link", "set", "port2", "down")
    ring.wait("a broken ring", 1, 1, active(first))
    port, tag, octets = wait_for("the link status", lambda: first.frames(STATUS), 2)[0]
    check(port == 0 and octets[:6] == first.mac and octets[26] == 0x01, f"the link status is {octets.hex()}")
    ring.station.ip("link", "set", "port2", "up")
    ring.wait("a ring that is closed again", 1, 0, active(first))

    first.state = FAULT
    ring.wait("a fault elsewhere", 1, 1, active(first))
    sequence = first.send(1, GROUP + b"\2", CHECK_REQUEST)
    port, _, octets = wait_for("the response", lambda: first.frames(CHECK_RESPONSE), 2)[0]
    check(port == 1 and octets[22:27] == struct.pack(">IB", sequence, 0), f"the response is {octets.hex()}")
    began = time.monotonic()
    first.send(0, GROUP + b"\3", LOCATE_FAULT)
    port, _, octets = wait_for("the neighbor status", lambda: first.frames(STATUS)[1:], 2)[0]
    check(octets[26] == 0x80 and len(first.frames(CHECK_REQUEST)) == 6, f"the neighbor status is {octets.hex()}")
    check(0.25 < time.monotonic() - began < 0.6, "three requests have 100 ms each")
    first.send(0, GROUP + b"\3", FLUSH, b"\1")
    port, tag, octets = wait_for("a learning update", lambda: first.frames(LEARNING_UPDATE), 2)[0]
    check(tag is None and octets[:6] == GROUP + b"\5", "a learning update has no tag")
    first.state = NORMAL
    ring.wait("a closed ring", 1, 0, active(first))

    first.ports = {0}
    ring.wait("silence of one port", 1, 1, active(first))
    first.ports = {0, 1}
    ring.wait("a closed ring", 1, 0, active(first))

    second = Supervisor(ring.station, bytes.fromhex("020000000000"), precedence=1, address="10.78.0.2")
    ring.wait("another supervisor", 1, 0, active(second))
    second.close()
    ring.wait("the first supervisor again", 1, 0, active(first))
    first.close()
    ring.wait("a line", 0, 0, LINE)


def announce_based_node(lan):
    """The same by announcements, once a second"""
    ring = Ring(lan, "--ring-announce")
    check(ring.attributes(12) == [b"\x81\0\0\0"], "capability of an announce-based node")
    supervisor = Supervisor(ring.station, bytes.fromhex("020000000001"))
    time.sleep(0.3)
    check(ring.told() == (0, 0, LINE), "it looks at beacons")
    supervisor.send(0, GROUP + b"\3", ANNOUNCE, bytes([NORMAL]))
    ring.wait("a closed ring", 1, 0, active(supervisor))
    supervisor.send(0, GROUP + b"\3", ANNOUNCE, bytes([FAULT]))
    ring.wait("a broken ring", 1, 1, active(supervisor))
    ring.wait("a line after 2.5 s", 0, 0, LINE)
    supervisor.close()


if __name__ == "__main__":
    enter_own_world()
    with tempfile.TemporaryDirectory() as directory:
        run_beside_each_other([beacon_based_node, announce_based_node], Path(directory))
