#!/usr/bin/env python3
"""Every file and symbol that the pages of a source tree name is there.

Usage: check_names.py [ROOT]. Of the code spans (`...`) of all pages of Markdown that git knows, these are checked:

- a path (with a slash, or the name of a file with a known suffix): it is a path of the tree or the end of one, with its
  suffix or without. `*` and `{a,b}` stand for what they do in a shell, words in CAPITALS for
  anything. What a build writes (build/, out/) is not looked for.
- a symbol of the code (`rhi::Device`, `Restore`, `kPlanes`, `m_scene`, `GL_EXT_x`, with or without arguments): each of
  its words is a word of some source file.

Other spans (commands, options, values, formulas) are not checked. What a page names rightly and no source has, such as
a file that its reader is to write, is listed in allowed_names beside this file; a line there that no page needs any more
is an error too. Prints what is missing and ends with 1.
"""

import fnmatch
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
SUFFIXES = {"cpp", "h", "glsl", "comp", "vert", "frag", "rgen", "rchit", "rmiss", "rahit", "py", "sh", "md", "txt", "cmake", "json", "gltf"}
SYMBOL = re.compile(r"^~?[A-Za-z_][A-Za-z0-9_]*(?:(?:::|\.|->)~?[A-Za-z_][A-Za-z0-9_]*)*(?:\(.*\)|\{.*\}|<.*>)?$")
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def Files(root):
    output = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=root, check=True,
                            capture_output=True, text=True).stdout
    return [name for name in output.splitlines() if (root / name).is_file()]


def Spans(text):
    """(line number, span) of a page's code spans; blocks of code are left out."""
    isInBlock = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            isInBlock = not isInBlock
        elif not isInBlock:
            for span in re.findall(r"`([^`]+)`", line):
                yield number, span


def Alternatives(pattern):
    """a{b,c}d as abd and acd."""
    match = re.search(r"\{([^{}]*,[^{}]*)\}", pattern)
    if not match:
        return [pattern]
    return [name for part in match[1].split(",") for name in Alternatives(pattern[:match.start()] + part + pattern[match.end():])]


def IsPath(span):
    if not re.fullmatch(r"[\w*{}][\w.*{},/+-]*", span) or span.startswith(("build/", "out/")) or re.search(r"\.[RXYZ](/|$)", span):
        return False
    return "/" in span or "." in span and span.rsplit(".", 1)[-1] in SUFFIXES


def IsSymbol(span):
    """Words with an inner capital or an underscore, a scope, or arguments; plain words are English."""
    return bool(SYMBOL.match(span)) and bool(re.search(r"::|[a-z0-9][A-Z]|_|^[A-Z][a-z]+\(|[a-z]\($", span))


class Tree:
    def __init__(self, root):
        files = Files(root)
        self.paths = set(files) | {str(parent) for name in files for parent in Path(name).parents}
        self.pages = [name for name in files if name.endswith(".md")]
        self.words = set()
        for name in files:
            if not name.endswith(".md") and not name.startswith("tests/docs/"):  # these name what is nowhere
                self.words.update(WORD.findall((root / name).read_text(encoding="utf-8", errors="replace")))

    def HasPath(self, span):
        patterns = [re.sub(r"(?<![a-z])[A-Z]{2,}(?![a-z])", "*", name).rstrip("/") for name in Alternatives(span)]
        return all(any(fnmatch.fnmatchcase(f"/{path}", f"*/{pattern}") or fnmatch.fnmatchcase(f"/{path}", f"*/{pattern}.*")
                       for path in self.paths) for pattern in patterns)

    def MissingWords(self, span):
        return [word for word in WORD.findall(re.split(r"[({<]", span)[0]) if word not in self.words]


def Missing(root, allowed):
    """What to print about the tree, and how many names were checked."""
    tree = Tree(root)
    lines, count, unneeded = [], 0, set(allowed)
    for page in tree.pages:
        for number, span in Spans((root / page).read_text(encoding="utf-8")):
            wrong = None
            if IsPath(span):
                count += 1
                wrong = None if tree.HasPath(span) else "there is no such file"
            elif IsSymbol(span):
                count += 1
                words = tree.MissingWords(span)
                wrong = f"no source file has {' or '.join(words)}" if words else None
            if wrong and span in allowed:
                unneeded.discard(span)
            elif wrong:
                lines.append(f"{page}:{number}: `{span}`: {wrong}")
    return lines + [f"allowed_names: {span}: no page needs it" for span in sorted(unneeded)], count


def Main(root):
    allowed = {line.split("#")[0].strip() for line in (HERE / "allowed_names").read_text(encoding="utf-8").splitlines()} - {""}
    missing, count = Missing(Path(root).resolve(), allowed)
    print("\n".join([*missing, f"{count} names checked, {len(missing)} wrong"]))
    return 1 if missing or not count else 0


if __name__ == "__main__":
    sys.exit(Main(sys.argv[1] if len(sys.argv) > 1 else HERE.parents[1]))
