"""A mutation: one wrong line, and the tests that must notice it. Read from chosen.txt."""

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

    def Applied(self, root):
        """The text of the file in the source tree `root`, with the mutation."""
        return self.Apply((root / self.file).read_text(encoding="utf-8"))

    def Stanza(self):
        """Returns the stanza of a random mutation, for equivalent.txt."""
        return f"[{self.name}]\nfile: {self.file}\nold: {self.old}\nnew: {self.new}"


_KEYS = {"harm", "file", "old", "new", "after", "tests", "why"}


def _Stanzas(path):
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


def ReadMutations(path, required=("harm", "tests")):
    """The mutations of a list, which have names of their own. Each needs file, old, new and the `required` fields."""
    mutations = {}
    for name, fields in _Stanzas(path):
        empty = [key for key in ("file", "old", *required) if not fields.get(key, "").strip()]
        if empty or "new" not in fields or fields["old"] == fields["new"]:
            raise MutationError(f"{path}: [{name}] changes nothing or lacks {', '.join(empty) or 'new'}")
        if name in mutations:
            raise MutationError(f"{path}: two mutations are called [{name}]")
        mutations[name] = Mutation(name, fields["file"], fields["old"], fields["new"], fields.get("tests", "").split(),
                                   fields.get("after", ""))
    return list(mutations.values())
