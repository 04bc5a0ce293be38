#!/usr/bin/env python3
"""tshark must read the captures that this project writes as it reads real ones: no malformed frame, right checksums,
TCP in order, Forward_Opens with their replies, and class 1 data that it matches to them."""

import json
import tempfile
from pathlib import Path

from judge import BIN, check, run

CHECKSUMS = ("-o", "ip.check_checksum:TRUE", "-o", "tcp.check_checksum:TRUE", "-o", "udp.check_checksum:TRUE")
MALFORMED = "_ws.malformed"
WARNING = "_ws.expert.severity >= 0x600000"
BAD_SUM = "ip.checksum.status == 0 or tcp.checksum.status == 0 or udp.checksum.status == 0"


def written(directory, scene):
    file = Path(directory, f"scene{scene}.pcapng")
    run(BIN / "servobus_sample_capture", file, scene)
    return file


def fields(file, display_filter, *names):
    """A row of values for each frame that the filter selects."""
    options = [word for name in names for word in ("-e", name)]
    output = run("tshark", "-n", "-r", file, *CHECKSUMS, "-Y", display_filter, "-T", "fields", *options)
    return [line.split("\t") for line in output.splitlines()]


with tempfile.TemporaryDirectory() as directory:
    # An owner by multicast, an owner with sockaddr items, and the large form without data.
    for scene, datagrams in ((5, 6), (6, 2), (14, 0)):
        file = written(directory, scene)
        bad = fields(file, f"{MALFORMED} or {WARNING} or {BAD_SUM}", "frame.number", "_ws.col.Info")
        check(not bad, f"tshark objects to frames of scene {scene}: {bad}")
        check(fields(file, "cip.cm.fwo.consize", "frame.number"), f"tshark finds no Forward_Open in scene {scene}")
        granted = fields(file, "tcp and cip.cm.otapi", "frame.number")
        check(granted, f"tshark finds no granted Forward_Open in scene {scene}")
        # Only with its Forward_Open does tshark know that a datagram has a sequence count.
        decoded = fields(file, "cipio and cip.seq and enip.fwd_open_in", "frame.number")
        check(len(decoded) == datagrams,
              f"tshark decodes {len(decoded)} and not {datagrams} datagrams of class 1 in scene {scene}")
        if datagrams:
            check(fields(file, "cip.32bitheader.run_idle == 1", "frame.number"), "tshark finds no run/idle header")

    refusals = written(directory, 13)
    # One request of this scene is cut short on purpose.
    bad = fields(refusals, f"({MALFORMED} or {BAD_SUM})", "frame.number")
    check(len(bad) <= 1, f"tshark objects to more than the one damaged request: {bad}")

    scanner = BIN / "servobus-scanner"
    document = json.loads(run(scanner, "doctor", "--json", refusals, expect=4))
    check(len(document["opens"]) == 14, "the doctor has not found the 14 opens that were refused")

    # What tshark and editcap write, the doctor reads as well: classic pcap, with microseconds and with nanoseconds.
    for kind in ("pcap", "nsecpcap", "pcapng"):
        other = Path(directory, f"other.{kind}")
        run("tshark", "-F", kind, "-r", refusals, "-w", other)
        again = json.loads(run(scanner, "doctor", "--json", other, expect=4))
        check([each["diagnosis"] for each in again["opens"]] == [each["diagnosis"] for each in document["opens"]],
              f"the doctor reads a {kind} file otherwise")
