#!/usr/bin/env python3
"""The drive's address on a real network: dnsmasq, rivals and a scanner beside it, each in a namespace of its own.

    address_test.py DIRECTORY_OF_THE_PROGRAMS
"""

import socket
import struct
import tempfile
import time
from pathlib import Path

from lan import (BIN, REALTIME, Client, Drive, Ear, Failure, Rival, Session, check, enter_own_world, mac_octets,
                 run_beside_each_other, wait_for)

TCP_IP = 0xF5
DISCOVER, OFFER, REQUEST, DECLINE, ACK = 1, 2, 3, 4, 5
STORED = bytes(4)
SHORTEST_PROBE_GAP, LONGEST_PROBE_GAP = 0.180, 0.220  # s, R-ACD-1


def dnsmasq(host, *options):
    """DHCP and BOOTP from 10.77.0.1 without anything else; its log says what it heard and granted."""
    leases = host.lan.directory / f"{host.name}.leases"
    return host.start("dnsmasq", "--no-daemon", "--conf-file=/dev/null", "--user=root", "--group=root", "--port=0",
                      "--log-dhcp", "--log-facility=-", "--no-ping", "--interface=eth0", "--bind-interfaces",
                      "--dhcp-authoritative", f"--dhcp-leasefile={leases}", "--pid-file=", *options)


def drive_host(lan):
    """Where the drive will be, and an ear on its wire."""
    host = lan.host("drive")
    return host, Ear(lan.switch, "drive")


def address_of(drive, seconds=8):
    """Once the drive listens at it."""
    address = wait_for("an address", drive.address, seconds)
    wait_for("that it listens", lambda: drive.said(f"listens at {address}:44818"), 2)
    return address


def gaps(probes):
    times = [when for when, *_ in probes]
    return [later - earlier for earlier, later in zip(times, times[1:])]


def check_examination(ear, mac, address):
    """Four probes, 200 ms apart, 200 ms before the announcement (R-ACD-1, R-ACD-2)."""
    arp = [entry for entry in ear.arp(mac) if entry[3] == address]
    first = next(i for i, entry in enumerate(arp) if entry[2] == address)
    probes = arp[:first]
    check(len(probes) == 4 and all(entry[1:3] == (1, "0.0.0.0") for entry in probes), f"not four probes: {arp}")
    for gap in gaps(probes + [arp[first]]):
        check(SHORTEST_PROBE_GAP <= gap <= LONGEST_PROBE_GAP, f"probes are {gap * 1000:.1f} ms apart")
    return gaps(probes + [arp[first]])


def interface_configuration(session):
    """Address, mask, gateway, name servers, domain of attribute 5."""
    value = session.get(TCP_IP, 5)
    words = [socket.inet_ntoa(struct.pack(">I", word)) for word in struct.unpack("<5I", value[:20])]
    return words, value[22:22 + struct.unpack("<H", value[20:22])[0]].decode()


def dhcp_lease(lan):
    """DHCP grants an address that is examined, used, renewed, and kept when DHCP is disabled (000 1.4)"""
    server = lan.host("server", "10.77.0.1/24")
    host, ear = drive_host(lan)
    scanner = lan.host("scanner", "10.77.0.9/24")
    options = (*REALTIME, "--state", lan.directory / "state")
    drive = Drive(host, *options)
    check(drive.ready["drives"][0]["address"] is None, "the ready line has an address already")
    check(drive.ready["drives"][0]["interface"] == "eth0", "the ready line does not name the interface")
    check(drive.network()["last_conflict"] is None and not drive.network()["configured"], drive.network())
    service = dnsmasq(server, "--dhcp-range=10.77.0.50,10.77.0.60,255.255.255.0,120s", "--dhcp-option=3,10.77.0.1",
                      "--dhcp-option=6,10.77.0.1", "--dhcp-option=15,press.example", "--dhcp-option=58,6",
                      "--dhcp-option=59,60")
    address = address_of(drive, 12)
    mac = mac_octets(host.mac())
    measured = check_examination(ear, mac, address)
    check(host.addresses() == [f"{address}/24"], f"the interface has {host.addresses()}")
    check("default via 10.77.0.1" in host.ip("route"), "there is no default route")

    Client(scanner, address).scanner("identity")
    session = Session(scanner, address)
    check(session.get(TCP_IP, 1) == b"\1\0\0\0", "status of an address that was granted")
    check(session.get(TCP_IP, 2)[0] & 0x05 == 0x05, "capability: BOOTP and DHCP")
    words, domain = interface_configuration(session)
    check(words == [address, "255.255.255.0", "10.77.0.1", "10.77.0.1", "0.0.0.0"], f"attribute 5 is {words}")
    check(domain == "press.example", f"the domain is {domain!r}")
    check(session.get(0xF6, 3) == mac, "the MAC address is the interface's")

    def renewed():
        unicast = [octets for _, kind, octets in ear.dhcp() if kind == REQUEST and octets[:6] != b"\xff" * 6]
        acks = [when for when, kind, _ in ear.dhcp() if kind == ACK]
        return unicast and len(acks) >= 2
    wait_for("a renewed lease", renewed, 10)
    check(not [1 for _, octets in ear.heard if octets[12:14] == b"\x08\0" and octets[23] == 1 and octets[34] == 3],
          "the drive's machine has told the server that nobody listens to DHCP")
    check(session.get(TCP_IP, 1) == b"\1\0\0\0" and session.is_open(), "the renewal has interrupted the session")

    session.set(TCP_IP, 3, STORED)
    server.stop(service)
    check(session.call("05022001240100") == "85000000", "Reset 0")
    wait_for("the end of the session", lambda: not session.is_open(), 3)
    wait_for("the address given up", lambda: drive.address() is None, 3)
    before = len(ear.dhcp())
    check(address_of(drive) == address, "another address after the restart")
    check(Session(scanner, address).get(TCP_IP, 3) == STORED, "DHCP is enabled again")
    check(host.addresses() == [f"{address}/24"], f"the interface has {host.addresses()}")
    host.stop(drive.process)
    check(host.addresses() == [] and host.ip("route").strip() == "", "the drive has left its address behind")

    drive = Drive(host, *options)  # power off and on
    check(address_of(drive) == address, "another address after power off and on")
    check(Session(scanner, address).get(TCP_IP, 3) == STORED, "DHCP is enabled again")
    check(len(ear.dhcp()) == before, "it has asked a server although DHCP is disabled")
    return f"probes {', '.join(f'{gap * 1000:.0f}' for gap in measured)} ms apart"


def bootp(lan):
    """BOOTP grants an address for good"""
    server = lan.host("server", "10.77.0.1/24")
    host, ear = drive_host(lan)
    dnsmasq(server, "--dhcp-range=10.77.0.0,static", f"--dhcp-host={host.mac()},10.77.0.70")
    drive = Drive(host, *REALTIME, config={"network": {"method": "bootp"}})
    check(address_of(drive, 12) == "10.77.0.70", "another address than the table's")
    check_examination(ear, mac_octets(host.mac()), "10.77.0.70")
    requests = [octets for _, kind, octets in ear.dhcp() if octets[42] == 1]
    check(requests and all(message_kind == 0 for _, message_kind, octets in ear.dhcp() if octets[42] == 1),
          "a BOOTP request has a message type")
    scanner = lan.host("scanner", "10.77.0.9/24")
    session = Session(scanner, "10.77.0.70")
    check(session.get(TCP_IP, 3) == b"\1\0\0\0" and session.get(TCP_IP, 1) == b"\1\0\0\0", "method and status")


def conflict_of_lease(lan):
    """A granted address that somebody has is declined, and another one obtained"""
    server = lan.host("server", "10.77.0.1/24")
    host, ear = drive_host(lan)
    rival_host = lan.host("rival")
    rival = Rival(rival_host)
    rival.addresses = {"any"}  # of the probes that come, the first address
    service = dnsmasq(server, "--dhcp-range=10.77.0.50,10.77.0.60,255.255.255.0,120s")
    drive = Drive(host, *REALTIME)
    status = wait_for("a conflict", lambda: drive.network()["without_address"] and drive.network(), 8)
    check(status["conflict"] and not status["configured"] and status["address"] is None, status)
    refused = next(iter(rival.addresses))
    wait_for("DHCPDECLINE at the server", lambda: "DHCPDECLINE" in service.log.read_text(), 2)
    address = address_of(drive, 20)
    check(address != refused, "the same address again")
    check(drive.network()["last_conflict"]["activity"] == "probing", drive.network())
    check(not drive.network()["conflict"] and not drive.network()["without_address"], drive.network())
    declines = [when for when, kind, _ in ear.dhcp() if kind == DECLINE]
    discovers = [when for when, kind, _ in ear.dhcp() if kind == DISCOVER and when > declines[0]]
    check(10 <= discovers[0] - declines[0] < 11, f"it has waited {discovers[0] - declines[0]:.1f} s after declining")


def conflict_while_probing(lan):
    """A stored address that somebody has is not used, until he has gone"""
    host, ear = drive_host(lan)
    rival_host = lan.host("rival")
    rival = Rival(rival_host)
    rival.addresses = {"10.77.0.80"}
    drive = Drive(host, *REALTIME, config={"network": {"address": "10.77.0.80/24"}})
    status = wait_for("a conflict", lambda: drive.network()["conflict"] and drive.network(), 5)
    check(status["without_address"] and not status["configured"] and status["address"] is None, status)
    conflict = status["last_conflict"]
    check(conflict["activity"] == "probing" and conflict["mac"] == rival_host.mac(), conflict)
    heard = [octets[14:42] for _, octets in ear.heard if octets[12:14] == b"\x08\x06" and octets[21] == 2]
    check(conflict["arp"].replace(" ", "").lower() == heard[0].hex(), "attribute 11 is not the ARP that came")
    time.sleep(2)
    check(host.addresses() == [], "the address is used all the same")
    mac = mac_octets(host.mac())
    check(len(ear.arp(mac)) == 1, f"it goes on after the conflict: {ear.arp(mac)}")
    rival.addresses = set()
    check(address_of(drive, 15) == "10.77.0.80", "no address after the rival has gone")
    check(not drive.network()["conflict"] and not drive.network()["without_address"], drive.network())
    session = Session(lan.host("scanner", "10.77.0.9/24"), "10.77.0.80")
    check(session.get(TCP_IP, 1) == b"\1\0\0\0", "status")
    check(session.get(TCP_IP, 11) == b"\1" + mac_octets(rival_host.mac()) + heard[0], "attribute 11 by the wire")
    session.set(TCP_IP, 11, bytes(35))
    check(session.get(TCP_IP, 11) == bytes(35), "attribute 11 is not cleared")


def conflict_in_use(lan):
    """An address in use is defended once, and given up when it is claimed again"""
    host, ear = drive_host(lan)
    rival_host = lan.host("rival")
    rival = Rival(rival_host)
    scanner = lan.host("scanner", "10.77.0.9/24")
    drive = Drive(host, *REALTIME, config={"network": {"address": "10.77.0.90/24"}})
    address = address_of(drive)
    mac = mac_octets(host.mac())
    check_examination(ear, mac, address)
    wait_for("the second announcement", lambda: len([a for a in ear.arp(mac) if a[2] == address]) == 2, 4)
    announcements = [when for when, _, sender, _ in ear.arp(mac) if sender == address]
    check(1.98 <= announcements[1] - announcements[0] <= 2.05, "the announcements are not 2 s apart")
    session = Session(scanner, address)
    count = len([entry for entry in ear.arp(mac) if entry[2:] == (address, address)])
    rival.announce(address)
    wait_for("a defence", lambda: len([a for a in ear.arp(mac) if a[2:] == (address, address)]) == count + 1, 2)
    check(session.get(TCP_IP, 1) == b"\x41\0\0\0", "status while it is defended")
    check(session.get(TCP_IP, 11)[:7] == b"\2" + mac_octets(rival_host.mac()), "attribute 11 of ongoing detection")
    check(host.addresses() == [f"{address}/24"], "the address is gone after one claim")
    rival.announce(address)
    wait_for("the end of the session", lambda: not session.is_open(), 2)
    wait_for("the address taken off", lambda: host.addresses() == [], 2)
    status = drive.network()
    check(status["conflict"] and status["without_address"] and not status["configured"], status)
    try:
        scanner.connect(address, 44818, timeout=1)
        raise Failure("it answers at the address that it has lost")
    except OSError:
        pass


def set_by_client(lan):
    """Another stored address is answered first, then examined and used; link loss brings two probes"""
    host, ear = drive_host(lan)
    scanner = lan.host("scanner", "10.77.0.9/24")
    drive = Drive(host, *REALTIME, config={"network": {"address": "10.77.0.100/24"}})
    session = Session(scanner, address_of(drive))
    other = struct.pack("<5I", *(struct.unpack(">I", socket.inet_aton(text))[0] for text in
                                 ("10.77.0.101", "255.255.255.0", "10.77.0.9", "0.0.0.0", "0.0.0.0"))) + bytes(2)
    session.set(TCP_IP, 5, other)  # it is answered
    wait_for("the end of the session", lambda: not session.is_open(), 2)
    wait_for("the new address", lambda: drive.address() == "10.77.0.101", 3)
    mac = mac_octets(host.mac())
    check_examination(ear, mac, "10.77.0.101")
    check(host.addresses() == ["10.77.0.101/24"], f"the interface has {host.addresses()}")
    check("default via 10.77.0.9" in host.ip("route"), "there is no default route")
    session = Session(scanner, "10.77.0.101")
    check(session.get(TCP_IP, 5) == other, "attribute 5")

    count = len(ear.arp(mac))
    lan.switch.ip("link", "set", "drive", "down")
    time.sleep(0.5)
    lan.switch.ip("link", "set", "drive", "up")
    wait_for("two probes", lambda: len([a for a in ear.arp(mac)[count:] if a[2] == "0.0.0.0"]) == 2, 4)
    gap = gaps([a for a in ear.arp(mac)[count:] if a[2] == "0.0.0.0"])[0]
    check(SHORTEST_PROBE_GAP <= gap <= LONGEST_PROBE_GAP, f"the probes are {gap * 1000:.1f} ms apart")
    check(session.get(TCP_IP, 1) == b"\1\0\0\0", "the session has not outlived the link")


def privileges_and_leftovers(lan):
    """Without privileges it says which; what a killed drive has left behind is taken away, and nothing else"""
    host, _ = drive_host(lan)
    host.ip("addr", "add", "10.99.0.1/24", "dev", "eth0")
    config = {"network": {"address": "10.77.0.110/24", "gateway": "10.77.0.9"}}
    drive = Drive(host, *REALTIME, config=config)
    address_of(drive)
    check(host.addresses() == ["10.99.0.1/24", "10.77.0.110/24"], f"the interface has {host.addresses()}")
    host.stop(drive.process, 9)
    check("10.77.0.110/24" in host.addresses(), "a killed program cannot tidy up; this scene shows nothing")
    config["network"]["address"] = "10.77.0.111/24"
    drive = Drive(host, *REALTIME, config=config)
    check(drive.said("10.77.0.110/24 of a program that did not end in order"), "nothing is said of what was left")
    address_of(drive)
    check(host.addresses() == ["10.99.0.1/24", "10.77.0.111/24"], f"the interface has {host.addresses()}")
    host.stop(drive.process)
    check(host.addresses() == ["10.99.0.1/24"], "somebody else's address is gone, or the drive's is not")

    for missing, words in (("net_raw", "CAP_NET_RAW"), ("net_admin", "CAP_NET_ADMIN")):
        done = host.run("setpriv", f"--bounding-set=-{missing}", f"--inh-caps=-{missing}", BIN / "servobus-adapter",
                        "--manage-interface", "eth0")
        check(done.returncode == 3 and words in done.stderr, f"without {missing}: {done.returncode} {done.stderr}")
    done = host.run(BIN / "servobus-adapter", "--manage-interface", "eth9")
    check(done.returncode == 3 and "no interface 'eth9'" in done.stderr, done.stderr)
    done = host.run(BIN / "servobus-adapter", "--manage-interface", "lo")
    check(done.returncode == 3 and "no Ethernet interface" in done.stderr, done.stderr)
    for other in (("--bind", "127.0.0.1"), ("--count", "2")):
        done = host.run(BIN / "servobus-adapter", "--manage-interface", "eth0", *other)
        check(done.returncode == 2 and "--manage-interface is for one drive" in done.stderr, done.stderr)


if __name__ == "__main__":
    enter_own_world("dnsmasq", "setpriv")
    with tempfile.TemporaryDirectory() as directory:
        run_beside_each_other([dhcp_lease, bootp, conflict_of_lease, conflict_while_probing, conflict_in_use,
                               set_by_client, privileges_and_leftovers], Path(directory))
