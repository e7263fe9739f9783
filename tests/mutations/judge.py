"""A copy of the source tree with a build of it: changes lines there, builds what they reach, and asks tests.

As a program, `judge.py SOURCE COPY` judges in COPY, which it sees at the path SOURCE: the build folder in it has the paths
that it was made with. Tasks come as lines of JSON on standard input, answers go to standard output. Needs a mount namespace
of its own (`unshare --mount`).
"""

import json
import os
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path


class Copy:
    """A source tree and its build. A program is named by its kind: `rhi` is raygraph_tests_rhi."""

    def __init__(self, source, log):
        self.source = Path(source)
        self.build = self.source / "build" / "release"  # where ./dev builds: a compiler cache finds the same paths
        self.log = open(log, "a", encoding="utf-8")

    def Write(self, name, data):
        path = self.source / name
        if not path.exists() or path.read_bytes() != data:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)

    def Run(self, command):
        """Whether the command succeeded; its output goes to the log."""
        result = subprocess.run(command, cwd=self.source, stdout=self.log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                check=False)
        self.log.flush()
        return result.returncode == 0

    def Builds(self, programs):
        return self.Run(["ninja", "-C", str(self.build), *[f"raygraph_tests_{program}" for program in programs]])

    def Inputs(self, program):
        """The source files that a test program is made from, headers and included shader text too."""
        if not hasattr(self, "_headers"):
            self._headers = defaultdict(set)
            output = None
            for line in self._Ninja("deps").splitlines():
                if line.startswith("    "):
                    self._headers[output].add(self._Path(line.strip()))
                elif ":" in line:
                    output = self._Path(line.split(":")[0])
            # Those of shaders are in files of their own: `output: input \\n input...`.
            for path in (self.build / "CMakeFiles" / "d").glob("*.d"):
                output, _, inputs = path.read_text(encoding="utf-8").replace("\\\n", " ").partition(":")
                self._headers[self._Path(output.strip())] |= {self._Path(name) for name in inputs.split()}
        found, added = set(), {self._Path(name) for name in self._Ninja("inputs", f"raygraph_tests_{program}").splitlines()}
        while added:  # an included header may be a shader that was made from others
            found |= added
            added = {header for path in added for header in self._headers.get(path, ())} - found
        prefix = str(self.source) + "/"
        return {path[len(prefix):] for path in found if path.startswith(prefix)}

    def _Path(self, name):
        return os.path.normpath(self.build / name)

    def _Ninja(self, tool, *arguments):
        return subprocess.run(["ninja", "-C", str(self.build), "-t", tool, *arguments], check=True, capture_output=True,
                              text=True).stdout

    def Command(self, program):
        return [str(self.build / "tests" / program / f"raygraph_tests_{program}")]

    def Tests(self, program):
        """Names of the program's tests, in the order in which they run."""
        output = subprocess.run([*self.Command(program), "--gtest_list_tests"], check=True, capture_output=True, text=True).stdout
        names, suite = [], ""
        for line in output.splitlines():
            text = line.split("#")[0].rstrip()
            if text.startswith("  "):
                names.append(suite + text.strip())
            elif text.endswith("."):
                suite = text
        return names

    def Failure(self, program, tests, limit, seconds=None):
        """The first of the tests that fails, in a process of its own too, or None. A crash is a failure of the test in
        which it comes, and so is being at work when the limit (seconds) is over. What each passed test takes is added
        to `seconds`."""
        tests = list(tests)
        while tests:
            failed = self._FirstFailure(program, tests, limit, seconds)
            if failed is None:
                return None
            if len(tests) == 1 or self._FirstFailure(program, [failed], limit, seconds):
                return failed
            # Only beside others, in one process: no verdict on the change. The rest are asked in another process.
            tests = tests[tests.index(failed) + 1:]
        return None

    def _FirstFailure(self, program, tests, limit, seconds):
        command = [*self.Command(program), "--gtest_fail_fast", "--gtest_color=no", "--gtest_brief=0", "--gtest_print_time=1",
                   "--gtest_filter=" + ":".join(tests)]
        try:
            result = subprocess.run(command, cwd=self.build, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                    stdin=subprocess.DEVNULL, check=False, timeout=limit)
            output, code = result.stdout.decode(errors="replace"), result.returncode
        except subprocess.TimeoutExpired as expired:
            output, code = (expired.stdout or b"").decode(errors="replace"), -1
        for name, time_ms in re.findall(r"^\[       OK \] (\S+?) \((\d+) ms\)", output, re.MULTILINE):
            if seconds is not None:
                seconds[name] = int(time_ms) / 1000
        failed = [name for name in re.findall(r"^\[  FAILED  \] ([\w./]+)", output, re.MULTILINE) if name in tests]
        if not failed and code != 0:
            started = [name for name in re.findall(r"^\[ RUN      \] (\S+)", output, re.MULTILINE) if name in tests]
            failed = started[-1:] or tests[:1]
        if failed:
            self.log.write(f"\n{' '.join(command[:1])}: {failed[0]} failed:\n{output[-4000:]}\n")
        return failed[0] if failed else None


def Judge(copy, name, text, asks):
    """Gives the file of that name this text and asks programs in turn, each as [program, tests, limit in seconds]. Returns
    whether they build, and the test that fails or None. The file is as before afterwards."""
    before = (copy.source / name).read_bytes()
    copy.Write(name, text.encode())
    try:
        for program, tests, limit in asks:
            if not copy.Builds([program]):
                return False, None
            killer = copy.Failure(program, tests, limit)
            if killer:
                return True, killer
        return True, None
    finally:
        copy.Write(name, before)


def Main(source, copied):
    subprocess.run(["mount", "--bind", copied, source], check=True)
    copy = Copy(source, copied + ".log")
    for line in sys.stdin:
        print(json.dumps(Judge(copy, *json.loads(line))), flush=True)


if __name__ == "__main__":
    Main(*sys.argv[1:])
