#!/usr/bin/env python3
"""Writes a firmware image that servobus-adapter takes (--flash, and the command "download" of its control channel).

    docs/examples/make_flash.py --version 1.05 --revision 2.1 new.flash

The format is described in adapter/flash_image.hpp. It is our own: the maker's is not public. What the image holds is nothing
but octets; their number decides how long a download takes.
"""

import argparse
import random
import struct
import sys
import zlib

MAGIC = b"SVBFLASH"
FORMAT = 1
PRODUCTS = {"75v8s": 0x7509, "75v8": 0x7508, "48v8": 0x4808}


def pair(text):
    """Two numbers of an octet each with a dot between them."""
    major, dot, minor = text.partition(".")
    if not (dot and major.isdecimal() and minor.isdecimal() and int(major) < 256 and int(minor) < 256):
        raise argparse.ArgumentTypeError(f"'{text}' is not two numbers with a dot between them, such as 1.05")
    return int(major), int(minor)


def image(version, revision, product_codes, bit_stream, firmware):
    """The octets of an image with two parts of so many octets."""
    noise = random.Random(0)
    head = MAGIC + struct.pack("<HBBBBHII", FORMAT, *version, *revision, len(product_codes), bit_stream, firmware)
    codes = struct.pack(f"<{len(product_codes)}H", *product_codes)
    content = head + codes + noise.randbytes(bit_stream + firmware)
    return content + struct.pack("<I", zlib.crc32(content))


def main():
    parser = argparse.ArgumentParser(description="Writes a firmware image for servobus-adapter.")
    parser.add_argument("file", help="where it is written, XENAX_EtherNetIP_protocol_V1.05.flash for example")
    parser.add_argument("--version", type=pair, required=True, metavar="X.XX", help="of the firmware")
    parser.add_argument("--revision", type=pair, default=(0, 0), metavar="MAJOR.MINOR",
                        help="that Identity tells with it; without it the revision stays as it is")
    parser.add_argument("--variant", choices=sorted(PRODUCTS), action="append",
                        help="a drive that it is for; may be given again (all of them unless given)")
    parser.add_argument("--bit-stream", type=int, default=393216, metavar="OCTETS", help="393216 unless given")
    parser.add_argument("--firmware", type=int, default=262144, metavar="OCTETS", help="262144 unless given")
    arguments = parser.parse_args()
    codes = [PRODUCTS[key] for key in arguments.variant or PRODUCTS]
    content = image(arguments.version, arguments.revision, codes, arguments.bit_stream, arguments.firmware)
    with open(arguments.file, "wb") as file:
        file.write(content)
    print(f"{arguments.file}: {len(content)} octets")


if __name__ == "__main__":
    sys.exit(main())
