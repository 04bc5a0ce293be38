"""A network of its own for each test: hosts in network namespaces around one switch, and what is heard on its wires.

Everything lives in namespaces that only this process and its children are in, so it is gone when they are.
"""

import ctypes
import itertools
import json
import os
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

SKIPPED = 77  # as SKIP_RETURN_CODE in CMakeLists.txt
BIN = Path(sys.argv[1]).absolute() if len(sys.argv) > 1 else Path(__file__).resolve().parents[2] / "build" / "bin"
CLONE_NEWNET = 0x40000000
MTU = 2048

# So that intervals are the drive's and not those of a busy machine. Only the root of the machine may have it.
REALTIME = ("--realtime", "10") if Path("/proc/self/uid_map").read_text().split()[1:] == ["0", "4294967295"] else ()

# Where the tools are that only root has in his path.
os.environ["PATH"] += ":/usr/sbin:/sbin"

libc = ctypes.CDLL(None, use_errno=True)


class Failure(AssertionError):
    pass


def check(condition, sentence):
    if not condition:
        raise Failure(sentence)


def skip(why):
    print(f"SKIPPED: {why}")
    sys.exit(SKIPPED)


def enter_own_world(*tools):
    """Starts this test again where it may make namespaces, or skips it."""
    if os.environ.get("SERVOBUS_NETWORK_TEST") == "inside":
        return
    for tool in ("unshare", "ip", *tools):
        if not shutil.which(tool):
            skip(f"{tool} is not there; scripts/install-dependencies test installs it")
    rights = [] if os.geteuid() == 0 else ["--map-root-user"]
    enter = ["unshare", *rights, "--net", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc"]
    if subprocess.run([*enter, "true"], capture_output=True, check=False).returncode != 0:
        skip("network namespaces cannot be made here; it takes root, or a kernel that grants them to everybody")
    os.environ["SERVOBUS_NETWORK_TEST"] = "inside"
    script = 'mkdir -p /run/netns && mount -t tmpfs none /run/netns && ip link set lo up && exec "$@"'
    os.execvp(enter[0], [*enter, "sh", "-c", script, "sh", sys.executable, "-B", "-u", *sys.argv])


def ip(*words):
    done = subprocess.run(["ip", *words], capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"ip {' '.join(words)}: {done.stderr.strip()}")
    return done.stdout


def wait_for(what, condition, seconds):
    """The first true value of the condition."""
    end = time.monotonic() + seconds
    while True:
        value = condition()
        if value:
            return value
        check(time.monotonic() < end, f"{what}: not within {seconds} s")
        time.sleep(0.05)


def mac_octets(text):
    return bytes.fromhex(text.replace(":", ""))


class Host:
    """One host: a namespace with one interface or more, each with a wire to a port of the LAN's switch."""

    def __init__(self, lan, name):
        self.lan = lan
        self.name = f"{lan.name}-{name}"
        self.processes = []
        ip("netns", "add", self.name)
        self.ip("link", "set", "lo", "up")

    def ip(self, *words):
        return ip("-n", self.name, *words)

    def addresses(self, interface="eth0"):
        listed = json.loads(self.ip("-j", "-4", "addr", "show", "dev", interface))
        return [f"{info['local']}/{info['prefixlen']}" for entry in listed for info in entry.get("addr_info", [])]

    def mac(self, interface="eth0"):
        return json.loads(self.ip("-j", "link", "show", "dev", interface))[0]["address"]

    @contextmanager
    def inside(self):
        """This thread is in the namespace; a socket that is made there stays there."""
        before = os.open("/proc/thread-self/ns/net", os.O_RDONLY)
        there = os.open(f"/run/netns/{self.name}", os.O_RDONLY)
        try:
            check(libc.setns(there, CLONE_NEWNET) == 0, f"{self.name} cannot be entered")
            yield
        finally:
            libc.setns(before, CLONE_NEWNET)
            os.close(there)
            os.close(before)

    def packets(self, interface="eth0"):
        """A socket for all frames of an interface."""
        with self.inside():
            sock = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
            sock.bind((interface, 3))
            return sock

    def connect(self, address, port, timeout=3):
        with self.inside():
            return socket.create_connection((address, port), timeout=timeout)

    def start(self, *command):
        """A program of this host. Its output is in its own file, for when something fails."""
        log = self.lan.directory / f"{self.name}-{next(self.lan.numbers)}.log"
        with log.open("w") as output:
            process = subprocess.Popen(["ip", "netns", "exec", self.name, *map(str, command)],
                                       stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT)
        process.log = log
        self.processes.append(process)
        return process

    def run(self, *command, timeout=10):
        done = subprocess.run(["ip", "netns", "exec", self.name, *map(str, command)], capture_output=True, text=True,
                              timeout=timeout, stdin=subprocess.DEVNULL, check=False)
        return done

    def stop(self, process, number=signal.SIGTERM):
        process.send_signal(number)
        process.wait(timeout=5)
        self.processes.remove(process)


class Lan:
    """A switch and its hosts."""

    def __init__(self, name, directory):
        self.name = name
        self.directory = directory
        self.numbers = itertools.count(1)
        self.hosts = []
        self.switch = self.host("switch")
        self.switch.ip("link", "add", "br0", "type", "bridge", "mcast_snooping", "0")
        self.switch.ip("link", "set", "br0", "up")

    def host(self, name, address=None):
        host = Host(self, name)
        self.hosts.append(host)
        if name != "switch":
            self.wire(host, "eth0", name)
        if address:
            host.ip("addr", "add", address, "dev", "eth0")
        return host

    def wire(self, host, interface, port):
        """A cable from the host's interface to a port of the switch of this name."""
        host.ip("link", "add", interface, "type", "veth", "peer", "name", port, "netns", self.switch.name)
        self.switch.ip("link", "set", port, "master", "br0")
        self.switch.ip("link", "set", port, "up")
        host.ip("link", "set", interface, "up")

    def close(self):
        for host in self.hosts:
            for process in list(host.processes):
                host.stop(process, signal.SIGKILL)

    def tell(self):
        """What the programs have said."""
        for log in sorted(self.directory.glob(f"{self.name}-*.log")):
            print(f"-- {log.name}\n{log.read_text(errors='replace')}")


class Ear:
    """Hears all frames at an interface, in a thread of its own, each with the time at which it came."""

    def __init__(self, host, interface="eth0"):
        self.socket = host.packets(interface)
        self.socket.setsockopt(socket.SOL_SOCKET, 35, 1)  # SO_TIMESTAMPNS
        self.heard = []
        self.stopped = False
        self.thread = threading.Thread(target=self.listen, daemon=True)
        self.thread.start()

    def listen(self):
        while not self.stopped:
            if not select.select([self.socket], [], [], 0.1)[0]:
                continue
            try:
                octets, ancillary, _, _ = self.socket.recvmsg(MTU, 256)
            except OSError:
                continue  # the link is down
            stamps = [struct.unpack("qq", data[:16]) for _, kind, data in ancillary if kind == 35]
            when = stamps[0][0] + stamps[0][1] / 1e9 if stamps else time.time()
            self.heard.append((when, octets))

    def arp(self, sender_mac):
        """(time, operation, sender's address, target's address) of all ARP of this MAC address."""
        found = []
        for when, octets in list(self.heard):
            if octets[12:14] == b"\x08\x06" and octets[22:28] == sender_mac:
                found.append((when, octets[21], socket.inet_ntoa(octets[28:32]), socket.inet_ntoa(octets[38:42])))
        return found

    def dhcp(self):
        """(time, message type, frame) of all DHCP and BOOTP; 0 is BOOTP."""
        found = []
        for when, octets in list(self.heard):
            is_dhcp = octets[12:14] == b"\x08\x00" and octets[23] == 17 and octets[34:36] in (b"\0\x43", b"\0\x44")
            if is_dhcp:
                found.append((when, message_type(octets[42 + 240:]), octets))
        return found

    def close(self):
        self.stopped = True
        self.thread.join()
        self.socket.close()


def message_type(options):
    """Option 53, or 0."""
    at = 0
    while at + 1 < len(options) and options[at] != 255:
        if options[at] == 0:
            at += 1
            continue
        if options[at] == 53:
            return options[at + 2]
        at += 2 + options[at + 1]
    return 0


def arp_frame(source, operation, sender_ip, target_mac, target_ip):
    destination = target_mac if operation == 2 else b"\xff" * 6
    return (destination + source + b"\x08\x06" + struct.pack(">HHBBH", 1, 0x0800, 6, 4, operation) + source
            + socket.inet_aton(sender_ip) + target_mac + socket.inet_aton(target_ip)).ljust(60, b"\0")


class Rival:
    """A host that says an address is his: when he is asked, or when he likes."""

    def __init__(self, host):
        self.mac = mac_octets(host.mac())
        self.socket = host.packets()
        self.addresses = set()
        self.stopped = False
        self.thread = threading.Thread(target=self.answer, daemon=True)
        self.thread.start()

    def answer(self):
        while not self.stopped:
            if not select.select([self.socket], [], [], 0.1)[0]:
                continue
            octets = self.socket.recv(MTU)
            if octets[12:14] != b"\x08\x06" or octets[21] != 1 or octets[6:12] == self.mac:
                continue
            wanted = socket.inet_ntoa(octets[38:42])
            if wanted in self.addresses or "any" in self.addresses:
                if self.addresses == {"any"}:
                    self.addresses = {wanted}
                self.socket.send(arp_frame(self.mac, 2, wanted, octets[6:12], socket.inet_ntoa(octets[28:32])))

    def announce(self, address):
        self.socket.send(arp_frame(self.mac, 1, address, b"\0" * 6, address))

    def close(self):
        self.stopped = True
        self.thread.join()
        self.socket.close()


class Drive:
    """servobus-adapter on the interface of a host."""

    def __init__(self, host, *options, config=None, prefix=()):
        self.host = host
        self.control = host.lan.directory / f"{host.name}.control"
        words = ["--manage-interface", "eth0", "--ready-json", "--control", self.control, "--log-level", "debug"]
        if config:
            file = host.lan.directory / f"{host.name}.json"
            file.write_text(json.dumps(config))
            words += ["--config", file]
        self.process = host.start(*prefix, BIN / "servobus-adapter", *words, *options)
        self.ready = wait_for("the ready line", self.ready_line, 10)

    def ready_line(self):
        check(self.process.poll() is None, "the drive does not run")
        lines = [line for line in self.process.log.read_text().splitlines() if line.startswith('{"ready"')]
        return json.loads(lines[0]) if lines else None

    def ask(self, **members):
        with socket.socket(socket.AF_UNIX) as line:
            line.settimeout(5)
            line.connect(str(self.control))
            line.sendall(json.dumps(members).encode() + b"\n")
            answer = json.loads(line.makefile().readline())
        check(answer["ok"], answer)
        return answer

    def network(self):
        return self.ask(query="network")

    def address(self):
        return self.network()["address"]

    def said(self, text):
        return text in self.process.log.read_text()


class Client:
    """A host that speaks EtherNet/IP to a drive: the scanner of this project, or octets over TCP."""

    def __init__(self, host, address):
        self.host = host
        self.address = address

    def scanner(self, verb, *words, expect=0):
        done = self.host.run(BIN / "servobus-scanner", verb, self.address, *words)
        check(done.returncode == expect, f"servobus-scanner {verb} ended with {done.returncode}: {done.stderr}")
        return done.stdout


class Session:
    """One EtherNet/IP session, held open."""

    def __init__(self, host, address):
        self.socket = host.connect(address, 44818)
        self.socket.settimeout(3)
        self.handle = 0
        self.handle = struct.unpack("<I", self.exchange(0x65, b"\1\0\0\0")[4:8])[0]

    def exchange(self, command, data):
        self.socket.sendall(struct.pack("<HHII8sI", command, len(data), self.handle, 0, b"network!", 0) + data)
        header = self.read(24)
        return header + self.read(struct.unpack("<H", header[2:4])[0])

    def read(self, count):
        octets = b""
        while len(octets) < count:
            piece = self.socket.recv(count - len(octets))
            check(piece, "the drive has closed the connection")
            octets += piece
        return octets

    def call(self, hexadecimal):
        """A request and its response, as hex without the encapsulation."""
        message = bytes.fromhex(hexadecimal)
        packet = struct.pack("<IHHHHHH", 0, 0, 2, 0, 0, 0xB2, len(message)) + message
        return self.exchange(0x6F, packet)[40:].hex()

    def get(self, class_id, attribute):
        answer = self.call(f"0e0320{class_id:02x}240130{attribute:02x}")
        check(answer.startswith("8e000000"), f"Get 0x{class_id:X}/1/{attribute}: {answer}")
        return bytes.fromhex(answer[8:])

    def set(self, class_id, attribute, value):
        answer = self.call(f"100320{class_id:02x}240130{attribute:02x}" + value.hex())
        check(answer == "90000000", f"Set 0x{class_id:X}/1/{attribute}: {answer}")

    def is_open(self):
        """Whether the drive has not closed it."""
        if not select.select([self.socket], [], [], 0)[0]:
            return True
        try:
            return self.socket.recv(1, socket.MSG_PEEK) != b""
        except OSError:
            return False

    def close(self):
        self.socket.close()


def run_beside_each_other(scenes, directory):
    """Each scene is a function of a Lan; they share nothing. Prints what each says; exits with 1 if one failed."""
    failures = []

    def play(scene):
        lan = Lan(scene.__name__, directory)
        began = time.monotonic()
        try:
            measured = scene(lan)
            told = f"; {measured}" if measured else ""
            print(f"ok: {scene.__name__}: {scene.__doc__} ({time.monotonic() - began:.1f} s{told})", flush=True)
        except Exception as error:  # whatever it is, it is about this scene
            failures.append(scene.__name__)
            print(f"FAILED: {scene.__name__}: {type(error).__name__}: {error}", flush=True)
            lan.tell()
        finally:
            lan.close()

    threads = [threading.Thread(target=play, args=(scene,)) for scene in scenes]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    sys.exit(bool(failures))
