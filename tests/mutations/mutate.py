#!/usr/bin/env python3
"""Puts wrong lines into a copy of the sources, one at a time, and sees whether a test notices.

A chosen mutation (in chosen.txt) is killed if one of the tests that it names fails with it, and passes without it.
A random one is killed if any test fails. A change that does not compile counts as neither: chosen, it is an error;
random, another is drawn.
"""

import argparse
import fnmatch
import shutil
import subprocess
import sys
import time
from pathlib import Path

from judge import Copy
from judges import Judges
from mutation import MutationError, ReadMutations
from random_mutations import RandomMutations

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
# Quick ones first: a random mutation ends with the first test that fails. 'long' and 'threads' are not asked.
PROGRAMS = ["unit", "image", "scene", "shading", "rhi", "graph", "passes", "denoise", "realtime", "viewport", "views", "cli",
            "editor", "images"]
CHUNK = 12  # tests of one process, where several processes ask the sources as they are
MIN_LIMIT_S = 60
LIMIT_S = 600  # of tests of which nobody knows what they take


def Say(text):
    print(text, flush=True)


def PreparedCopy(folder):
    """The source tree of ROOT as it is, in folder/source, with a build folder that is kept between runs."""
    copy = Copy(folder / "source", folder / "build.log")
    files = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, check=True,
                           capture_output=True, text=True).stdout.split("\n")
    files = [name for name in files if name and (ROOT / name).is_file()]
    for name in files:
        copy.Write(name, (ROOT / name).read_bytes())
        (copy.source / name).chmod((ROOT / name).stat().st_mode)
    wanted = {copy.source / name for name in files}
    for path in [p for p in copy.source.rglob("*") if p.is_file() and copy.build.parent not in p.parents]:
        if path not in wanted:
            path.unlink()
    options = []
    if shutil.which("ccache"):
        options.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    if shutil.which("mold"):
        options += ["-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=mold", "-DCMAKE_SHARED_LINKER_FLAGS=-fuse-ld=mold"]
    if not copy.Run(["cmake", "--preset", "release", *options]) or not copy.Builds(PROGRAMS):
        raise MutationError(f"the sources do not build as they are (see {copy.log.name})")
    return copy, files


def TimingTests():
    """Patterns of tests that measure time: they say nothing where much else runs."""
    lines = (HERE.parent / "runner" / "timing_tests").read_text(encoding="utf-8").splitlines()
    return [line.split()[0] for line in lines if line.strip() and not line.startswith("#")]


def NamedTests(mutation, tests):
    """Of {program: tests} those that the mutation names, each once: one {program: tests} per pattern."""
    named, seen = [], set()
    for pattern in mutation.tests:
        found = {program: [name for name in names if fnmatch.fnmatchcase(name, pattern)] for program, names in tests.items()}
        if not any(found.values()):
            raise MutationError(f"{mutation.name}: no test is called {pattern}")
        named.append({program: [name for name in names if name not in seen] for program, names in found.items()})
        seen.update(name for names in found.values() for name in names)
    return named


class Suite:
    """The tests that a copy's programs have, and what they do without any mutation."""

    def __init__(self, copy, programs):
        timing = TimingTests()
        self.inputs = {program: copy.Inputs(program) for program in programs}
        self.tests = {program: [name for name in copy.Tests(program)
                                if not any(fnmatch.fnmatchcase(name, pattern) for pattern in timing)]
                      for program in programs}
        self.seconds = {}

    def Rehearse(self, copy, judges, wanted):
        """Runs {program: tests}, without mutation. Returns the tests that fail; they are asked no more."""
        size = CHUNK if judges.count > 1 else 10000
        chunks = [(program, tests[i:i + size]) for program, tests in wanted.items() for i in range(0, len(tests), size)]

        def FailuresOf(chunk):
            program, tests = chunk
            failures = []
            while tests:
                failed = copy.Failure(program, tests, LIMIT_S, self.seconds)
                if not failed:
                    break
                failures.append(failed)
                tests = tests[tests.index(failed) + 1:]
            return failures

        failures = {name for names in judges.Map(FailuresOf, chunks) for name in names}
        self.tests = {program: [name for name in tests if name not in failures] for program, tests in self.tests.items()}
        return sorted(failures)

    def Ask(self, tests):
        """What a judge is to ask, from {program: tests}: in the order of `tests`, with limits from the rehearsal, if any."""
        def Limit(names):
            return MIN_LIMIT_S + 5 * sum(self.seconds.get(name, 0) for name in names) if self.seconds else LIMIT_S

        return [[program, names, Limit(names)] for program, names in tests.items() if names]

    def AskNamed(self, mutation):
        """The same for the tests that a mutation names: those of the first pattern first."""
        return [ask for named in NamedTests(mutation, self.tests) for ask in self.Ask(named)]


def JudgeChosen(copy, judges, mutations):
    """Returns the number of mutations that survived or could not be judged."""
    suite = Suite(copy, PROGRAMS)
    asks = [suite.AskNamed(mutation) for mutation in mutations]
    bad, killed = 0, {}
    for name, builds, killer in judges.Judged((m.name, m.file, m.Applied(ROOT), ask) for m, ask in zip(mutations, asks)):
        if killer:
            killed[name] = killer
        bad += not killer
        result = f"killed by {killer}" if killer else "SURVIVED" if builds else "DOES NOT COMPILE"
        Say(f"{result:60} [{name}]")
    # A test that fails without the mutation too has shown nothing.
    if not copy.Builds(PROGRAMS):
        raise MutationError(f"the sources do not build as they are (see {copy.log.name})")
    killers = set(killed.values())
    failures = suite.Rehearse(copy, judges, {p: [t for t in suite.tests[p] if t in killers] for p in PROGRAMS})
    for name in [name for name, killer in killed.items() if killer in failures]:
        Say(f"NOT KILLED: {killed[name]} fails without it too [{name}]")
        bad += 1
    return bad


class Draw:
    """Draws random mutations until `count` of them have been judged. One that does not compile is drawn again."""

    def __init__(self, generator, suite, count):
        self.results = {}  # number of the draw: (mutation, killer), without those that do not compile
        self._generator = generator
        self._suite = suite
        self._count = count
        self._running = {}

    def Tasks(self):
        """For Judges.Judged."""
        number = 0
        while len(self.results) < self._count:
            if len(self.results) + len(self._running) >= self._count:
                yield None
                continue
            mutation = next(self._generator)
            tests = {program: tests for program, tests in self._suite.tests.items()
                     if mutation.file in self._suite.inputs[program]}
            if not tests:
                continue
            number += 1
            self._running[number] = mutation
            yield number, mutation.file, mutation.Applied(ROOT), self._suite.Ask(tests)

    def Take(self, number, builds, killer):
        """Takes the verdict on the task with that number. Returns whether it counts: it does not without a build."""
        mutation = self._running.pop(number)
        if builds:
            self.results[number] = (mutation, killer)
        return builds


def JudgeRandom(copy, judges, files, count, seed):
    """Returns the number of random mutations that survived."""
    known = {(m.file, m.old, m.new) for m in ReadMutations(HERE / "equivalent.txt", required=["why"])}
    suite = Suite(copy, PROGRAMS)
    for name in suite.Rehearse(copy, judges, suite.tests):
        Say(f"{name} fails without any mutation, and is not asked")
    draw = Draw(RandomMutations(ROOT, files, seed, known), suite, count)
    for number, builds, killer in judges.Judged(draw.Tasks()):
        if draw.Take(number, builds, killer):
            Say(f"{number:4} {'killed by ' + killer if killer else 'SURVIVED':60} {draw.results[number][0].name}")
    survivors = [mutation for _, (mutation, killer) in sorted(draw.results.items()) if not killer]
    for mutation in survivors:
        Say("\n" + mutation.Stanza())
    Say(f"\n{count} random mutations of seed {seed}: {count - len(survivors)} killed, {len(survivors)} survived")
    return len(survivors)


def Main():
    parser = argparse.ArgumentParser(prog="./dev mutate", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("names", nargs="*", help="judge chosen mutations whose name holds one of these (default: all)")
    parser.add_argument("--random", type=int, metavar="N", help="judge N random mutations instead")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="of the random ones (default: 1)")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="judge N at once, each in a copy of its own (default: 1)")
    parser.add_argument("--list", action="store_true", help="print the chosen mutations and whether they apply")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "mutate", help="of the copies and their builds")
    arguments = parser.parse_args()
    try:
        mutations = ReadMutations(HERE / "chosen.txt")
        mutations = [m for m in mutations if not arguments.names or any(name in m.name for name in arguments.names)]
        for m in mutations:
            m.Applied(ROOT)
            if arguments.list:
                Say(f"{m.file:44} {m.name}")
        if arguments.list:
            return 0
        started = time.monotonic()
        folder = arguments.folder.resolve()
        folder.mkdir(parents=True, exist_ok=True)
        copy, files = PreparedCopy(folder)
        with Judges(copy, max(arguments.jobs, 1), folder) as judges:
            if arguments.random is not None:
                bad = JudgeRandom(copy, judges, files, arguments.random, arguments.seed)
            else:
                bad = JudgeChosen(copy, judges, mutations)
                Say(f"{len(mutations)} mutations, {bad} not noticed, in {time.monotonic() - started:.0f} s")
        return 1 if bad else 0
    except MutationError as error:
        print(f"mutate: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(Main())
