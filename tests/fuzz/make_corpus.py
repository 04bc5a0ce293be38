#!/usr/bin/env python3
"""Writes seeds for the fuzzers from the golden vectors, and from the data sheets of tests/eds.

    make_corpus.py DIRECTORY

makes DIRECTORY/<fuzzer>/ with one file per seed.
"""

import hashlib
import json
import sys
from pathlib import Path

VECTORS = Path(__file__).resolve().parents[1] / "golden" / "golden_vectors.json"
SHEETS = Path(__file__).resolve().parents[1] / "eds" / "sheets"
HEADER = 24          # encapsulation
SEND_DATA = 6        # interface handle, timeout
WHOLE = bytes([0xFF, 0xFF])  # the largest limit and pieces, no hurry
DHCP, HEARD = 2, 0x10  # a node that asks for an address; a frame at its first port
CONNECTION_MANAGER = bytes.fromhex("20062401")


def items(octets):
    """The items of a common packet, as far as they are there."""
    count, at = int.from_bytes(octets[:2], "little"), 2
    for _ in range(count):
        length = int.from_bytes(octets[at + 2:at + 4], "little")
        yield int.from_bytes(octets[at:at + 2], "little"), octets[at + 4:at + 4 + length]
        at += 4 + length


def messages(frame):
    """The message router's octets in a frame."""
    if frame[0] not in (0x6F, 0x70) or len(frame) <= HEADER + SEND_DATA:
        return
    for kind, data in items(frame[HEADER + SEND_DATA:]):
        if kind == 0xB2:
            yield data
        elif kind == 0xB1:
            yield data[2:]


def connection_path(request):
    """The path inside a Forward_Open, Large_Forward_Open or Forward_Close, or nothing."""
    offset = {0x54: 36, 0x5B: 40, 0x4E: 12}.get(request[0])
    data = request[2 + 2 * request[1]:]
    if offset is None or request[2:6] != CONNECTION_MANAGER:
        return b""
    return data[offset:]


def seeds(vectors):
    conversations = {}
    for vector in vectors:
        octets, requested = bytes.fromhex(vector["hex"]), vector["direction"] == "O->T"
        if vector["transport"] == "eth":
            yield "fuzz_link", bytes([DHCP, HEARD]) + len(octets).to_bytes(2, "little") + octets
            continue
        if vector["port"] == 2222:
            yield "fuzz_common_packet", octets
            if requested:
                yield "fuzz_adapter", WHOLE + octets
            continue
        yield "fuzz_frame_decoder", WHOLE + octets
        yield "fuzz_common_packet", octets[HEADER:]
        yield "fuzz_common_packet", octets[HEADER + SEND_DATA:]
        for message in messages(octets):
            yield "fuzz_common_packet", message
            if requested:
                yield "fuzz_message", WHOLE[:1] + message
                yield "fuzz_path", message[2:2 + 2 * message[1]]
                yield "fuzz_path", connection_path(message)
        if requested:
            yield "fuzz_adapter", WHOLE + octets
            conversations.setdefault(vector["scene"], bytearray()).extend(octets)
    for conversation in conversations.values():
        yield "fuzz_adapter", WHOLE + conversation
        yield "fuzz_adapter", bytes([7, 0]) + conversation
        yield "fuzz_frame_decoder", bytes([0x20, 2]) + conversation
    for sheet in sorted(SHEETS.glob("*.eds")):
        yield "fuzz_eds", sheet.read_bytes()


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    count = 0
    for fuzzer, octets in seeds(json.loads(VECTORS.read_text())["vectors"]):
        if not octets:
            continue
        folder = Path(sys.argv[1]) / fuzzer
        folder.mkdir(parents=True, exist_ok=True)
        (folder / hashlib.sha256(octets).hexdigest()[:16]).write_bytes(octets)
        count += 1
    print(f"{count} seeds in {sys.argv[1]}")


if __name__ == "__main__":
    main()
