#!/usr/bin/env python3
"""The parts of ./dev mutate that need no build: lists are read strictly, mutations apply once, random ones repeat."""

import re
import tempfile
import unittest
from pathlib import Path

from judge import Judge
from judges import Judges
from mutate import Draw, HERE, NamedTests, PROGRAMS, ROOT
from mutation import Mutation, MutationError, ReadMutations
from random_mutations import RandomMutations


def ListOf(text):
    with tempfile.NamedTemporaryFile("w", suffix=".txt", encoding="utf-8", delete=False) as file:
        file.write(text)
    return Path(file.name)


class MutationTest(unittest.TestCase):
    def test_applies_in_exactly_one_place(self):
        flip = Mutation("flip", "a.cpp", "x + y", "x - y")
        self.assertEqual(flip.Apply("z = x + y;"), "z = x - y;")
        for text in ("z = x * y;", "x + y; x + y"):
            with self.assertRaises(MutationError):
                flip.Apply(text)

    def test_after_picks_the_place_below(self):
        flip = Mutation("flip", "a.cpp", "x + y", "x - y", after="void B()")
        self.assertEqual(flip.Apply("void A() { x + y; } void B() { x + y; }"), "void A() { x + y; } void B() { x - y; }")
        with self.assertRaises(MutationError):
            flip.Apply("void A() { x + y; }")

    def test_names_select_tests_by_pattern(self):
        mutation = Mutation("m", "a.cpp", "x", "y", ["Other.*", "*.A"])
        self.assertEqual(NamedTests(mutation, {"unit": ["Suite.One", "Suite.A"], "rhi": ["Other.A"]}),
                         [{"unit": [], "rhi": ["Other.A"]}, {"unit": ["Suite.A"], "rhi": []}])
        with self.assertRaises(MutationError):
            NamedTests(mutation, {"unit": ["Suite.One", "Suite.A"]})

    def test_a_list_that_lacks_something_is_refused(self):
        whole = "[a]\nharm: h\nfile: f\nold: x\nnew: y\ntests: S.T\n"
        self.assertEqual(ReadMutations(ListOf(whole))[0].tests, ["S.T"])
        for broken in (whole.replace("harm: h\n", ""), whole.replace("S.T", ""), whole.replace("new: y", "new: x"),
                       whole + "old: z\n", whole + "stray\n", whole.replace("[a]\n", ""), whole + whole):
            with self.assertRaises(MutationError, msg=broken):
                ReadMutations(ListOf(broken))
        with self.assertRaises(MutationError):
            ReadMutations(ListOf(whole), required=["why"])


class FakeCopy:
    """Its one program fails if the file holds 'wrong', does not build if it holds 'broken'."""

    def __init__(self, source):
        self.source = source
        self.asked = []

    def Write(self, name, data):
        (self.source / name).write_bytes(data)

    def Builds(self, programs):
        return "broken" not in (self.source / "a.cpp").read_text()

    def Failure(self, program, tests, limit):
        self.asked.append(program)
        return tests[0] if program == "unit" and "wrong" in (self.source / "a.cpp").read_text() else None


class JudgeTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.copy = FakeCopy(Path(folder.name))
        self.copy.Write("a.cpp", b"right")

    def test_asks_until_one_fails_and_restores_the_file(self):
        asks = [["unit", ["S.T"], 1], ["rhi", ["R.T"], 1]]
        self.assertEqual(Judge(self.copy, "a.cpp", "wrong", asks), (True, "S.T"))
        self.assertEqual(Judge(self.copy, "a.cpp", "other", asks), (True, None))
        self.assertEqual(self.copy.asked, ["unit", "unit", "rhi"])
        self.assertEqual((self.copy.source / "a.cpp").read_text(), "right")

    def test_what_does_not_build_is_no_verdict(self):
        self.assertEqual(Judge(self.copy, "a.cpp", "broken", [["unit", ["S.T"], 1]]), (False, None))
        self.assertEqual((self.copy.source / "a.cpp").read_text(), "right")

    def test_a_random_mutation_that_does_not_compile_is_drawn_again(self):
        name = "tests/mutations/README.md"
        news = ["wrong", "broken", "other", "wrong again", "never drawn"]
        drawn = (Mutation(new, name, "# tests/mutations", new) for new in news)

        class Suite:
            tests = {"unit": ["S.T"]}
            inputs = {"unit": {name}}

            def Ask(self, tests):
                return [[program, names, 1] for program, names in tests.items()]

        draw = Draw(drawn, Suite(), 3)
        (self.copy.source / "tests/mutations").mkdir(parents=True)
        self.copy.Write(name, b"right")
        self.copy.Builds = lambda programs: "broken" not in (self.copy.source / name).read_text()
        self.copy.Failure = lambda program, tests, limit: "wrong" in (self.copy.source / name).read_text() and tests[0] or None
        with Judges(self.copy, 1, self.copy.source) as judges:
            for verdict in judges.Judged(draw.Tasks()):
                draw.Take(*verdict)
        self.assertEqual([(m.name, killer) for _, (m, killer) in sorted(draw.results.items())],
                         [("wrong", "S.T"), ("other", None), ("wrong again", "S.T")])


class RandomTest(unittest.TestCase):
    def First(self, seed, known=frozenset()):
        files = [str(path.relative_to(ROOT)) for path in (ROOT / "shaders").rglob("*.glsl")]
        generator = RandomMutations(ROOT, files, seed, known)
        return [next(generator) for _ in range(50)]

    def test_the_same_seed_gives_the_same_mutations_and_another_gives_others(self):
        self.assertEqual(self.First(1), self.First(1))
        self.assertNotEqual(self.First(1), self.First(2))

    def test_every_one_applies_and_none_is_known(self):
        drawn = self.First(1)
        for mutation in drawn:
            text = (ROOT / mutation.file).read_text(encoding="utf-8")
            self.assertNotEqual(mutation.Apply(text), text)
        known = {(m.file, m.old, m.new) for m in drawn[:25]}
        self.assertFalse(known & {(m.file, m.old, m.new) for m in self.First(1, known)})


def TestsInSources():
    """{program: names} of the tests that the sources of each program define. Of a test with parameters, the first."""
    found = {}
    for program in PROGRAMS:
        text = "\n".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "tests" / program).glob("*.cpp")))
        prefixes = {}
        for prefix, suite in re.findall(r"\bINSTANTIATE_TEST_SUITE_P\(\s*(\w+),\s*(\w+)", text):
            prefixes.setdefault(suite, []).append(prefix)
        names = found[program] = []
        for kind, suite, name in re.findall(r"^(TEST|TEST_F|TEST_P)\(\s*(\w+),\s*(\w+)\)", text, re.MULTILINE):
            names += ([f"{suite}.{name}"] if kind != "TEST_P" else
                      [f"{prefix}/{suite}.{name}/0" for prefix in prefixes.get(suite, [])])
    return found


class ListsTest(unittest.TestCase):
    def test_every_pattern_of_the_chosen_ones_names_a_test(self):
        tests = TestsInSources()
        self.assertTrue(all(tests.values()))
        for mutation in ReadMutations(HERE / "chosen.txt"):
            NamedTests(mutation, tests)
        for pattern in "Samplers/NoSuite.*", "Path.NoTest*":
            with self.assertRaises(MutationError):
                NamedTests(Mutation("m", "a.cpp", "x", "y", [pattern]), tests)

    def test_every_mutation_of_the_lists_applies_to_the_sources(self):
        chosen = ReadMutations(HERE / "chosen.txt")
        self.assertLessEqual(len(chosen), 80)
        for mutation in chosen + ReadMutations(HERE / "equivalent.txt", required=["why"]):
            mutation.Applied(ROOT)


if __name__ == "__main__":
    unittest.main()
