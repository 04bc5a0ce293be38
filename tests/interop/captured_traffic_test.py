#!/usr/bin/env python3
"""tshark must find no malformed frame and no expert warning in what the drive and its clients say to each other.

Two captures: traffic in which nothing goes wrong, held to the whole rule; and refusals that are provoked on purpose,
which must still be well formed.
"""

import json
import os
import socket
import struct
import tempfile
from pathlib import Path

from judge import HERE, PORT, captured, check, enter_own_network, own_address, run, running_drive, scanner

MALFORMED = "_ws.malformed"
WARNING = "_ws.expert.severity >= 0x600000"
# nmap hangs up with a reset, which tshark warns of. A reset that the drive sends counts.
CLIENT_RESET = "(tcp.flags.reset == 1 and tcp.dstport == 44818)"


def frames(file, display_filter):
    """The frames of a capture that a display filter selects, one line each."""
    return run("tshark", "-n", "-r", file, "-Y", display_filter).splitlines()


def check_that_a_bad_frame_is_found(directory):
    """The judge itself: a SendRRData whose item is longer than the frame must be reported."""
    text, file = Path(directory, "bad.txt"), Path(directory, "bad.pcapng")
    frame = bytes.fromhex("6f00 1800 01000000 00000000 0000000000000000 00000000"
                          "00000000 0000 0200 00000000 b2004000 0e03 2064 2401 3000")
    text.write_text("000000 " + frame.hex(" "), encoding="ascii")
    run("text2pcap", "-q", "-T", f"40000,{PORT}", text, file)
    check(frames(file, MALFORMED), "tshark did not report a frame that is malformed on purpose")


def exchange(connection, frame):
    """Sends one encapsulation message and reads the reply, header and all."""
    connection.sendall(frame)
    header = connection.recv(24, socket.MSG_WAITALL)
    length = struct.unpack_from("<H", header, 2)[0]
    return header + (connection.recv(length, socket.MSG_WAITALL) if length else b"")


def replay_explicit_messages(address):
    """Every well-formed request of the golden vectors' explicit scene, so that every object and service is captured."""
    vectors = json.loads((HERE.parent / "golden" / "golden_vectors.json").read_text(encoding="utf-8"))["vectors"]
    requests = [vector for vector in vectors
                if vector["scene"] == 4 and vector["direction"] == "O->T" and not vector.get("deliberately_malformed")
                and not vector["name"].startswith("reset_type")]
    with socket.create_connection((address, PORT), timeout=5) as connection:
        register = bytes.fromhex("65000400 00000000 00000000 0000000000000000 00000000 01000000")
        session = exchange(connection, register)[4:8]
        for vector in requests:
            frame = bytes.fromhex(vector["hex"])
            exchange(connection, frame[:4] + session + frame[8:])
    return len(requests)


def talk(address):
    scanner("discover", "--host", address)
    scanner("identity", address)
    scanner("--json", "identity", address)
    scanner("get", address, "SCurve", "Statusword", "PositionActualValue")
    scanner("set", address, "SCurve=35")
    scanner("get", address, "SCurve")
    scanner("set", address, "SCurve=20")
    scanner("command", address, "PQ")
    scanner("call", address, "Get_Attributes_All", "0x01/1")
    scanner("dump", address)
    scanner("--connected", "dump", address)
    scanner("--route", "1/0", "get", address, "SCurve", "MotorType")
    run("node", HERE / "st_ethernet_ip.js", address)
    run("nmap", "-sT", "-Pn", "-n", "--script", "enip-info", "-p", PORT, address)


def be_refused(address):
    refused = 4
    scanner("set", address, "SCurve=101", expect=refused)
    scanner("set", address, "Statusword=1", expect=refused)
    run("node", HERE / "st_ethernet_ip.js", address, "--refusals")
    check(replay_explicit_messages(address) > 60, "the golden vectors have lost their explicit scene")


if os.geteuid() != 0:
    # Nobody but root may capture this machine's loopback, but everybody may capture the one of a network of their own.
    enter_own_network()

address = own_address()
with tempfile.TemporaryDirectory() as directory:
    check_that_a_bad_frame_is_found(directory)

    good, refusals = Path(directory, "good.pcapng"), Path(directory, "refusals.pcapng")
    with running_drive(address, "--variant", "75v8s"):
        with captured(f"host {address}", good):
            talk(address)
        with captured(f"host {address}", refusals):
            be_refused(address)

    for file, minimum in ((good, 60), (refusals, 150)):
        count = len(frames(file, "cip"))
        check(count >= minimum, f"only {count} frames with CIP were captured, at least {minimum} were expected")
    check(frames(good, "enip.command == 0x63"), "no ListIdentity was captured")
    check(frames(good, "enip.command == 0x65"), "no RegisterSession was captured")

    bad = frames(good, f"({MALFORMED} or {WARNING}) and not {CLIENT_RESET}") + frames(refusals, MALFORMED)
    check(not bad, "tshark objects to these frames:\n" + "\n".join(bad))
