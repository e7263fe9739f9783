#!/usr/bin/env python3
"""abi.py HEADER LIBRARY COMPILER RELEASE [--write]: compares the binary interface of raygraph.h with that of the last
release, which the file RELEASE lists: functions with their types, sizes of structs and offsets of their fields, and
constants. What was added is printed; what is gone or has changed is an error. Functions of the header that the library
does not export, and exported ones that the header lacks, are errors, too. --write stores the present interface."""
import re
import subprocess
import sys
import tempfile
from pathlib import Path


def without_comments(text):
    return re.sub(r"//[^\n]*", "", text)


def one_line(text):
    return re.sub(r"\s+", " ", text).strip()


def name_in(declaration):
    """Returns what a declaration declares, which may be an array or a pointer to a function."""
    pointer = re.search(r"\(\*(\w+)\)\(", declaration)
    return (pointer or re.search(r"(\w+)(\[\w+\])?$", declaration)).group(1)


def structs_of(header):
    """Returns the declarations of fields by name, for each struct by its name."""
    structs = {}
    for body, name in re.findall(r"typedef struct \w+ \{(.*?)\} (\w+);", header, re.S):
        structs[name] = {name_in(field): field for field in filter(None, map(one_line, body.split(";")))}
    declared = header.count("{") - len(re.findall(r"enum \{", header)) - len(re.findall(r'extern "C" \{', header))
    if declared != len(structs):
        raise SystemExit(f"abi.py: {declared} structs are declared, and {len(structs)} were understood")
    return structs


def functions_of(header):
    found = re.findall(r"^RG_API ([^;]*?)\b(rg_\w+)\(([^;]*)\);", header, re.M | re.S)
    if len(found) != header.count("\nRG_API "):
        raise SystemExit("abi.py: not every function with RG_API was understood")
    # Names of parameters are no part of the interface.
    functions = {}
    for result, name, parameters in found:
        types = []
        for parameter in one_line(parameters).split(","):
            types.append(re.sub(r"(?<=[ *])\w+(\[\d+\])?$", r"\1", parameter.strip()).strip())
        functions[name] = f"{one_line(result)} ({', '.join(types)})"
    return functions


def constants_of(header):
    names = []
    for body in re.findall(r"enum \{(.*?)\}", header, re.S):
        names += [entry.split("=")[0].strip() for entry in body.split(",") if entry.strip()]
    return names


def interface_of(path, compiler):
    header = without_comments(Path(path).read_text())
    lines = [f"function {name} {signature}" for name, signature in functions_of(header).items()]
    types = map(one_line, re.findall(r"^typedef (?!struct)([^;{]*);", header, re.M))
    lines += [f"type {name_in(text)}: {text}" for text in types]
    program = ["#include <raygraph.h>", "#include <stdio.h>", "int main(void) {"]
    for name, fields in structs_of(header).items():
        program.append(f'printf("struct {name} %zu\\n", sizeof({name}));')
        for field, declaration in fields.items():
            program.append(f'printf("field {name}.{field} at %zu, %zu bytes: {declaration}\\n", '
                           f"offsetof({name}, {field}), sizeof((({name}*)0)->{field}));")
    for name in constants_of(header):
        program.append(f'printf("constant {name} %lld\\n", (long long){name});')
    program.append("}")
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "sizes.c"
        source.write_text("\n".join(program))
        subprocess.run([compiler, "-std=c11", f"-I{Path(path).parent}", source, "-o", source.with_suffix("")],
                       check=True)
        printed = subprocess.run([source.with_suffix("")], check=True, capture_output=True, text=True)
    return sorted(lines + printed.stdout.splitlines())


def exported_by(library):
    listed = subprocess.run(["nm", "-D", "--defined-only", library], check=True, capture_output=True, text=True)
    return {line.split()[-1] for line in listed.stdout.splitlines() if line.split()[-1].startswith("rg_")}


def key(line):
    """What a line is about: its first two words."""
    return " ".join(line.split()[:2])


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--write"]
    if len(arguments) != 4:
        raise SystemExit(__doc__)
    header, library, compiler, release = arguments
    now = interface_of(header, compiler)
    declared, exported = set(functions_of(without_comments(Path(header).read_text()))), exported_by(library)
    errors = [f"{name} is declared, and {library} does not export it" for name in sorted(declared - exported)]
    errors += [f"{name} is exported, and not declared" for name in sorted(exported - declared)]
    if "--write" in sys.argv:
        Path(release).write_text("\n".join(now) + "\n")
    if not Path(release).exists():
        raise SystemExit(f"{release} is missing: write it for this release (c/README.md)")
    before = Path(release).read_text().splitlines()
    known = {key(line): line for line in now}
    for line in before:
        if key(line) not in known:
            errors.append(f"gone: {line}")
        elif key(line).split()[0] == "struct":  # it may have grown
            if int(known[key(line)].split()[2]) < int(line.split()[2]):
                errors.append(f"smaller: {line}, now {known[key(line)]}")
            elif known[key(line)] != line and f"field {line.split()[1]}.struct_size" not in map(
                    lambda each: each.split(" at ")[0], before):
                errors.append(f"it has no struct_size, and has grown: {line}, now {known[key(line)]}")
        elif known[key(line)] != line:
            errors.append(f"changed: {line}\n    now: {known[key(line)]}")
    old = set(map(key, before))
    for line in now:
        if key(line) not in old:
            print(f"new: {line}")
    print("\n".join(errors) if errors else f"{len(before)} entries of {Path(release).name} are as they were")
    sys.exit(1 if errors else 0)


if __name__ == "__main__":
    main()
