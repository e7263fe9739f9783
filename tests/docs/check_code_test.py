#!/usr/bin/env python3
"""What check_code.py takes and what it refuses."""

import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from check_code import Wrong  # noqa: E402

SOURCE = "int main() {\n    const int a = 1;\n    if (a)\n        return 2;\n}\n"


def WrongOf(block, mark="<!-- from: main.cpp -->\n"):
    return list(Wrong("page.md", f"Text.\n{mark}```cpp\n{block}```\n", {"main.cpp": SOURCE}.get))


class CodeTest(unittest.TestCase):
    def test_lines_of_the_file_are_taken_at_any_indentation(self):
        for block in (SOURCE, "const int a = 1;\nif (a)\n    return 2;\n", "        return 2;\n}\n"):
            self.assertEqual(WrongOf(block), [])

    def test_other_lines_are_named(self):
        for block in ("const int a = 2;\n", "const int a = 1;\nreturn 2;\n", "if (a)\nreturn 2;\n"):
            self.assertEqual(WrongOf(block), ["page.md:2: main.cpp does not have these lines"])

    def test_code_without_a_file_is_named(self):
        self.assertEqual(WrongOf("return 2;\n", ""), ["page.md:2: code without `<!-- from: FILE -->`"])
        self.assertEqual(WrongOf("return 2;\n", "<!-- from: other.cpp -->\n"), ["page.md:2: there is no other.cpp"])


if __name__ == "__main__":
    unittest.main()
