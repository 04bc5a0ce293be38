#!/usr/bin/env python3
"""The committed data sheets, read by a second reader. No EDS reader of anybody else can be installed from the
distribution or from npm, so this one is our own: written from the rules R-EDS-1 to R-EDS-10 and from the transcripts of
the manual in tests/reference alone. Its tokens, types and sums share nothing with eds/. The icon is judged by icotool."""

import base64
import csv
import datetime
import re
import struct
import tempfile
from pathlib import Path

from judge import HERE, check, run

SHEETS = HERE.parents[1] / "eds"
REFERENCE = HERE.parent / "reference"
VARIANTS = {"75V8S": (0x7509, "XENAX Xvi 75V8S"), "75V8": (0x7508, "XENAX Xvi 75V8"), "48V8": (0x4808, "XENAX Xvi 48V8")}
FORCE_CLASS = 0x6E

TOKEN = re.compile(r"""
    (?P<blank>\s+|\$[^\n]*) | (?P<section>\[[^\]\n]*\]) | (?P<string>"(?:[^"\\\n]|\\.)*") | (?P<mark>[=,;])
    | (?P<word>[^\s"=,;\[\]$]+)
    """, re.VERBOSE)

# Code: format of struct, for the types that the manual has.
TYPES = {0xC2: "b", 0xC3: "h", 0xC4: "i", 0xC6: "B", 0xC7: "H", 0xC8: "I"}
CODES = {"SINT": 0xC2, "INT": 0xC3, "DINT": 0xC4, "USINT": 0xC6, "UINT": 0xC7, "UDINT": 0xC8, "STRING": 0xD0}


def tokens(text):
    at = 0
    while at < len(text):
        match = TOKEN.match(text, at)
        check(match is not None, f"line {text.count(chr(10), 0, at) + 1} has no token at {text[at:at + 20]!r}")
        at = match.end()
        if match.lastgroup != "blank":
            yield match.lastgroup, match.group()


class Text(str):
    """A field in quotes."""


def read(text):
    """{section: {keyword: [fields]}}, with sections and keywords in their order. A field is a word, a Text or ''."""
    sheet, entries, words = {}, None, []
    stream = list(tokens(text))
    at = 0
    while at < len(stream):
        kind, token = stream[at]
        if kind == "section":
            check(token[1:-1] not in sheet, f"{token} comes once")
            entries = sheet[token[1:-1]] = {}
            at += 1
            continue
        check(kind == "word" and stream[at + 1] == ("mark", "="), f"'{token}' is a keyword before '='")
        check(token not in entries, f"{token} comes once in its section")
        fields, field, at = [], "", at + 2
        while True:
            kind, value = stream[at]
            at += 1
            if kind == "mark":
                fields.append(field)
                field = ""
                if value == ";":
                    break
                check(value == ",", f"a field of {token} has no '='")
            elif kind == "string":
                check(field == "" or isinstance(field, Text), f"a field of {token} is a word or strings, not both")
                field = Text(field + re.sub(r"\\(.)", r"\1", value[1:-1]))
            else:
                check(kind == "word" and field == "", f"a field of {token} is one word")
                field = value
        entries[token] = fields
    return sheet


def number(word):
    check(not isinstance(word, Text), f"'{word}' is a number without quotes")
    return int(word, 0)


def path(field):
    check(isinstance(field, Text), f"the path '{field}' is in quotes")
    return bytes.fromhex(field)


def numbered(section, prefix):
    """{N: fields} of the keywords prefix + N."""
    return {int(key[len(prefix):]): fields for key, fields in section.items() if re.fullmatch(prefix + r"\d+", key)}


def check_head(sheet, variant):
    """R-EDS-2, R-EDS-3, R-EDS-4."""
    code, name = VARIANTS[variant]
    check(list(sheet)[:3] == ["File", "Device", "Device Classification"], "the first three sections are in order")
    file, device = sheet["File"], sheet["Device"]
    for key in ("CreateDate", "ModDate"):
        datetime.datetime.strptime(file[key][0], "%m-%d-%Y")
    for key in ("CreateTime", "ModTime"):
        datetime.datetime.strptime(file[key][0], "%H:%M:%S")
    check(file["Revision"] == ["1.0"] and "EDSFileCRC" not in file, "revision 1.0, and no checksum that nobody can check")
    found = [number(device[key][0]) for key in ("VendCode", "ProdType", "ProdCode", "MajRev", "MinRev")]
    check(found == [1389, 43, code, 1, 1], f"{found} is who the device is")
    check(device["ProdName"] == [name] and len(name) <= 32, "the product name is the device's")
    check(sheet["Device Classification"] == {"Class1": ["EtherNetIP"]}, "it is on EtherNet/IP")


def check_icon(device):
    check(device["Icon"] == ["XENAX.ico"], "the icon has a name")
    with tempfile.NamedTemporaryFile(suffix=".ico") as icon:
        icon.write(base64.b64decode(device["IconContents"][0], validate=True))
        icon.flush()
        listed = run("icotool", "-l", icon.name)
    check(listed.split() == "--icon --index=1 --width=32 --height=32 --bit-depth=4 --palette-size=16".split(),
          "icotool sees one picture of 32 x 32 pixels in 16 colours")


def check_value(name, code, low, high, default):
    """The three numbers fit the type and each other."""
    for value in (low, high, default):
        if value is not None:
            struct.pack("<" + TYPES[code], value)
    check(low <= high and (default is None or low <= default <= high), f"the limits of {name} are in order")


def check_param(n, fields):
    """R-EDS-5. Returns (class, attribute), or None for one without a path."""
    check(len(fields) == 21, f"Param{n} has 21 fields")
    zero, size, way, descriptor, code, octets, name, units, text = fields[:9]
    check(number(zero) == 0 and isinstance(name, Text) and name and isinstance(units, Text) and isinstance(text, Text),
          f"Param{n} has its texts")
    code, octets = number(code), number(octets)
    check(number(descriptor) & ~0x0092 == 0, f"Param{n} has no bits but enumerated, gaps and read only")
    check(fields[12:] == ["1", "1", "1", "0", "", "", "", "", "0"], f"Param{n} is not scaled")
    if code == 0xD0:
        check(number(fields[9]) == 0 and len(fields[11]) <= number(fields[10]) == octets - 2,
              f"the text of Param{n} has a length in front")
    else:
        check(octets == struct.calcsize("<" + TYPES[code]), f"Param{n} is as large as its type")
        check_value(name, code, number(fields[9]), number(fields[10]), number(fields[11]) if fields[11] else None)
    if way == "":
        check(size == "", f"Param{n} has neither path nor size")
        return None
    way = path(way)
    check(len(way) == number(size) and (way[0], way[2:4], way[4]) == (0x20, b"\x24\x01", 0x30),
          f"the path of Param{n} is class, instance 1, attribute")
    return way[1], way[5]


def check_params(sheet, variant):
    """All of the manual's attributes that the variant has, with type and access as printed."""
    params = numbered(sheet["Params"], "Param")
    where = {n: check_param(n, fields) for n, fields in params.items()}
    check(list(params) == list(range(1, len(params) + 1)) and number(sheet["ParamClass"]["MaxInst"][0]) == len(params),
          "Params are numbered from 1, and MaxInst is the highest")
    names = [fields[6] for fields in params.values()]
    check(len(set(names)) == len(names), "no name comes twice")
    enumerated = {n for n, fields in params.items() if number(fields[3]) & 2}
    check(set(numbered(sheet["Params"], "Enum")) == enumerated, "what is enumerated has an Enum")
    by_address = {address: params[n] for n, address in where.items() if address}
    check(len(by_address) == sum(address is not None for address in where.values()), "no attribute comes twice")
    printed = 0
    for row in csv.DictReader((REFERENCE / "xenax_cip_attributes.csv").open(encoding="utf-8")):
        address = int(row["class_id"], 16), int(row["attribute_id"], 16)
        if not 0x64 <= address[0] <= FORCE_CLASS or address not in by_address:
            continue
        printed += 1
        fields = by_address[address]
        code = CODES[row["type"].split("(")[0]]
        # Errata X-17: 0x68/4 is unsigned, since its upper limit is 0xFFFF.
        check(number(fields[4]) == (0xC7 if address == (0x68, 4) else code), f"{address} has its printed type")
        # Errata X-14: 0x6E/0xB is information.
        reads_only = row["access"] == "Get" or address == (0x6E, 0x0B)
        check(bool(number(fields[3]) & 0x10) == reads_only, f"{address} has its printed access")
    check(printed == len(by_address), f"all {len(by_address)} Params with a path are attributes of the manual")
    has_force = any(address[0] == FORCE_CLASS for address in by_address)
    check(has_force == (variant == "75V8S"), "only the 75V8S has the class of the force option")
    return params, where


def check_groups(sheet, params):
    """R-EDS-6."""
    listed = []
    for n, fields in numbered(sheet["Groups"], "Group").items():
        check(len(fields) == 2 + number(fields[1]), f"Group{n} has as many members as it says")
        listed += [number(word) for word in fields[2:]]
    check(sorted(listed) == [n for n, fields in params.items() if fields[2] != ""], "each Param is in one group")


def check_assemblies(sheet, where, variant):
    """R-EDS-7, and the transcript of the manual: which attribute is where in which assembly."""
    sizes = {}
    placed = {}
    for n, fields in numbered(sheet["Assembly"], "Assem").items():
        check(path(fields[1]) == bytes([0x20, 4, 0x24, n, 0x30, 3]) and fields[4:6] == ["", ""], f"Assem{n} has its path")
        sizes[n] = number(fields[2])
        offset = 0
        for bits, member in zip(fields[6::2], fields[7::2]):
            if member:
                placed[n, offset] = where[int(member.removeprefix("Param"))]
            offset += number(bits)
        check(len(fields) % 2 == 0 and offset == 8 * sizes[n], f"the members of Assem{n} have its octets")
    for row in csv.DictReader((REFERENCE / "xenax_assemblies.csv").open(encoding="utf-8")):
        n = int(row["assembly"])
        check(sizes[n] == int(row["assembly_bytes"]), f"Assem{n} is as large as printed")
        if not row["class"]:
            continue
        address = int(row["class"], 16), int(row["attribute"], 16)
        expected = address if address in where.values() else None
        check(placed.pop((n, 8 * int(row["offset"])), None) == expected, f"{row['name']} is in its place of Assem{n}")
        check(expected or variant != "75V8S", f"the 75V8S has {row['name']}")
    check(not placed, "no member is anywhere else")
    counts = [number(sheet["Assembly"][key][0]) for key in ("Object_Class_Code", "MaxInst", "Number_Of_Static_Instances")]
    check(counts == [4, max(sizes), len(sizes)], "the class counts its instances")
    return sizes


def check_connections(sheet, params, sizes):
    """R-EDS-8, R-EDS-9, with the numbers of R-DEV-6 and R-DEV-7."""
    pairs = {"Standard": (101, 100), "I Force": (102, 100), "Digital Outputs": (103, 100), "Force": (104, 105),
             "CIP Sync": (112, 113), "Input only": (254, 100)}
    connections = numbered(sheet["Connection Manager"], "Connection")
    check([fields[12] for fields in connections.values()] == list(pairs), "there are the six connections")
    for n, fields in connections.items():
        check(len(fields) == 15, f"Connection{n} has 15 fields")
        out, into = pairs[fields[12]]
        owner = out != 254
        check([number(word) for word in fields[:2]] ==
              ([0x04010002, 0x44640405] if owner else [0x02010002, 0x44640305]), f"Connection{n} has the words of R-EDS-9")
        rpi = params[int(fields[2].removeprefix("Param"))]
        check(fields[5] == fields[2] and [number(word) for word in rpi[9:12]] == [1000, 3200000, 10000],
              "intervals are 1 ms to 3.2 s, and 10 ms unless asked for")
        check(fields[3:5] == ([str(sizes[out]), f"Assem{out}"] if owner else ["0", ""]), f"O->T of Connection{n}")
        check(fields[6:8] == [str(sizes[into]), f"Assem{into}"], f"T->O of Connection{n}")
        check(fields[8:12] == [""] * 4, f"Connection{n} needs no configuration")
        check(path(fields[14]) == bytes([0x20, 4, 0x24, 1, 0x2C, out, 0x2C, into]), f"the path of Connection{n}")


def check_network(sheet):
    """R-EDS-10."""
    check(sheet["Port"] == {"Port1": ["TCP", "EtherNet/IP", "20 F5 24 01", "2"]}, "one port, at the TCP/IP object")
    capacity = sheet["Capacity"]
    direction, size, packets = capacity["TSpec1"]
    check(direction == "TxRx" and number(size) == 54 and number(packets) > 0 and number(capacity["MaxIOConnections"][0]) == 9,
          "the capacity is that of an owner and eight who look on")
    classes = {"Identity Class": (1, 1, 1), "File Class": (0x37, 3, 201), "DLR Class": (0x47, 3, 1),
               "QoS Class": (0x48, 1, 1), "TCP/IP Interface Class": (0xF5, 4, 1), "Ethernet Link Class": (0xF6, 4, 2)}
    for name, expected in classes.items():
        found = tuple(number(sheet[name][key][0]) for key in ("Object_Class_Code", "Revision", "MaxInst"))
        check(found == expected, f"[{name}] is {expected}, and says {found}")


for variant in VARIANTS:
    octets = (SHEETS / f"XENAX_XVI_{variant}_EtherNetIP.eds").read_bytes()
    sheet = read(octets.decode("iso-8859-1"))
    check_head(sheet, variant)
    check_icon(sheet["Device"])
    params, where = check_params(sheet, variant)
    check_groups(sheet, params)
    sizes = check_assemblies(sheet, where, variant)
    check_connections(sheet, params, sizes)
    check_network(sheet)
    print(f"{variant}: {len(octets)} octets, {len(params)} Params, {len(sizes)} assemblies, nothing against it")
