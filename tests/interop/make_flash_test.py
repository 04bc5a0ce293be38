#!/usr/bin/env python3
"""An image that docs/examples/make_flash.py has written, with Python's own CRC, goes into a drive: after power off and on
the revision that Identity tells is that of the image, and a power cut in the middle of a download leaves nobody there.
"""

import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from judge import BIN, HERE, check, own_address, run

MAKE_FLASH = HERE.parents[1] / "docs" / "examples" / "make_flash.py"
PATIENCE = 20


class Drive:
    """A drive with its control lines. It does not outlive the block that it is for."""

    def __init__(self, address, *options):
        command = [str(BIN / "servobus-adapter"), "--bind", address, "--ready-json", "--control", "-", *options]
        print("$", *command, flush=True)
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        check(json.loads(self.process.stdout.readline())["ready"], "the drive is not ready")

    def tell(self, **line):
        self.process.stdin.write(json.dumps(line) + "\n")
        self.process.stdin.flush()
        answer = json.loads(self.process.stdout.readline())
        print(json.dumps(line), "->", json.dumps(answer), flush=True)
        return answer

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait(PATIENCE)

    def stop(self):
        self.tell(command="stop")
        check(self.process.wait(PATIENCE) == 0, "the drive did not end in order")


def identified(address, expect=0):
    return run(BIN / "servobus-scanner", "identity", address, "--json", expect=expect)


def wait_until_written(drive):
    for _ in range(PATIENCE * 20):
        if drive.tell(query="firmware")["download"] is None:
            return
        time.sleep(0.05)
    check(False, "the download does not end")


def main():
    address = own_address()
    with tempfile.TemporaryDirectory() as directory:
        image = str(Path(directory) / "new.flash")
        small = ["--bit-stream", "9000", "--firmware", "7000"]
        run(MAKE_FLASH, "--version", "1.05", "--revision", "2.7", *small, image)
        with Drive(address) as drive:
            check(drive.tell(command="download", file=image)["ok"], "the image is refused")
            check(drive.tell(query="lights")["ST2"]["mode"] == "blink", "ST2 does not blink")
            wait_until_written(drive)
            check(drive.tell(query="firmware")["pending"]["version"] == "1.05", "nothing is pending")
            check('"1.1"' in identified(address), "the new revision is told before the power cycle")
            drive.tell(event="power-cycle")
            check('"2.7"' in identified(address), "the new revision is not told")
            sheet = Path(directory) / "uploaded.eds"
            run(BIN / "servobus-scanner", "eds", "upload", address, "--output", sheet)
            told = re.findall(r"(MajRev|MinRev) = (\d+);", sheet.read_text("latin-1"))
            check(told == [("MajRev", "2"), ("MinRev", "7")], f"the data sheet tells {told}")

            large = str(Path(directory) / "large.flash")
            run(MAKE_FLASH, "--version", "1.06", large)
            check(drive.tell(command="download", file=large)["ok"], "the second image is refused")
            drive.tell(event="power-cycle")
            check(drive.tell(query="lights")["ST1"]["mode"] == "blink", "ST1 does not blink")
            check(drive.tell(query="firmware")["mode"] == "factory", "it is not in factory mode")
            drive.stop()

        with Drive(address, "--flash", image) as drive:
            check('"2.7"' in identified(address), "--flash does not count")
            drive.stop()
        other = str(Path(directory) / "other.flash")
        run(MAKE_FLASH, "--version", "1.05", "--variant", "48v8", *small, other)
        run(BIN / "servobus-adapter", "--bind", address, "--flash", other, expect=2)
        octets = bytearray(Path(image).read_bytes())
        octets[100] ^= 1
        Path(image).write_bytes(octets)
        run(BIN / "servobus-adapter", "--bind", address, "--flash", image, expect=2)
    print("every image did what it should")


if __name__ == "__main__":
    sys.exit(main())
