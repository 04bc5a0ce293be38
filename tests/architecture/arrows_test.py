#!/usr/bin/env python3
"""That arrows.py catches what it is there for: each wrong include and link in a small tree of its own."""

import tempfile
import unittest
from pathlib import Path

from arrows import check


class Arrows(unittest.TestCase):
    def findings(self, files):
        with tempfile.TemporaryDirectory() as root:
            for name, text in files.items():
                path = Path(root, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
            return check(Path(root))

    def assert_fine(self, file, line):
        findings, includes, links = self.findings({file: line})
        self.assertEqual(findings, [])
        self.assertEqual(includes + links, 1)

    def assert_wrong(self, file, line):
        findings, _, _ = self.findings({file: line})
        self.assertEqual(len(findings), 1, f"{line} in {file} was not caught")

    def test_allowed_includes(self):
        self.assert_fine("drive/a.cpp", "#include <vector>")
        self.assert_fine("drive/a.cpp", '#include "drive/a.hpp"')
        self.assert_fine("cip/a.hpp", "#include <boost/system/result.hpp>")
        self.assert_fine("cip/a.hpp", "#include <fmt/format.h>")
        self.assert_fine("assemblies/a.cpp", '#include "drive/a.hpp"')
        self.assert_fine("enip/a.cpp", '#include "cip/a.hpp"')
        self.assert_fine("enip/asio/a.cpp", "#include <boost/asio/ip/tcp.hpp>")
        self.assert_fine("adapter/main.cpp", "#include <nlohmann/json.hpp>")
        self.assert_fine("adapter/main.cpp", '#include "enip/asio/a.hpp"')
        self.assert_fine("scanner/examples/a.cpp", '#include "scanner/a.hpp"')
        self.assert_fine("eds/a.cpp", '#include "assemblies/a.hpp"')
        self.assert_fine("scanner/a.cpp", "#include <zlib.h>")

    def test_wrong_includes(self):
        self.assert_wrong("drive/a.cpp", '#include "cip/a.hpp"')
        self.assert_wrong("drive/a.cpp", "#include <boost/system/result.hpp>")
        self.assert_wrong("drive/a.cpp", "#include <fmt/format.h>")
        self.assert_wrong("cip/a.hpp", '#include "drive/a.hpp"')
        self.assert_wrong("cip/a.hpp", "#  include <boost/asio.hpp>")
        self.assert_wrong("cip/a.hpp", "#include <boost/filesystem/path.hpp>")
        self.assert_wrong("enip/a.cpp", '#include "enip/asio/a.hpp"')
        self.assert_wrong("enip/a.cpp", '#include "assemblies/a.hpp"')
        self.assert_wrong("enip/a.cpp", "#include <boost/asio/buffer.hpp>")
        self.assert_wrong("enip/asio/a.cpp", '#include "drive/a.hpp"')
        self.assert_wrong("enip/asio/a.cpp", "#include <spdlog/spdlog.h>")
        self.assert_wrong("assemblies/a.cpp", '#include "enip/a.hpp"')
        self.assert_wrong("adapter/a.cpp", '#include "scanner/a.hpp"')
        self.assert_wrong("adapter/a.cpp", "#include <scanner/a.hpp>")
        self.assert_wrong("adapter/a.cpp", "#include <boost/asio/io_context.hpp>")
        self.assert_wrong("scanner/a.cpp", '#include "adapter/a.hpp"')
        self.assert_wrong("adapter/a.cpp", "#include <zlib.h>")
        self.assert_wrong("eds/a.cpp", '#include "adapter/a.hpp"')
        self.assert_wrong("adapter/a.cpp", '#include "a.hpp"')

    def test_allowed_links(self):
        self.assert_fine("cip/CMakeLists.txt", "servobus_library(cip SOURCES a.cpp LINKS Boost::headers)")
        self.assert_fine("enip/CMakeLists.txt", "servobus_library(enip_asio SOURCES a.cpp LINKS servobus_enip)")
        self.assert_fine("adapter/CMakeLists.txt", "target_link_libraries(servobus_adapter_main PRIVATE CLI11::CLI11)")
        self.assert_fine("adapter/CMakeLists.txt", "target_link_libraries(servobus_adapter_main servobus_adapter)")

    def test_wrong_links(self):
        self.assert_wrong("drive/CMakeLists.txt", "servobus_library(drive SOURCES a.cpp LINKS fmt::fmt)")
        self.assert_wrong("cip/CMakeLists.txt", "servobus_library(cip SOURCES a.cpp\n    LINKS servobus::drive)")
        self.assert_wrong("enip/CMakeLists.txt", "servobus_library(enip SOURCES a.cpp LINKS servobus_enip_asio)")
        self.assert_wrong("enip/CMakeLists.txt", "servobus_library(enip_asio SOURCES a.cpp LINKS servobus::drive)")
        self.assert_wrong("scanner/CMakeLists.txt", "target_link_libraries(servobus_scanner PRIVATE servobus_adapter)")
        self.assert_wrong("adapter/CMakeLists.txt", "servobus_library(adapter SOURCES a.cpp LINKS ZLIB::ZLIB)")
        self.assert_wrong("scanner/CMakeLists.txt", "target_link_libraries(servobus_scanner_main servobus_adapter_cli)")

    def test_an_empty_tree_has_nothing_to_look_at(self):
        self.assertEqual(self.findings({}), ([], 0, 0))


if __name__ == "__main__":
    unittest.main()
