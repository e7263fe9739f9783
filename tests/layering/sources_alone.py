#!/usr/bin/env python3
"""Each source file of the libraries and programs compiles alone, as a release without asserts, without warnings.

Unity builds hide a missing include, and builds with asserts a variable that only an assert uses. Usage:
sources_alone.py ROOT BUILD_FOLDER COMPILER. Configures BUILD_FOLDER, writes no objects, prints what the compiler says, and ends
with 1 if a file does not compile.
"""

import json
import os
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path


def Checked(entry):
    """What the compiler says about the entry of compile_commands.json; empty if it accepts the file."""
    words = shlex.split(entry["command"])
    output = words.index("-o")
    result = subprocess.run([*words[:output], *words[output + 2:], "-fsyntax-only"], cwd=entry["directory"], check=False,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return result.stdout if result.returncode else ""


def Main(root, build, compiler):
    subprocess.run(["cmake", "-S", root, "-B", build, "-G", "Ninja", f"-DCMAKE_CXX_COMPILER={compiler}",
                    "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DCMAKE_BUILD_TYPE=Release", "-DRAYGRAPH_UNITY=OFF",
                    "-DRAYGRAPH_ASSERTS=OFF", "-DRAYGRAPH_BUILD_TESTS=OFF"], check=True, stdout=subprocess.DEVNULL)
    entries = json.loads((Path(build) / "compile_commands.json").read_text(encoding="utf-8"))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        said = [text for text in pool.map(Checked, entries) if text]
    print("\n".join([*said, f"{len(entries)} files, {len(said)} do not compile alone"]))
    return 1 if said or not entries else 0


if __name__ == "__main__":
    sys.exit(Main(*sys.argv[1:]))
