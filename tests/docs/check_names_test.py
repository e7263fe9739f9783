#!/usr/bin/env python3
"""What check_names.py takes and what it refuses, in a tree made for it."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from check_names import IsPath, IsSymbol, Missing  # noqa: E402


class NamesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        subprocess.run(["git", "init", "-q", str(self.root)], check=True)
        (self.root / "rhi").mkdir()
        (self.root / "rhi/device.h").write_text("class Device { void WaitFor(int value); static int kCount; };\n")

    def MissingOf(self, page, allowed=()):
        (self.root / "README.md").write_text(page)
        return Missing(self.root, set(allowed))[0]

    def test_what_is_there_is_taken(self):
        self.assertEqual(self.MissingOf("`rhi/device.h`, `device.h`, `rhi/`, `rhi/device`, `rhi/*.h`, `rhi/{device,device}.h`, "
                                        "`Device::WaitFor(value)`, `kCount`, `WaitFor`"), [])

    def test_what_is_missing_is_named_with_its_line(self):
        self.assertEqual(self.MissingOf("first\n`rhi/queue.h` and `rhi/{device,queue}.h`\n`Device::WaitForAll(1)`, `kSum`"),
                         ["README.md:2: `rhi/queue.h`: there is no such file",
                          "README.md:2: `rhi/{device,queue}.h`: there is no such file",
                          "README.md:3: `Device::WaitForAll(1)`: no source file has WaitForAll",
                          "README.md:3: `kSum`: no source file has kSum"])

    def test_other_spans_and_blocks_of_code_are_not_checked(self):
        self.assertEqual(self.MissingOf("`./dev test`, `--spp`, `a + b`, `.gltf`, `build/x/y`, `light.NAME.R/G/B`, `word`\n"
                                        "```\n`rhi/queue.h`\n```\n"), [])

    def test_words_in_capitals_stand_for_anything(self):
        self.assertTrue(IsPath("rhi/NAME.h"))
        self.assertEqual(self.MissingOf("`rhi/NAME.h`"), [])
        self.assertEqual(self.MissingOf("`rhi/NAME_test.cpp`"), ["README.md:1: `rhi/NAME_test.cpp`: there is no such file"])

    def test_plain_words_are_english(self):
        for word in ("sum", "Linear", "srgb", "rgba32f"):
            self.assertFalse(IsSymbol(word), word)

    def test_an_allowed_name_is_taken_and_one_that_nobody_needs_is_named(self):
        self.assertEqual(self.MissingOf("`my_pass.cpp`", ["my_pass.cpp"]), [])
        self.assertEqual(self.MissingOf("nothing", ["my_pass.cpp"]), ["allowed_names: my_pass.cpp: no page needs it"])


if __name__ == "__main__":
    unittest.main()
