#!/usr/bin/env python3
"""Holds the arrows of docs/architecture.md: which folder may include which, and that CMake links the same.

    arrows.py SOURCE_TREE

Prints one line per wrong include or link and fails when there is any, or when it found nothing to look at.
"""

import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

# No sockets, no files, no threads: Boost as `cip/` and everything above it may use it.
BOOST_WITH_IO = {"asio", "asio.hpp", "beast", "beast.hpp", "filesystem", "filesystem.hpp", "interprocess", "iostreams",
                 "process", "process.hpp", "thread", "thread.hpp", "fiber", "cobalt", "mysql", "redis"}


@dataclass(frozen=True)
class Folder:
    """What one folder may include: other folders, Boost without I/O, Boost.Asio, and further libraries."""
    folders: frozenset = field(default_factory=frozenset)
    boost: bool = True
    asio: bool = False
    libraries: frozenset = frozenset({"fmt"})


def folder(*folders, **rest):
    return Folder(frozenset(folders), **rest)


PROGRAM = frozenset({"fmt", "nlohmann", "CLI", "spdlog"})
DEVICE = ("enip", "enip/asio", "assemblies", "cip", "drive", "eds")

ARROWS = {
    "drive": folder(boost=False, libraries=frozenset()),
    "cip": folder(),
    "assemblies": folder("cip", "drive"),
    "enip": folder("cip"),
    "enip/asio": folder("enip", "cip", asio=True),
    "eds": folder("assemblies", "cip", "drive"),
    "adapter": folder(*DEVICE, libraries=PROGRAM),
    "scanner": folder(*DEVICE, libraries=PROGRAM | {"zlib.h"}),
}

# What a link in a CMakeLists.txt lets a folder include.
EXTERNAL_LINKS = {"fmt": "fmt", "nlohmann_json": "nlohmann", "CLI11": "CLI", "spdlog": "spdlog",
                  "ZLIB": "zlib.h"}

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
LINKS = re.compile(r"\b(?:servobus_library|target_link_libraries)\s*\(\s*(\w+)([^)]*)\)")


def owner(path):
    """The folder of ARROWS that a path inside the tree belongs to, or None."""
    parts = Path(path).parts
    for length in (2, 1):
        name = "/".join(parts[:length])
        if len(parts) > length and name in ARROWS:
            return name
    return None


def wrong_include(name, bracket, header):
    """Why folder `name` may not include `header`, or None."""
    rules = ARROWS[name]
    if bracket == '"':
        target = owner(header)
        if target is None:
            return f'"{header}" is in no folder of the map; write "folder/file.hpp"'
        if target == name or target in rules.folders:
            return None
        return f"{name}/ may not include {target}/"
    library, _, rest = header.partition("/")
    if library == "boost":
        part = rest.partition("/")[0]
        if part in ("asio", "asio.hpp"):
            return None if rules.asio else f"{name}/ may not include Boost.Asio"
        if not rules.boost:
            return f"{name}/ may not include Boost"
        return None if part not in BOOST_WITH_IO else f"{name}/ may not include Boost with input and output"
    if library in EXTERNAL_LINKS.values() or (rest and library in ARROWS):
        return None if library in rules.libraries else f"{name}/ may not include <{header}>"
    return None


def target_owner(target):
    """The folder of a target of ours: `servobus_adapter_main` belongs to adapter/."""
    target = target.removeprefix("servobus::").removeprefix("servobus_")
    return "enip/asio" if target == "enip_asio" else target.partition("_")[0]


def wrong_link(name, link):
    """Why folder `name` may not link `link`, or None."""
    rules = ARROWS[name]
    if link.startswith("servobus"):
        target = target_owner(link)
        fine = target in (name, "options") or target in rules.folders
        return None if fine else f"{name}/ may not link {link}"
    library, separator, _ = link.partition("::")
    if not separator or library == "Threads":
        return None
    if library == "Boost":
        return None if rules.boost else f"{name}/ may not link {link}"
    include = EXTERNAL_LINKS.get(library)
    return None if include in rules.libraries else f"{name}/ may not link {link}"


def check(root):
    """All findings in a source tree, and how many includes and links were looked at."""
    findings, includes, links = [], 0, 0
    for top in sorted({name.split("/")[0] for name in ARROWS}):
        for path in sorted(Path(root, top).rglob("*")):
            relative = path.relative_to(root)
            name = owner(relative)
            if path.suffix in (".hpp", ".cpp"):
                for match in INCLUDE.finditer(path.read_text(encoding="utf-8")):
                    includes += 1
                    if why := wrong_include(name, *match.groups()):
                        findings.append(f"{relative}: {why}")
            elif path.name == "CMakeLists.txt":
                text = re.sub(r"#.*", "", path.read_text(encoding="utf-8"))
                for target, rest in LINKS.findall(text):
                    linker = "enip/asio" if target_owner(target) == "enip/asio" else name
                    for link in re.findall(r"[\w:]*::\w+|servobus_\w+", rest):
                        links += 1
                        if why := wrong_link(linker, link):
                            findings.append(f"{relative}: {why}")
    return findings, includes, links


def main():
    findings, includes, links = check(Path(sys.argv[1]))
    for finding in findings:
        print(finding)
    print(f"{includes} includes and {links} links looked at, {len(findings)} against the arrows")
    if includes == 0 or links == 0:
        print("there was nothing to look at: is this the source tree?")
    sys.exit(bool(findings) or includes == 0 or links == 0)


if __name__ == "__main__":
    main()
