#!/usr/bin/env python3
"""What check_printed.py takes, refuses and writes."""

import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from check_printed import MarksWithoutBlock, Printed  # noqa: E402


def Page(text):
    return f"Text.\n<!-- printed by: raygraph one 'two words' -->\n```text\n{text}```\n\n```text\nother\n```\n"


class PrintedTest(unittest.TestCase):
    def test_a_block_becomes_what_its_command_prints(self):
        for text in ("one two words\n", "one\n", ""):
            self.assertEqual(Printed("echo", Page(text)), Page("one two words\n"))

    def test_each_block_has_its_own_command(self):
        self.assertEqual(Printed("echo", Page("") * 2), Page("one two words\n") * 2)

    def test_commands_run_in_the_folder(self):
        page = Page("").replace("one 'two words'", "check_printed.py")
        self.assertIn("check_printed.py\n", Printed("ls", page, Path(__file__).parent))

    def test_a_comment_without_its_block_is_counted(self):
        page = Page("")
        self.assertEqual(MarksWithoutBlock(page * 2), 0)
        for broken in (page.replace("```text", "```"), page.replace("raygraph one", "one"), page.replace("-->\n", "-->\n\n")):
            self.assertEqual(MarksWithoutBlock(page + broken), 1, broken)

    def test_a_command_that_fails_is_an_error(self):
        with self.assertRaises(Exception):
            Printed("false", Page(""))


if __name__ == "__main__":
    unittest.main()
