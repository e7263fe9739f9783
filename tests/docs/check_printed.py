#!/usr/bin/env python3
"""The texts that pages show as the program's are what it prints.

Usage: check_printed.py PROGRAM [ROOT] [--write]. A comment before a block of text names the command:

    <!-- printed by: raygraph edit --keys -->
    ```text

Prints each page with a block that differs from the output of its command, or with such a comment that no block follows, and
ends with 1; with --write it replaces the differing blocks instead.
"""

import re
import shlex
import subprocess
import sys
from pathlib import Path

MARK = "printed by:"
BLOCK = re.compile(r"(<!-- printed by: raygraph ([^\n]*) -->\n```text\n)(.*?)(?=^```$)", re.DOTALL | re.MULTILINE)


def Printed(program, text, folder=None):
    """The text with the present output of each command, which runs in `folder`."""
    def With(block):
        command = [program, *shlex.split(block[2])]
        return block[1] + subprocess.run(command, check=True, capture_output=True, text=True,
                                         cwd=folder).stdout.rstrip("\n") + "\n"
    return BLOCK.sub(With, text)


def MarksWithoutBlock(text):
    return text.count(MARK) - len(BLOCK.findall(text))


def Main(program, root, isWriting):
    names = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.md"], cwd=root, check=True,
                           capture_output=True, text=True).stdout.splitlines()
    count, stale = 0, []
    for name in names:
        page = root / name
        text = page.read_text(encoding="utf-8") if page.is_file() else ""
        count += len(BLOCK.findall(text))
        if MarksWithoutBlock(text):
            stale.append(f"{name}: {MarksWithoutBlock(text)} times '{MARK}' without a command and a block of text below it")
        printed = Printed(program, text, root)
        if printed != text and isWriting:
            page.write_text(printed, encoding="utf-8")
        elif printed != text:
            stale.append(f"{name}: not what the program prints: check_printed.py {program} --write")
    print("\n".join([*stale, f"{count} blocks compared, {len(stale)} pages are stale"]))
    return 1 if stale or not count else 0


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word != "--write"]
    if not words:
        sys.exit(__doc__)
    sys.exit(Main(Path(words[0]).resolve(), Path(words[1] if len(words) > 1 else Path(__file__).parents[2]).resolve(), "--write" in sys.argv))
