"""Opens, breaks and re-opens connections for a long time; memory, descriptors and threads of the drive must stay flat.

    python3 tests/soak/soak.py build/bin --minutes 10 [--json FILE] [--seed N] [--instrumented]

The clients are plain sockets, with octets put together here. Each worker draws what it does next from the seed: sessions that
end by UnRegisterSession, by FIN, by RST, in the middle of a frame or not at all; class 3 connections that are closed, dropped or
left to time out; I/O connections of owners, of others that look on, and of owners that fall silent; and the scanner, ended by
any signal. Ends with 0 when everything is flat, with 1 when it is not, with 2 when it could not be measured.
"""

import argparse
import json
import os
import random
import signal
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path

PORT, IO_PORT = 44818, 2222
REGISTER, UNREGISTER, RR_DATA, UNIT_DATA = 0x65, 0x66, 0x6F, 0x70
FORWARD_OPEN, FORWARD_CLOSE = 0x54, 0x4E
IDENTITY_NAME = bytes.fromhex("0E0320012401 3007".replace(" ", ""))
KEEP = bytes.fromhex("100320F52401300D")  # Set_Attribute_Single of 0xF5/1/13
MESSAGE_ROUTER, MANAGER = bytes.fromhex("20022401"), bytes.fromhex("20062401")
OWNER_PATH, INPUT_PATH = bytes.fromhex("200424012C672C64"), bytes.fromhex("20042401 2CFE 2C64".replace(" ", ""))
O_TO_T, T_TO_O = 38, 30  # sequence count, run/idle header, data (000, assemblies 103 and 100)
DRIVES = 4
PATIENCE = 5.0  # for a reply: a machine under load must not look like a fault
SETTLED = 30.0  # until everything that was left behind has timed out
# What a process may grow by after its first quarter: pages that the allocator keeps, not what somebody forgot.
GROWTH_KIB, GROWTH_INSTRUMENTED_KIB = 512, 16 * 1024


class Closed(Exception):
    """The drive has closed the connection, or refused it."""


class Session:
    def __init__(self, address, local):
        self.socket = socket.socket()
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.settimeout(PATIENCE)
        self.handle = 0
        try:
            self.socket.bind((local, 0))
            self.socket.connect((address, PORT))
            self.handle = self.call(REGISTER, b"\1\0\0\0")[1]
        except OSError as error:
            self.socket.close()
            raise Closed from error

    def send(self, command, data):
        self.socket.sendall(struct.pack("<HHII8sI", command, len(data), self.handle, 0, b"soaksoak", 0) + data)

    def receive(self, count):
        data = b""
        while len(data) < count:
            more = self.socket.recv(count - len(data))
            if not more:
                raise Closed
            data += more
        return data

    def call(self, command, data):
        self.send(command, data)
        head = self.receive(24)
        length, handle, status = struct.unpack_from("<HII", head, 2)
        return status, handle, self.receive(length)

    def request(self, message):
        """An unconnected message; returns general status and data of the reply."""
        items = struct.pack("<IHHHHHH", 0, 10, 2, 0, 0, 0xB2, len(message)) + message
        status, _, data = self.call(RR_DATA, items)
        if status != 0 or len(data) < 20:
            raise Closed
        reply = data[16:]
        return reply[2], reply[4 + 2 * reply[3]:]

    def forward_open(self, rng, path, transport, sizes, rpi_us, multiplier):
        self.serial = rng.randrange(1 << 16)
        self.originator = rng.randrange(1 << 32)
        self.path = path
        data = struct.pack("<BBIIHHIB3xIHIHB", 10, 14, 0, rng.randrange(1, 1 << 32), self.serial, 0xFFFF,
                           self.originator, multiplier, rpi_us, sizes[0], rpi_us, sizes[1], transport)
        status, reply = self.request(bytes([FORWARD_OPEN, 2]) + MANAGER + data + bytes([len(path) // 2]) + path)
        if status != 0:
            return None
        return struct.unpack_from("<II", reply)

    def forward_close(self):
        data = struct.pack("<BBHHI", 10, 14, self.serial, 0xFFFF, self.originator)
        return self.request(bytes([FORWARD_CLOSE, 2]) + MANAGER + data + bytes([len(self.path) // 2, 0]) + self.path)[0]

    def reset(self):
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.socket.close()

    def end(self, rng):
        how = rng.choice(["unregister", "fin", "rst", "half"])
        try:
            if how == "unregister":
                self.send(UNREGISTER, b"")
            elif how == "half":
                self.socket.sendall(struct.pack("<HHI", RR_DATA, 400, self.handle))
            if how == "rst":
                self.reset()
            else:
                self.socket.close()
        except OSError:
            self.socket.close()
        return how


class Worker(threading.Thread):
    def __init__(self, soak, number):
        super().__init__(daemon=True)
        self.soak = soak
        self.rng = random.Random(soak.seed * 1000 + number)
        self.local = f"{soak.network}.{100 + number}"
        self.done = Counter()
        self.fault = None

    def drive(self):
        return self.rng.choice(self.soak.addresses)

    def run(self):
        try:
            while not self.soak.over():
                try:
                    self.once()
                except (Closed, socket.timeout, ConnectionError):
                    self.done["closed by the drive"] += 1
                    time.sleep(0.01)
        except Exception as error:  # its words are the report's
            self.fault = f"{type(self).__name__}: {type(error).__name__}: {error}"


class Sessions(Worker):
    def once(self):
        session = Session(self.drive(), self.local)
        for _ in range(self.rng.randrange(4)):
            status, _ = session.request(IDENTITY_NAME)
            if status != 0:
                raise ValueError(f"Identity answered with status {status:#x}")
        self.done["sessions ended by " + session.end(self.rng)] += 1


class Connected(Worker):
    def once(self):
        session = Session(self.drive(), self.local)
        opened = session.forward_open(self.rng, MESSAGE_ROUTER, 0xA3, (0x43F4, 0x43F4), 100_000, 0)
        if opened is None:
            raise ValueError("a class 3 connection was refused")
        for count in range(1, self.rng.randrange(2, 6)):
            items = struct.pack("<IHHHHIHHH", 0, 0, 2, 0xA1, 4, opened[0], 0xB1, 2 + len(IDENTITY_NAME), count)
            session.call(UNIT_DATA, items + IDENTITY_NAME)
        if self.rng.random() < 0.5 and session.forward_close() != 0:
            raise ValueError("a class 3 connection could not be closed")
        self.done["class 3 connections"] += 1
        session.end(self.rng)


class Writers(Worker):
    """Writes what is kept: encapsulation inactivity timeout (0xF5/1/13), which waits for the file of the state."""

    def once(self):
        session = Session(self.drive(), self.local)
        for _ in range(self.rng.randrange(1, 5)):
            value = struct.pack("<H", self.rng.randrange(120, 600))
            status, _ = session.request(KEEP + value)
            if status != 0:
                raise ValueError(f"a write was answered with status {status:#x}")
            self.done["writes that are kept"] += 1
        session.end(self.rng)
        time.sleep(0.02)


class InputOutput(Worker):
    """Owns a drive or looks on, on I/O connections of 5 ms."""

    def once(self):
        session = Session(self.drive(), self.local)
        owner = self.rng.random() < 0.7
        sizes = (0x4800 | O_TO_T, 0x4800 | T_TO_O) if owner else (0x4802, 0x4800 | T_TO_O)
        opened = session.forward_open(self.rng, OWNER_PATH if owner else INPUT_PATH, 0x01, sizes, 5000, 2)
        if opened is None:
            self.done["I/O connections refused"] += 1
            session.end(self.rng)
            return
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
            udp.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            udp.bind((self.local, IO_PORT))
            udp.setblocking(False)
            self.exchange(udp, session.socket.getpeername()[0], opened[0], owner)
        self.done["I/O connections"] += 1
        if self.rng.random() < 0.4:
            session.forward_close()
        else:
            self.done["I/O connections left to time out"] += 1
        session.end(self.rng)

    def exchange(self, udp, drive, connection, owner):
        data = struct.pack("<I", self.rng.randrange(2)) + bytes(32) if owner else b""
        for sequence in range(1, self.rng.randrange(2, 100)):
            packet = struct.pack("<HHHIIHHH", 2, 0x8002, 8, connection, sequence, 0xB1, 2 + len(data), sequence & 0xFFFF)
            udp.sendto(packet + data, (drive, IO_PORT))
            time.sleep(0.005)
            try:
                while udp.recv(2048):
                    self.done["datagrams received"] += 1
            except BlockingIOError:
                pass
            if self.soak.over():
                return


class Scanners(Worker):
    """The product's own originator, ended by any signal at any moment."""

    def once(self):
        words = [self.soak.bin / "servobus-scanner", "io", self.drive(), "--rpi", "5"]
        scanner = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            time.sleep(self.rng.random())
            number = self.rng.choice([signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT, signal.SIGABRT])
            scanner.send_signal(number)
            scanner.wait(timeout=20)
        finally:
            if scanner.poll() is None:
                scanner.kill()
                scanner.wait()
        self.done["scanners ended by a signal"] += 1


class Soak:
    def __init__(self, options):
        self.bin = Path(options.bin)
        self.seed = options.seed
        self.instrumented = options.instrumented
        self.network = f"127.80.{os.getpid() & 0xFF}"
        self.addresses = [f"{self.network}.{i}" for i in range(1, DRIVES + 1)]
        self.seconds = options.minutes * 60
        self.end = None
        self.samples = []
        self.state = tempfile.TemporaryDirectory()

    def over(self):
        return time.monotonic() >= self.end or self.adapter.poll() is not None

    def sample(self):
        process = Path(f"/proc/{self.adapter.pid}")
        status = dict(line.split(":", 1) for line in (process / "status").read_text().splitlines())
        return {"rss_kib": int(status["VmRSS"].split()[0]), "threads": int(status["Threads"]),
                "descriptors": len(list((process / "fd").iterdir()))}

    def start(self):
        environment = dict(os.environ)
        # Freed memory that the sanitizer keeps aside would look like a leak; real ones it tells at the end.
        environment["ASAN_OPTIONS"] = environment.get("ASAN_OPTIONS", "") + ":quarantine_size_mb=1:detect_leaks=1"
        self.adapter = subprocess.Popen([self.bin / "servobus-adapter", "--bind", self.addresses[0], "--count", str(DRIVES),
                                         "--state", self.state.name, "--log-level", "error"],
                                        stdin=subprocess.DEVNULL, env=environment)
        deadline = time.monotonic() + 30
        while True:
            try:
                Session(self.addresses[-1], f"{self.network}.99").end(random.Random(0))
                return
            except Closed:
                if self.adapter.poll() is not None or time.monotonic() > deadline:
                    raise SystemExit(2) from None
                time.sleep(0.05)

    def run(self):
        self.start()
        try:
            # The thread that stores comes with the first write, and stays.
            first = Session(self.addresses[0], f"{self.network}.99")
            first.request(KEEP + struct.pack("<H", 300))
            first.socket.close()
            time.sleep(1)
            before = self.sample()
            self.end = time.monotonic() + self.seconds
            kinds = [Sessions, Sessions, Connected, InputOutput, InputOutput, InputOutput, Writers, Scanners]
            workers = [kind(self, number) for number, kind in enumerate(kinds)]
            for worker in workers:
                worker.start()
            while not self.over():
                time.sleep(min(1, self.seconds / 20))
                self.samples.append(self.sample())
            for worker in workers:
                worker.join(timeout=60)
            done = sum((worker.done for worker in workers), Counter())
            faults = [worker.fault for worker in workers if worker.fault]
            faults += [f"{type(worker).__name__} did not end" for worker in workers if worker.is_alive()]
            return self.judge(before, done, faults)
        finally:
            if self.adapter.poll() is None:
                self.adapter.kill()
                self.adapter.wait()

    def judge(self, before, done, faults):
        deadline = time.monotonic() + SETTLED
        after = self.sample() if self.adapter.poll() is None else None
        while after and after["descriptors"] != before["descriptors"] and time.monotonic() < deadline:
            time.sleep(0.5)
            after = self.sample()
        if after is None:
            faults.append(f"the drive ended with {self.adapter.returncode}")
        else:
            faults += self.judge_figures(before, after)
            self.adapter.send_signal(signal.SIGTERM)
            try:
                if self.adapter.wait(timeout=30) != 0:
                    faults.append(f"the drive ended with {self.adapter.returncode} after SIGTERM")
            except subprocess.TimeoutExpired:
                faults.append("the drive did not end within 30 s of SIGTERM")
        return {"seconds": self.seconds, "seed": self.seed, "before": before, "after": after, "done": dict(sorted(done.items())),
                "peak_rss_kib": max((each["rss_kib"] for each in self.samples), default=0),
                "peak_descriptors": max((each["descriptors"] for each in self.samples), default=0),
                "growth_kib": self.growth(), "faults": faults}

    def growth(self):
        """From the second quarter of the time to the last: what comes after the first is not warming up."""
        quarter = len(self.samples) // 4
        if quarter == 0:
            return 0
        rss = [each["rss_kib"] for each in self.samples]
        return statistics.median(rss[-quarter:]) - statistics.median(rss[quarter:2 * quarter])

    def judge_figures(self, before, after):
        faults = []
        allowed = GROWTH_INSTRUMENTED_KIB if self.instrumented else GROWTH_KIB
        if self.growth() > allowed:
            faults.append(f"its memory has grown by {self.growth()} KiB, more than {allowed}")
        for what in ("descriptors", "threads"):
            if after[what] != before[what]:
                faults.append(f"it has {after[what]} {what} {SETTLED:.0f} s after everybody has gone; before, {before[what]}")
        return faults


def main():
    parser = argparse.ArgumentParser(description="Opens, breaks and re-opens connections; the drive must stay as it was.")
    parser.add_argument("bin", help="the folder of the programs")
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(1 << 31))
    parser.add_argument("--json", help="writes the figures to this file as well")
    parser.add_argument("--instrumented", action="store_true", help="the programs are built with sanitizers")
    options = parser.parse_args()
    result = Soak(options).run()
    if options.json:
        Path(options.json).write_text(json.dumps(result, indent=2) + "\n")
    print(f"{result['seconds'] / 60:.1f} minutes, seed {result['seed']}")
    for what, count in result["done"].items():
        print(f"  {count:>9,}  {what}")
    for when in ("before", "after"):
        print(f"  {when}: {result[when]}")
    print(f"  peak: {result['peak_rss_kib']} KiB, {result['peak_descriptors']} descriptors; "
          f"growth after the first quarter: {result['growth_kib']} KiB")
    for fault in result["faults"]:
        print("FAILED:", fault)
    return 1 if result["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
