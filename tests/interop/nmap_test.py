#!/usr/bin/env python3
"""nmap's enip-info script must recognise the drive and print its identity."""

import re

from judge import PORT, check, own_address, run, running_drive

EXPECTED = {
    "type": "Generic Device (keyable) (43)",
    "vendor": "Jenny Science AG (1389)",
    "productName": "XENAX Xvi 75V8S",
    "productCode": str(0x7509),
    "revision": "1.1",
}

address = own_address()
with running_drive(address, "--variant", "75v8s"):
    output = run("nmap", "-sT", "-Pn", "-n", "--script", "enip-info", "-p", PORT, address)

found = dict(re.findall(r"^\|[ _] +(\w+): (.*?)\s*$", output, re.MULTILINE))
for key, value in EXPECTED.items():
    check(found.get(key) == value, f"nmap read {key} as {found.get(key)!r} and not as {value!r}")
check(int(found.get("serialNumber", "0"), 16) != 0, "nmap read no serial number")
check(found.get("deviceIp") == address, f"nmap read the drive's own address as {found.get('deviceIp')}")
