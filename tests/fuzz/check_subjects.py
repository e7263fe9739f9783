#!/usr/bin/env python3
"""check_subjects.py BUILD SOURCES ARCHIVES: whether the sources that libFuzzer's build compiles are enough.

That build is rarely made, and lists its sources by hand. Here their objects are taken from an ordinary BUILD; each symbol
of Raygraph that they need must be in one of them or in one of ARCHIVES. Both lists are separated by semicolons.
"""

import subprocess
import sys
from pathlib import Path


def Symbols(files, kind):
    output = subprocess.run(["nm", "--quiet", "--format=posix", kind, *files], check=True, capture_output=True, text=True).stdout
    return {line.split()[0] for line in output.splitlines() if "8raygraph" in line.split(" ")[0]}


def ObjectOf(build, source):
    found = sorted((build / source.parent / "CMakeFiles").glob(f"*.dir/{source.name}.o"))
    if not found:
        sys.exit(f"{source}: there is no object of it in {build}")
    return str(found[0])


def Main():
    build = Path(sys.argv[1])
    objects = [ObjectOf(build, Path(source)) for source in sys.argv[2].split(";")]
    missing = Symbols(objects, "--undefined-only") - Symbols(objects + sys.argv[3].split(";"), "--defined-only")
    if missing:
        names = subprocess.run(["c++filt", *sorted(missing)], check=True, capture_output=True, text=True).stdout
        sys.exit("tests/fuzz/CMakeLists.txt lacks the sources that define:\n" + names)


Main()
