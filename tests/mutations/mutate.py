#!/usr/bin/env python3
"""Puts wrong lines into a copy of the sources, one at a time, and sees whether a test notices.

A chosen mutation (in lists/) is killed if one of the tests that it names fails with it, and passes without
it. A random one is killed if any test fails. A change that does not compile counts as neither: chosen, it is an error;
random, another is drawn. Chosen mutations share a build where no program that must notice one of them is made from a file
that another one changes, so that each is judged alone.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path

from mutation import MutationError, ReadEquivalents, ReadMutations
from random_mutations import RandomMutations

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
# Quick ones first: a random mutation ends with the first test that fails. 'long' and 'threads' are not asked.
PROGRAMS = ["unit", "graph", "scene", "image", "rhi", "shading", "passes", "viewport", "views", "cli", "editor", "images"]
TIMEOUT_S = 600


class Copy:
    """A copy of the source tree and a build of it, kept between runs so that only what changed is built."""

    def __init__(self, folder):
        self.source = folder / "source"
        self.build = self.source / "build" / "release"  # where ./dev builds: a compiler cache finds the same paths
        self.files = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, check=True,
                                    capture_output=True, text=True).stdout.split("\n")
        self.files = [name for name in self.files if name and (ROOT / name).is_file()]
        for name in self.files:
            self.Write(name, (ROOT / name).read_bytes(), (ROOT / name).stat().st_mode)
        wanted = {self.source / name for name in self.files}
        for path in [p for p in self.source.rglob("*") if p.is_file() and self.build.parent not in p.parents]:
            if path not in wanted:
                path.unlink()
        self.log = open(folder / "build.log", "w", encoding="utf-8")

    def Write(self, name, data, mode=None):
        path = self.source / name
        if not path.exists() or path.read_bytes() != data:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        if mode is not None:
            path.chmod(mode)

    def Restore(self, name):
        self.Write(name, (ROOT / name).read_bytes())

    def Configure(self):
        options = []
        if shutil.which("ccache"):
            options.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
        if shutil.which("mold"):
            options += ["-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=mold", "-DCMAKE_SHARED_LINKER_FLAGS=-fuse-ld=mold"]
        self.Run(["cmake", "--preset", "release", *options])

    def Run(self, command):
        result = subprocess.run(command, cwd=self.source, stdout=self.log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                check=False)
        self.log.flush()
        if result.returncode != 0:
            raise MutationError(f"failed: {' '.join(command)} (see {self.log.name})")

    def Builds(self, programs):
        try:
            self.Run(["ninja", "-C", str(self.build), *[f"raygraph_tests_{program}" for program in programs]])
        except MutationError:
            return False
        return True

    def Program(self, name):
        return self.build / "tests" / name / f"raygraph_tests_{name}"

    def Inputs(self, program):
        """The source files that a test program is made from, headers and included shader text too."""
        if not hasattr(self, "_headers"):
            self._headers = defaultdict(set)
            output = None
            for line in self._Ninja("deps").splitlines():
                if line.startswith("    "):
                    self._headers[output].add(os.path.normpath(self.build / line.strip()))
                elif ":" in line:
                    output = line.split(":")[0]
        found = set()
        for name in self._Ninja("inputs", f"raygraph_tests_{program}").splitlines():
            found.add(os.path.normpath(self.build / name))
            found |= self._headers.get(name, set())
        prefix = str(self.source) + "/"
        return {path[len(prefix):] for path in found if path.startswith(prefix)}

    def _Ninja(self, tool, *arguments):
        return subprocess.run(["ninja", "-C", str(self.build), "-t", tool, *arguments], check=True, capture_output=True,
                              text=True).stdout

    def Tests(self, program):
        """Names of the program's tests."""
        output = subprocess.run([self.Program(program), "--gtest_list_tests"], check=True, capture_output=True, text=True).stdout
        names, suite = [], ""
        for line in output.splitlines():
            text = line.split("#")[0].rstrip()
            if text.startswith("  "):
                names.append(suite + text.strip())
            elif text.endswith("."):
                suite = text
        return names

    def FailureOf(self, program, tests=None):
        """The first test that fails, or None. A crash and a hang are failures of the test in which they come."""
        command = [self.Program(program), "--gtest_fail_fast", "--gtest_color=no", "--gtest_brief=0"]
        if tests is not None:
            command.append("--gtest_filter=" + ":".join(tests))
        try:
            result = subprocess.run(command, cwd=self.build, capture_output=True, stdin=subprocess.DEVNULL, check=False,
                                    timeout=TIMEOUT_S)
            output, code = result.stdout.decode(errors="replace"), result.returncode
        except subprocess.TimeoutExpired as expired:
            output, code = (expired.stdout or b"").decode(errors="replace"), -1
        failed = re.findall(r"^\[  FAILED  \] ([\w./]+)", output, re.MULTILINE)
        if failed:
            return failed[0]
        if code != 0:
            started = re.findall(r"^\[ RUN      \] ([\w./]+)", output, re.MULTILINE)
            return f"{started[-1] if started else program} (ended with {code})"
        return None


def Say(text):
    print(text, flush=True)


def NamedTests(mutation, tests):
    """{program: [tests]} that the mutation names."""
    named = {program: [test for test in names if mutation.Kills(test)] for program, names in tests.items()}
    named = {program: names for program, names in named.items() if names}
    if not named:
        raise MutationError(f"{mutation.name}: no test is called {' or '.join(mutation.tests)}")
    return named


def Groups(mutations, named, inputs):
    """Lists of mutations that may share a build: no program asked about one is made from the file of another."""
    groups = []
    for mutation in mutations:
        for group in groups:
            if all(mutation.file != other.file and
                   not any(mutation.file in inputs[program] for program in named[other.name]) and
                   not any(other.file in inputs[program] for program in named[mutation.name]) for other in group):
                group.append(mutation)
                break
        else:
            groups.append([mutation])
    return groups


def JudgeChosen(copy, mutations):
    """Returns the number of mutations that survived or could not be judged."""
    for mutation in mutations:
        mutation.Apply((ROOT / mutation.file).read_text(encoding="utf-8"))
    Say(f"{len(mutations)} mutations apply; building the sources as they are")
    if not copy.Builds(PROGRAMS):
        raise MutationError(f"the sources do not build as they are (see {copy.log.name})")
    tests = {program: copy.Tests(program) for program in PROGRAMS}
    inputs = {program: copy.Inputs(program) for program in PROGRAMS}
    named = {mutation.name: NamedTests(mutation, tests) for mutation in mutations}
    for program in PROGRAMS:
        wanted = sorted({test for by in named.values() for test in by.get(program, [])})
        failure = copy.FailureOf(program, wanted) if wanted else None
        if failure:
            raise MutationError(f"{failure} fails without any mutation")
    bad = 0
    groups = Groups(mutations, named, inputs)
    Say(f"{len(groups)} builds")
    for group in groups:
        for mutation in group:
            copy.Write(mutation.file, mutation.Apply((ROOT / mutation.file).read_text(encoding="utf-8")).encode())
        builds = copy.Builds(sorted({program for mutation in group for program in named[mutation.name]}))
        for mutation in group:
            if not builds:
                result = "DOES NOT COMPILE" if len(group) == 1 else "DOES NOT COMPILE, it or another of its group"
            else:
                killers = (copy.FailureOf(program, names) for program, names in named[mutation.name].items())
                killer = next((name for name in killers if name), None)
                result = f"killed by {killer}" if killer else "SURVIVED"
            bad += not result.startswith("killed")
            Say(f"{result:60} [{mutation.name}]")
        for mutation in group:
            copy.Restore(mutation.file)
    return bad


def JudgeRandom(copy, count, seed):
    """Returns the number of random mutations that survived."""
    known = ReadEquivalents(HERE / "lists" / "equivalent.txt")
    if not copy.Builds(PROGRAMS):
        raise MutationError(f"the sources do not build as they are (see {copy.log.name})")
    inputs = {program: copy.Inputs(program) for program in PROGRAMS}
    survivors, judged = [], 0
    for mutation in RandomMutations(ROOT, copy.files, seed, known):
        if judged == count:
            break
        programs = [program for program in PROGRAMS if mutation.file in inputs[program]]
        if not programs:
            continue
        copy.Write(mutation.file, mutation.Apply((ROOT / mutation.file).read_text(encoding="utf-8")).encode())
        compiles, killer = True, None
        for program in programs:
            compiles = copy.Builds([program])
            killer = copy.FailureOf(program) if compiles else None
            if killer or not compiles:
                break
        copy.Restore(mutation.file)
        if not compiles:
            continue
        judged += 1
        Say(f"{judged:4} {'killed by ' + killer if killer else 'SURVIVED':60} {mutation.name}")
        if not killer:
            survivors.append(mutation)
    for mutation in survivors:
        Say("\n" + mutation.Stanza())
    Say(f"\n{judged} random mutations of seed {seed}: {judged - len(survivors)} killed, {len(survivors)} survived")
    return len(survivors)


def Main():
    parser = argparse.ArgumentParser(prog="./dev mutate", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("names", nargs="*", help="judge chosen mutations whose name holds one of these (default: all)")
    parser.add_argument("--random", type=int, metavar="N", help="judge N random mutations instead")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="of the random ones (default: 1)")
    parser.add_argument("--list", action="store_true", help="print the chosen mutations and whether they apply")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "mutate", help="of the copy and its build")
    arguments = parser.parse_args()
    try:
        mutations = [m for path in sorted((HERE / "lists").glob("*.txt")) if path.name != "equivalent.txt" for m in ReadMutations(path)]
        mutations = [m for m in mutations if not arguments.names or any(name in m.name for name in arguments.names)]
        names = [m.name for m in mutations]
        for name in {n for n in names if names.count(n) > 1}:
            raise MutationError(f"two mutations are called [{name}]")
        if arguments.list:
            for m in mutations:
                m.Apply((ROOT / m.file).read_text(encoding="utf-8"))
                Say(f"{m.file:44} {m.name}")
            return 0
        started = time.monotonic()
        arguments.folder.mkdir(parents=True, exist_ok=True)
        copy = Copy(arguments.folder.resolve())
        copy.Configure()
        if arguments.random is not None:
            bad = JudgeRandom(copy, arguments.random, arguments.seed)
        else:
            bad = JudgeChosen(copy, mutations)
            Say(f"{len(mutations)} mutations, {bad} not noticed, in {time.monotonic() - started:.0f} s")
        return 1 if bad else 0
    except MutationError as error:
        print(f"mutate: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(Main())
