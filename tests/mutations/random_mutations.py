"""Random one-line mistakes: an operator, a constant, swapped arguments, a dropped term."""

import random
import re

from mutation import Mutation

# Where lines are drawn from: what ends up in a user's picture, file or frame. How the window draws its panels
# (editor/app) is judged by eye.
ROOTS = ("base", "rhi", "renderer", "passes", "shaders", "editor/viewport", "editor/session", "editor/cli")
SUFFIXES = (".cpp", ".h", ".glsl", ".rgen", ".rchit", ".rahit", ".rmiss", ".comp", ".vert", ".frag")

_SWAPS = [(" + ", " - "), (" - ", " + "), (" * ", " / "), (" / ", " * "), (" < ", " <= "), (" <= ", " < "), (" > ", " >= "),
          (" >= ", " > "), (" == ", " != "), (" != ", " == "), (" && ", " || "), (" || ", " && "), ("min(", "max("),
          ("max(", "min("), (" += ", " -= "), (" *= ", " /= "), ("true", "false"), ("false", "true"), (".x", ".y"), (".y", ".z"),
          (" & ", " | "), (" | ", " & "), ("sin(", "cos("), ("cos(", "sin("), ("++", "--"), ("-", ""), ("!", "")]
_NUMBER = re.compile(r"(?<![\w.])(\d+\.\d+f?|\d+u?)(?![\w.])")
_CALL = re.compile(r"\b\w+\(([\w.\[\]]+), ([\w.\[\]]+)\)")
_TERM = re.compile(r" [-+*] [\w.]+(?=[;,) ])")
# Words of lines whose change is not a mistake in what the program does.
_SKIP = re.compile(r"^\s*(//|\*|#|namespace|using |template|static_assert|\}|struct |class |case .*:$|public:|private:)|"
                   r'Error\(|Text\(|throw |Check|Assert|ASSERT|<<|operator|Help|printf|layout\(|RAYGRAPH_API|" \+|\+ "')


def _CodeOf(line):
    """The line without its comment, strings blanked out, so that places stay where they are."""
    line = re.sub(r'"(\\.|[^"\\])*"', lambda match: '"' + " " * (len(match.group()) - 2) + '"', line)
    return line.split("//")[0]


def _Number(text):
    suffix = text[-1] if text[-1] in "fu" else ""
    digits = text[:-1] if suffix else text
    if "." in digits:
        doubled = repr(2 * float(digits)) if float(digits) != 0 else "1.0"
        return (doubled if float(digits) != 1 else "0.5") + suffix
    return ("0" if digits == "1" else str(int(digits) + 1)) + suffix


def _Variants(line):
    """Every line that one mistake makes of this one."""
    code = _CodeOf(line)
    for old, new in _SWAPS:
        for match in re.finditer(re.escape(old), code):
            begin, end = match.span()
            if old[0].isalpha() and begin > 0 and (code[begin - 1].isalnum() or code[begin - 1] in "_:."):
                continue
            if old[-1].isalpha() and end < len(code) and (code[end].isalnum() or code[end] == "_"):
                continue
            if old == "-" and (code[begin - 1:begin] not in ("(", " ", ",") or code[end:end + 1] in (" ", ">", "-", "=", "")):
                continue
            if old == "!" and code[end:end + 1] in ("=", ""):
                continue
            yield line[:begin] + new + line[end:]
    for match in _NUMBER.finditer(code):
        yield line[:match.start()] + _Number(match.group()) + line[match.end():]
    for match in _CALL.finditer(code):
        if match.group(1) != match.group(2):
            swapped = f"{match.group(2)}, {match.group(1)}"
            yield line[:match.start(1)] + swapped + line[match.end(2):]
    for match in _TERM.finditer(code):
        yield line[:match.start()] + line[match.end():]


def RandomMutations(root, files, seed, known=frozenset()):
    """Yields mutations for ever, each once, the same ones for the same sources and seed. `known` ones are left out."""
    lines = []
    for name in sorted(files):
        if not name.startswith(tuple(r + "/" for r in ROOTS)) or not name.endswith(SUFFIXES):
            continue
        text = (root / name).read_text(encoding="utf-8")
        for line in text.splitlines():
            # A line that is there twice cannot be named by its text.
            if line.strip() and not _SKIP.search(line) and text.count(line + "\n") == 1 and text.count(line) == 1:
                lines.append((name, line))
    dice = random.Random(seed)
    seen = set()
    while len(seen) < 10 * len(lines):
        name, line = dice.choice(lines)
        variants = [new for new in _Variants(line) if new != line]
        if not variants:
            continue
        new = dice.choice(variants)
        key = (name, line, new)
        if key in seen or key in known:
            seen.add(key)
            continue
        seen.add(key)
        yield Mutation(f"{name}: {line.strip()}  ->  {new.strip()}", name, line, new)
