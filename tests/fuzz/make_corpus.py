#!/usr/bin/env python3
"""Makes what the fuzzers begin with (docs/fuzzing.md).

    make_corpus.py seeds DIRECTORY
        writes DIRECTORY/<target>/: inputs from the golden vectors, the data sheets of tests/eds, the axes of drive/axes,
        and what is written down here
    make_corpus.py choose CONTROL DIRECTORY [FILES [OCTETS]]
        copies into DIRECTORY the few inputs that together reach most: at most FILES of them (32), with OCTETS (20000) in
        all. CONTROL is the control file of a libFuzzer -merge=1, which says what each input reaches.
"""

import hashlib
import json
import shutil
import struct
import sys
import zlib
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
VECTORS = TESTS / "golden" / "golden_vectors.json"
SHEETS = TESTS / "eds" / "sheets"
AXES = TESTS.parent / "drive" / "axes"
HEADER = 24          # encapsulation
SEND_DATA = 6        # interface handle, timeout
WHOLE = bytes([0xFF, 0xFF])  # the largest limit and pieces, no hurry
DHCP, HEARD = 2, 0x10  # a node that asks for an address; a frame at its first port
CONNECTION_MANAGER = bytes.fromhex("20062401")

CONFIGURATIONS = [
    {"variant": "48v8", "bind": "0.0.0.0", "port": 0, "io_port": 2223, "count": 2, "log_level": "debug",
     "axis": "linax-lxc-230f10", "seed": 7, "scenario": "night.json", "motor": "linear", "eds": "drive.eds",
     "identity": {"serial_number": 4711, "major_revision": 2, "minor_revision": 3, "product_name": "Press 7"},
     "lost_controller": {"outputs": "off"},
     "protection": {"allow": ["192.168.2.0/24", "10.0.0.5"], "read_only": True, "harden": True},
     "access_log": "access.jsonl",
     "limits": {"tcp_connections": 1, "sessions": 2, "class3_connections": 0, "listening_connections": 3,
                "inactivity_seconds": 3600},
     "values": {"SCurve": 50, "drive.Controlword": "0x1F", "ServoIdentificationString": "axis 1"}},
    {"network": {"method": "stored", "address": "192.168.2.100/24", "gateway": "192.168.2.1", "acd": False},
     "programs": {"1": ["REF", "SP 200000", "G 100000", "SO 1", "WT 500", "WI 2", "G 0", "CO 1"]},
     "profiles": {"1": [{"to": 100000, "speed": 200000, "acceleration": 2000000}, {"by": -40000}]}},
]
EVENTS = [
    {"event": "put-obstacle", "position": 40000, "stiffness": 12.5, "from_above": True},
    {"event": "remove-obstacle"}, {"event": "block-axis"}, {"event": "release-axis"},
    {"event": "set-payload", "mass": 0.5}, {"event": "push-axis", "force": -7},
    {"event": "set-input", "number": 12, "high": False},
    {"event": "limit-switch", "direction": "positive", "active": False},
    {"event": "emergency-exit", "active": False, "keep_power": True},
    {"event": "safety-stop", "function": "ss2", "active": False}, {"event": "lose-encoder"},
    {"event": "restore-encoder"}, {"event": "set-supply", "volts": 24}, {"event": "cut-supply"},
    {"event": "set-temperature", "celsius": -10}, {"event": "turn-master", "speed": -2000},
    {"event": "cut-power-stage"}, {"event": "lose-controller"}, {"event": "power-cycle"},
]
FAULTS = [
    {"event": "drop-io", "direction": "o_to_t", "share": 0.3, "count": 4, "seconds": 5},
    {"event": "delay-io", "direction": "t_to_o", "milliseconds": 2.5, "jitter": 1},
    {"event": "duplicate-io"}, {"event": "reorder-io", "count": 1}, {"event": "cut-cable", "seconds": 0.5},
    {"event": "delay-replies", "milliseconds": 300, "count": 2}, {"event": "withhold-replies", "seconds": 1},
    {"event": "refuse-open", "general": 1, "extended": "0x0113", "count": 3},
    {"event": "close-sessions", "session": "0x12345678"}, {"event": "freeze", "seconds": 2},
    {"event": "restart"}, {"event": "claim-address", "mac": "0x020000000001"}, {"event": "restore-network"},
]
STATE = {"network": {"method": 0, "host_name": "press-7"},
         "parameters": {"0x64/0x00": 50, "0x65/0x5D": {"3": 500, "9": -2}},
         "firmware": {"release": {"version": {"major": 1, "minor": 5}}}}
QUERIES = [{"query": word} for word in
           ("state", "axis", "connections", "counters", "lights", "firmware", "network")]


def words(*numbers):
    return struct.pack(f"<{len(numbers)}H", *numbers)


def piece(octets):
    """As Input::piece() takes it."""
    return bytes([len(octets)]) + octets


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


def request_data(request):
    return request[2 + 2 * request[1]:]


def connection_path(request):
    """The path inside a Forward_Open, Large_Forward_Open or Forward_Close, or nothing."""
    offset = {0x54: 36, 0x5B: 40, 0x4E: 12}.get(request[0])
    if offset is None or request[2:6] != CONNECTION_MANAGER:
        return b""
    return request_data(request)[offset:]


# --- captures

def ethernet(transport, source, destination, payload, sequence):
    """A frame from 192.168.2.1 or .100 to the other."""
    ports = struct.pack(">HH", source[1], destination[1])
    if transport == "tcp":
        rest = ports + struct.pack(">IIBBHHH", sequence, 0, 0x50, 0x18, 0xFFFF, 0, 0)
    else:
        rest = ports + struct.pack(">HH", 8 + len(payload), 0)
    rest += payload
    address = lambda end: bytes([192, 168, 2, end[0]])
    head = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(rest), 1, 0, 64, 6 if transport == "tcp" else 17, 0)
    return bytes(12) + b"\x08\x00" + head + address(source) + address(destination) + rest


def frames_of(vectors):
    position = {True: 1, False: 1}
    for vector in vectors:
        if vector["transport"] == "eth":
            continue
        octets, requested = bytes.fromhex(vector["hex"]), vector["direction"] == "O->T"
        ours = (1, 50000) if vector["transport"] == "tcp" else (1, vector["port"])
        ends = (ours, (100, vector["port"])) if requested else ((100, vector["port"]), ours)
        yield ethernet(vector["transport"], *ends, octets, position[requested])
        if vector["transport"] == "tcp":
            position[requested] += len(octets)


def pcap(frames, big):
    order = ">" if big else "<"
    octets = struct.pack(order + "IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)
    for number, frame in enumerate(frames):
        octets += struct.pack(order + "IIII", 1700000000, 1000 * number, len(frame), len(frame)) + frame
    return octets


def pcapng(frames):
    def block(kind, body):
        body += bytes(-len(body) % 4)
        length = struct.pack("<I", 12 + len(body))
        return struct.pack("<I", kind) + length + body + length
    octets = block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1))
    octets += block(1, struct.pack("<HHI", 1, 0, 0) + struct.pack("<HHB3xHH", 9, 1, 9, 0, 0))
    for number, frame in enumerate(frames):
        time = 1_700_000_000_000_000_000 + 10_000_000 * number
        octets += block(6, struct.pack("<IIIII", 0, time >> 32, time & 0xFFFFFFFF, len(frame), len(frame)) + frame)
    return octets


# --- what has a form of its own (see the sources of the targets)

def router_scripts(requests):
    """Rows of requests for fuzz_message_router: alone, over the connection, in other services."""
    for start in range(0, len(requests), 6):
        for how in (0x00, 0x10, 0x30, 0x04):
            yield bytes([1]) + b"".join(bytes([how]) + piece(request) for request in requests[start:start + 6])
    for class_id in (0x01, 0x02, 0x04, 0x06, 0x37, 0x47, 0x48, 0x64, 0x66, 0xF4, 0xF5, 0xF6):
        reads = b"".join(bytes([0x03, 0x0E, class_id, 1, attribute]) + piece(b"") for attribute in range(1, 12))
        listed = bytes([0x01, 0x03, class_id, 1]) + piece(words(3, 1, 2, 3))
        everything = bytes([0x01, 0x01, class_id, 1]) + piece(b"")
        together = bytes([0x09, 0x01, class_id, 1]) + piece(b"") + bytes([0x01, class_id, 0]) + piece(b"")
        sets = b"".join(bytes([0x03, 0x10, class_id, 1, attribute]) + piece(bytes(4)) for attribute in range(1, 12))
        yield bytes([0]) + reads + listed + everything + together
        for protection in (0, 2, 4):
            yield bytes([protection]) + sets + bytes([0x01, 0x05, 1, 1]) + piece(b"")


def open_scripts():
    for kind in range(40):
        yield bytes([0, kind, 0, 0])
        yield bytes([0, kind, 1, 0, 0x40, kind, 1, 0, 0, kind, 0, 1, 20, 0xFF, 0xC9])


def io_scripts(datagrams):
    for end in (0, 1):
        good = bytes([0x00]) + piece(bytes([1, 0, 1, 0, 0, 0, 0x1F, 0]))
        second = bytes([0x08]) + piece(bytes([1, 0]))
        repeat = bytes([0x10, 1, 0, 0, 0]) + piece(bytes([1, 0, 1, 0, 0, 0]))
        wrong = bytes([0x20]) + piece(bytes(3)) + bytes([0x02, 1, 2, 3, 4]) + piece(bytes(4))
        elsewhere = bytes([0x04]) + piece(bytes(4)) + bytes([0x40, 5]) + piece(bytes(4))
        yield bytes([end]) + good + second + repeat + wrong + elsewhere
        for datagram in datagrams:
            yield bytes([end, 0x01]) + piece(datagram) + good


def upload_scripts(replies):
    # A device and two clients: begin, take, disturb.
    yield bytes([0]) + bytes([0x00, 200]) + bytes([0x02, 0, 0x02, 1, 0x02, 2, 0x02, 3])
    yield bytes([0]) + bytes([0x00, 16, 0x01, 16, 0x02, 0, 0x03, 0, 0x02, 1, 0x02, 1, 0x02, 5, 0xBF, 0, 0x80, 9])
    yield bytes([0]) + bytes([0x04]) + piece(b"") + bytes([0x04]) + piece(b"ab") + bytes([0x00, 0, 0x02, 7])
    # A client and what it is answered: attributes, the grant, pieces.
    attributes = b"".join(bytes([0]) + piece(value) for value in
                          (b"\x02", b"\x01eng\xDA\x04\x00\x01e", b"\x01\x00", b"\x05\0\0\0", b"\0\0", b"\0"))
    file = b"abcde"
    total = struct.pack("<H", -sum(file) & 0xFFFF)
    grant = bytes([0]) + piece(struct.pack("<IB", len(file), 3))
    yield bytes([1, 254]) + attributes + grant + bytes([0x40]) + piece(bytes([0, 0]) + file[:3]) + \
        bytes([0x40]) + piece(bytes([1, 2]) + file[3:] + total) + bytes(3)
    packed = zlib.compress(b"[File]\r\n" * 20)
    yield bytes([1, 254]) + bytes([0x14, 0] * 6) + bytes([0]) + piece(struct.pack("<IB", len(packed), 255)) + \
        bytes([0x40]) + piece(bytes([0, 4]) + packed + struct.pack("<H", -sum(packed) & 0xFFFF)) + bytes(3)
    yield bytes([1, 254]) + attributes + bytes([0xFF, 0xFF]) + grant + bytes([0x22, 2]) + piece(b"") + bytes(3)
    for reply in replies:
        yield bytes([1, 254]) + attributes + grant + bytes([0x40]) + piece(reply[4:250]) + bytes(3)


def config_texts():
    def text(which, value):
        return bytes([which]) + (value if isinstance(value, bytes) else json.dumps(value).encode())
    for configuration in CONFIGURATIONS:
        yield text(0, configuration)
    for events in (EVENTS, FAULTS):
        timed = [{"at": number / 4, **event} for number, event in enumerate(events)]
        yield text(1, {"repeat_every": 30, "events": timed})
        for start in range(0, len(events), 5):
            yield text(5, b"\n".join(json.dumps(line).encode() for line in events[start:start + 5] + QUERIES))
    for axis in sorted(AXES.glob("*.json"))[:2]:
        yield text(2, axis.read_bytes())
    yield text(3, STATE)
    payload = json.dumps(STATE).encode()
    yield text(4, b"servobus-state 1 %08X %d\n" % (zlib.crc32(payload), len(payload)) + payload)


def reply_scripts(replies):
    for frame, message in replies:
        yield bytes([0]) + frame
        yield bytes([0]) + message[4:]
        if message[0] in (0xD4, 0xDB):
            yield bytes([1, 2, 0]) + message[4:]
            yield bytes([2]) + message[4:]
        if message[0] == 0x8A:
            for count in range(1, 5):
                yield bytes([3, count]) + bytes([0x0E, 1] * count) + message[4:]
        if message[0] == 0x8E:
            yield bytes([4, 0, 0]) + message
            yield bytes([4, 40, 0]) + message
    for multicast in (0, 1):
        item = bytes([1, 1]) + piece(bytes.fromhex("000208AEEFC00D600000000000000000"))
        run = bytes([5, multicast]) + bytes([0x1A, 0]) + item
        data = b"".join(bytes([0x14]) + piece(bytes([n, 0])) + bytes([n, 0]) for n in range(1, 5))
        yield run + data + bytes([0x05, 10, 0]) + data + bytes([0x07, 0x12])
        yield bytes([5, multicast]) + bytes([0x02, 0x01]) + piece(bytes(10)) + bytes([0x05, 0, 1, 0x01, 0x1A, 0]) + item + \
            data + bytes([0x06, 0x05, 0xFF, 0xFF, 0x01])


def session_scripts(requests):
    come = bytes([0, 0, 1, 0])           # a TCP connection of peer 0, and its session
    class3 = bytes([5, 0, 0])
    own = bytes([7, 0, 0, 0, 0])         # the first exclusive owner
    look = bytes([7, 0, 5, 0, 0])
    data = bytes([8, 0, 10]) + bytes(10)
    pass_ = bytes([12, 7])
    yield come + class3 + own + look + data + pass_ + data + bytes([9, 0, 0]) + bytes([11, 0])
    yield come + bytes([0, 1, 1, 1]) + class3 + own + data * 3 + pass_ * 3 + bytes([12, 17])
    yield come + bytes([0, 1, 0, 2, 0, 3, 0, 4, 1, 1, 1, 2, 1, 3]) + bytes([11, 0]) * 2 + pass_
    for request in requests[::4]:
        yield come + class3 + bytes([4, 0, 1]) + piece(request) + bytes([2]) + \
            bytes([6, 0, 0, 0, 0, 1, 0, 1]) + piece(request)
    yield come + bytes([3, 0, 0, 2, 0]) + piece(bytes(16)) + bytes([3, 0, 1, 2, 0x10]) + piece(bytes(16)) + bytes([9])
    yield come + bytes([10, 0]) + piece(bytes.fromhex("63") + bytes(23)) + bytes([10, 1]) + \
        piece(bytes.fromhex("63") + bytes(23)) + bytes([12, 15])


# --- what a PTP node answers to each question of a round, as ptp4l does

def ptp_scripts():
    told = [bytes.fromhex(words) for words in (
        "03000001 80 F8FEFFFF 81 5E88D9FFFE77A0B1 0700", "0002 FFFFFFFFFE0C0000 00000000061A0000",
        "E6DF21FFFE788278 0003 0000 1234 7FFFFFFE 0A 06214E5D 0B E6DF21FFFE788277", "0025 3C 20",
        "5E88D9FFFE77A0B1 0001 09 00 0000000000000000 FE 03 FD 01 00 02",
        "8000 0A 49454545203830322E33 0006 5E88D977A0B1 0001 0004 0A010102 000000 00 02 3B3B 02 3B3B 05 5072657373"
        "001B19000100 00")]
    whole = b"".join(bytes([0]) + piece(octets) for octets in told)
    yield bytes([0, 0xFF]) + whole
    yield bytes([7, 0xFF]) + whole + bytes([0xFF]) + whole + bytes([0xFF] * 4)
    ports = told[0][:2] + b"\0\3" + told[0][4:]
    yield bytes([0, 0xFF, 0]) + piece(ports) + whole[2 + len(told[0]):] + bytes([1, 0, 1, 0, 0]) + piece(told[4])
    recorded = bytes.fromhex(
        "0D02004A000000000000000000000000000000005E88D9FFFE77A0B100000001047F0000000000000000000100000200000100162000"
        "010000010080C8FEFFFF805E88D9FFFE77A0B10000")
    yield bytes([0, 0xFF, 0x80]) + piece(recorded)


# --- all of them

def seeds(vectors):
    conversations, scenes = {}, {}
    requests, replies, datagrams = [], [], []
    for vector in vectors:
        octets, requested = bytes.fromhex(vector["hex"]), vector["direction"] == "O->T"
        scenes.setdefault(vector["scene"], []).append(vector)
        if vector["transport"] == "eth":
            yield "link", bytes([DHCP, HEARD]) + words(len(octets)) + octets
            continue
        if vector["port"] == 2222:
            datagrams.append(octets)
            yield "common_packet", octets
            yield "io_packet", octets
            if requested:
                yield "adapter", WHOLE + octets
            continue
        yield "encapsulation", WHOLE + octets
        yield "common_packet", octets[HEADER:]
        yield "common_packet", octets[HEADER + SEND_DATA:]
        for message in messages(octets):
            yield "common_packet", message
            yield "message", message
            if not requested:
                yield "message", message[4:]
                replies.append((octets, message))
                continue
            requests.append(message)
            yield "path", message[2:2 + 2 * message[1]]
            yield "path", connection_path(message)
            if message[2:6] == CONNECTION_MANAGER:
                yield "forward_open", request_data(message)
                yield "forward_open", bytes([0x80, len(request_data(message))]) + request_data(message)
        if requested:
            yield "adapter", WHOLE + octets
            conversations.setdefault(vector["scene"], bytearray()).extend(octets)
        elif octets[0] == 0x63:
            replies.append((octets, octets[HEADER:]))
    for conversation in conversations.values():
        if len(conversation) > 2000:
            continue
        yield "adapter", WHOLE + conversation
        yield "adapter", bytes([7, 0]) + conversation
        yield "encapsulation", bytes([0x20, 2]) + conversation
    for scene in scenes.values():
        if len(scene) <= 24:
            yield "capture", pcapng(frames_of(scene))
            yield "capture", pcap(frames_of(scene), len(scene) % 2 == 0)
    for sheet in sorted(SHEETS.glob("*.eds")):
        yield "eds", sheet.read_bytes()
    scripts = {"message_router": router_scripts(requests), "forward_open": open_scripts(),
               "io_packet": io_scripts(datagrams), "config": config_texts(), "scanner_replies": reply_scripts(replies),
               "file_upload": upload_scripts([message for _, message in replies if message[0] in (0xCB, 0xCF)]),
               "ptp_answers": ptp_scripts(), "session": session_scripts(requests)}
    for target, inputs in scripts.items():
        for octets in inputs:
            yield target, octets


def name_of(octets):
    return hashlib.sha256(octets).hexdigest()[:16]


def write_seeds(directory):
    count = 0
    for target, octets in seeds(json.loads(VECTORS.read_text())["vectors"]):
        if not octets:
            continue
        folder = Path(directory) / target
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name_of(octets)).write_bytes(octets)
        count += 1
    print(f"{count} seeds in {directory}")


def reached_by_input(control):
    """What each input of a merge reaches: the features of its FT line, by the path of its place in the list."""
    lines = control.read_text().splitlines()
    count = int(lines[0])
    paths = [Path(line) for line in lines[2:2 + count]]
    reached = {}
    for line in lines[2 + count:]:
        kind, number, *features = line.split()
        if kind == "FT":
            reached.setdefault(paths[int(number)], set()).update(features)
    return reached


def choose(control, directory, files=32, octets=20000):
    reached = reached_by_input(Path(control))
    Path(directory).mkdir(parents=True, exist_ok=True)
    left, covered, size = set(reached), set(), 0
    for _ in range(int(files)):
        fits = [path for path in left if size + path.stat().st_size <= int(octets)]
        # The most that is new; of equals the shortest, and then the name, so that it repeats.
        best = min(fits, default=None, key=lambda path: (-len(reached[path] - covered), path.stat().st_size, path.name))
        if best is None or not reached[best] - covered:
            break
        left.remove(best)
        covered |= reached[best]
        size += best.stat().st_size
        shutil.copyfile(best, Path(directory) / name_of(best.read_bytes()))
    everything = set().union(*reached.values()) if reached else set()
    print(f"{directory}: {len(reached) - len(left)} of {len(reached)} inputs, {size} octets, "
          f"{len(covered)} of {len(everything)} features")


def main():
    match sys.argv[1:]:
        case ["seeds", directory]:
            write_seeds(directory)
        case ["choose", control, directory, *limits] if len(limits) <= 2:
            choose(control, directory, *limits)
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
