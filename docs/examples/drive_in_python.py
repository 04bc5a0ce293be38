#!/usr/bin/env python3
"""A test of a client against a drive of its own, with nothing but Python's standard library.

    drive_in_python.py [DIRECTORY OF THE PROGRAMS] [ADDRESS]
"""

import json
import subprocess
import sys
import unittest

BIN = sys.argv[1] if len(sys.argv) > 1 else "build/bin"
ADDRESS = sys.argv[2] if len(sys.argv) > 2 else "127.0.0.1"


class Drive:
    """A servobus-adapter of its own. `with Drive() as drive:` waits until it listens, and stops it in the end."""

    def __init__(self, *options):
        command = [f"{BIN}/servobus-adapter", "--bind", ADDRESS, "--port", "0", "--log-level", "error"]
        self.process = subprocess.Popen([*command, "--ready-json", "--control", "-", *options],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)

    def __enter__(self):
        self.ready = json.loads(self.process.stdout.readline())
        self.port = self.ready["drives"][0]["port"]
        return self

    def __exit__(self, *_):
        self.ask(command="stop")
        assert self.process.wait(10) == 0
        self.process.stdin.close()
        self.process.stdout.close()

    def ask(self, **line):
        """One control line; its answer."""
        self.process.stdin.write(json.dumps(line) + "\n")
        answer = json.loads(self.process.stdout.readline())
        assert answer["ok"], answer
        return answer


def client(drive, *words, timeout=5):
    """The client under test; put your own here. Its exit code, and what it says."""
    command = [f"{BIN}/servobus-scanner", words[0], f"{ADDRESS}:{drive.port}", *words[1:]]
    done = subprocess.run([*command, "--timeout", str(timeout), "--json"], capture_output=True, text=True)
    return done.returncode, done.stdout


class ClientTest(unittest.TestCase):
    def test_reads_what_the_drive_has(self):
        with Drive() as drive:
            code, said = client(drive, "get", "Statusword")
            self.assertEqual(code, 0)
            self.assertIn(str(drive.ask(query="state")["statusword"]), said)

    def test_gives_up_when_its_reply_is_lost_and_gets_through_afterwards(self):
        with Drive() as drive:
            drive.ask(event="withhold-replies", count=1)
            self.assertEqual(client(drive, "get", "Statusword", timeout=0.5)[0], 3)
            self.assertEqual(client(drive, "get", "Statusword")[0], 0)
            self.assertEqual(drive.ask(query="counters")["faults"]["replies_withheld"], 1)

    def test_waits_for_a_drive_that_hangs_for_a_moment(self):
        with Drive() as drive:
            drive.ask(event="freeze", seconds=0.3)
            self.assertEqual(client(drive, "get", "Statusword")[0], 0)

    def test_says_why_the_axis_did_not_move(self):
        with Drive() as drive:
            drive.ask(event="block-axis")
            self.assertEqual(client(drive, "axis", "reference", timeout=10)[0], 6)
            self.assertNotEqual(drive.ask(query="state")["error"], 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
