#!/usr/bin/env python3
"""The code of the pages is compiled or run: it stands in a source file, line by line.

Usage: check_code.py [ROOT]. Before each fence of C, C++, GLSL, Python or Rust in a page of Markdown a comment names the file, which the suite
builds:

    <!-- from: examples/1_pass/sharpen.cpp -->
    ```cpp

The lines of the block follow each other in that file; their common indentation does not count. Prints each block that has no
file, or that its file does not have, and ends with 1.
"""

import re
import subprocess
import sys
import textwrap
from pathlib import Path

BLOCK = re.compile(r"(?:<!-- from: (\S+) -->\n)?```(cpp|c|glsl|python|rust)\n(.*?)```", re.DOTALL)


def Lines(text):
    return [line.rstrip() for line in textwrap.dedent(text).splitlines()]


def IsIn(block, text):
    """The lines of the block, each indented by as much more, follow each other in the text."""
    wanted, lines = Lines(block), text.splitlines()
    return any(Lines("\n".join(lines[i:i + len(wanted)])) == wanted for i in range(len(lines) - len(wanted) + 1))


def Wrong(page, text, read):
    for match in BLOCK.finditer(text):
        place = f"{page}:{text.count(chr(10), 0, match.start()) + 1}"
        file = match[1]
        if not file:
            yield f"{place}: code without `<!-- from: FILE -->`"
        elif (source := read(file)) is None:
            yield f"{place}: there is no {file}"
        elif not IsIn(match[3], source):
            yield f"{place}: {file} does not have these lines"


def Main(root):
    names = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.md"], cwd=root, check=True,
                           capture_output=True, text=True).stdout.splitlines()
    pages = {name: (root / name).read_text(encoding="utf-8") for name in names if (root / name).is_file()}
    wrong = [line for page, text in pages.items()
             for line in Wrong(page, text, lambda file: (root / file).read_text(encoding="utf-8") if (root / file).is_file() else None)]
    count = sum(len(BLOCK.findall(text)) for text in pages.values())
    print("\n".join([*wrong, f"{count} blocks checked, {len(wrong)} wrong"]))
    return 1 if wrong or not count else 0


if __name__ == "__main__":
    sys.exit(Main(Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2]).resolve()))
