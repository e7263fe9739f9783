"""A mutation: one wrong line, and the tests that must notice it. Read from lists/."""

import fnmatch
from dataclasses import dataclass, field
from pathlib import Path


class MutationError(Exception):
    """A mutation that cannot be used as it stands; the text says which and why."""


@dataclass
class Mutation:
    name: str  # what is wrong, for a person
    file: str  # path from the root of the source tree
    old: str  # text within one line
    new: str  # what stands there instead; may be empty
    tests: list = field(default_factory=list)  # patterns of Suite.Test; empty: any test
    harm: str = ""  # to users
    after: str = ""  # text before `old` in the file, where `old` alone is not unique

    def Apply(self, text):
        """The file's text with the mutation. MutationError if it does not apply in exactly one place."""
        start = 0
        if self.after:
            if text.count(self.after) != 1:
                raise MutationError(f"{self.name}: {self.file}: 'after' is there {text.count(self.after)} times, not once")
            start = text.index(self.after) + len(self.after)
        elif text.count(self.old) != 1:
            raise MutationError(f"{self.name}: {self.file}: 'old' is there {text.count(self.old)} times, not once")
        place = text.find(self.old, start)
        if place < 0:
            raise MutationError(f"{self.name}: {self.file}: 'old' is not there below 'after'")
        return text[:place] + self.new + text[place + len(self.old):]

    def Kills(self, test):
        """Whether a failure of the test with that name (Suite.Test) counts."""
        return not self.tests or any(fnmatch.fnmatchcase(test, pattern) for pattern in self.tests)

    def Stanza(self):
        """As it would stand in a list."""
        lines = [f"[{self.name}]", f"file: {self.file}"]
        if self.after:
            lines.append(f"after: {self.after}")
        lines += [f"old: {self.old}", f"new: {self.new}"]
        if self.tests:
            lines.append("tests: " + " ".join(self.tests))
        return "\n".join(lines)


_KEYS = {"harm", "file", "old", "new", "after", "tests", "why"}


def ReadStanzas(path):
    """Yields (name, fields) of a list: stanzas of a [name] and `key: value` lines; # begins a comment line."""
    name, fields = None, {}
    for number, line in enumerate(Path(path).read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        if line.startswith("[") and line.endswith("]"):
            if name is not None:
                yield name, fields
            name, fields = line[1:-1], {}
            continue
        key, colon, value = line.partition(":")
        if name is None or not colon or key not in _KEYS:
            raise MutationError(f"{path}:{number}: neither [name] nor one of {', '.join(sorted(_KEYS))}: {line}")
        if key in fields:
            raise MutationError(f"{path}:{number}: a second '{key}' in [{name}]")
        fields[key] = value[1:] if value.startswith(" ") else value
    if name is not None:
        yield name, fields


def ReadMutations(path):
    """The chosen mutations of one list. Each needs harm, file, old, new and tests."""
    mutations = []
    for name, fields in ReadStanzas(path):
        missing = {"harm", "file", "old", "new", "tests"} - fields.keys()
        if missing:
            raise MutationError(f"{path}: [{name}] lacks {', '.join(sorted(missing))}")
        if not fields["old"] or not fields["tests"].split() or fields["old"] == fields["new"]:
            raise MutationError(f"{path}: [{name}] changes nothing or names no test")
        mutations.append(
            Mutation(name, fields["file"], fields["old"], fields["new"], fields["tests"].split(), fields["harm"],
                     fields.get("after", "")))
    return mutations


def ReadEquivalents(path):
    """(file, old, new) of random mutations that change nothing a user or a test could see; each says why."""
    known = set()
    for name, fields in ReadStanzas(path):
        if not {"file", "old", "new", "why"} <= fields.keys() or not fields["why"]:
            raise MutationError(f"{path}: [{name}] lacks file, old, new or why")
        known.add((fields["file"], fields["old"], fields["new"]))
    return known
