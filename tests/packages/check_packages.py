#!/usr/bin/env python3
"""Makes the Debian packages of a build, unpacks them side by side, and uses what is there.

Usage: check_packages.py BUILD FOLDER PYTHON. Prints a line for each thing that is wrong and ends with 1.
"""

import collections
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

BUILD, FOLDER, PYTHON = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
SOURCE = Path(__file__).resolve().parents[2]
wrong = []


def Run(*command, **options):
    """The output of a command; one that fails is reported with it."""
    result = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                            errors="replace", **options)
    if result.returncode != 0:
        wrong.append(f"{' '.join(map(str, command))} ended with {result.returncode}:\n{result.stdout}")
    return result.stdout


def Expect(condition, text):
    if not condition:
        wrong.append(text)


# Without compression: the packages are read once, here.
shutil.rmtree(FOLDER, ignore_errors=True)
FOLDER.mkdir(parents=True)
output = Run("cpack", "--config", BUILD / "CPackConfig.cmake", "-B", FOLDER / "packages",
             "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=none")
packages = {path.name.split("_")[0]: path for path in sorted((FOLDER / "packages").glob("*.deb"))}
if wrong or not packages:
    sys.exit("\n".join(wrong) or output)

root = FOLDER / "root"
owners = collections.defaultdict(list)
control = {}
for name, path in packages.items():
    Run("dpkg-deb", "-x", path, root)
    for line in Run("dpkg-deb", "-c", path).splitlines():
        mode, owner, _, _, _, file = line.split(maxsplit=5)
        if not mode.startswith("d"):
            owners[file.split(" -> ")[0]].append(name)
        Expect(owner == "root/root" and not re.match(r"..{4}w|.{8}w", mode[:9] if mode[0] != "l" else ""),
               f"{name}: {file} is {mode} of {owner}")
    control[name] = dict(line.split(": ", 1) for line in Run("dpkg-deb", "-f", path).splitlines() if re.match(r"\w+[-\w]*: ", line))
    for paper in ("copyright", "changelog.Debian.gz"):
        Expect((root / f"usr/share/doc/{name}/{paper}").is_file(), f"{name} has no {paper}")
for file, names in owners.items():
    Expect(len(names) == 1, f"{file} is in {' and '.join(names)}")

# Which file belongs where.
version = control["raygraph"]["Version"]
soname = re.search(r"^(\d+\.\d+)", version)[1]
runtime = f"libraygraph{soname}"
place = {
    "usr/bin/raygraph": "raygraph",
    "usr/share/man/man1/raygraph.1": "raygraph",
    "usr/share/bash-completion/completions/raygraph": "raygraph",
    "usr/share/raygraph/scenes/cornell.gltf": "raygraph",
    "usr/share/applications/raygraph.desktop": "raygraph",
    "usr/bin/raygraph-mpi": "raygraph-mpi",
    f"libraygraph.so.{soname}": runtime,
    "libraygraph.so": "libraygraph-dev",
    "raygraphConfig.cmake": "libraygraph-dev",
    "raygraph.pc": "libraygraph-dev",
    "usr/include/raygraph/rhi/device.h": "libraygraph-dev",
    "usr/include/raygraph.h": "libraygraph-dev",
    "raygraph/__init__.py": "python3-raygraph",
    "usr/share/doc/raygraph/docs/python.md": "raygraph-doc",
}
for end, package in place.items():
    found = [names for file, names in owners.items() if re.search(rf"(/|^){re.escape(end)}(\.gz)?$", file)]
    Expect(package not in packages or found == [[package]], f"{end} is in {found}, not in {package}")
for name, fields in control.items():
    for field in ("Maintainer", "Section", "Description"):
        Expect(field in fields, f"{name} has no {field}")
    ours = [need for need in fields.get("Depends", "").split(", ") if need.startswith("libraygraph")]
    Expect(all(need == f"{runtime} (= {version})" for need in ours), f"{name} depends on {ours}")
    Expect(bool(ours) == (name in ("libraygraph-dev", "python3-raygraph")), f"{name} depends on {ours}")
    if name in ("raygraph", "raygraph-mpi", runtime):
        Expect("libvulkan1" in fields["Depends"].split(", ") and "libc6 (" in fields["Depends"],
               f"{name} depends on {fields['Depends']}")

# Nothing names the tree or the build, each library is found, and its license is told.
libraries = [path.parent for path in root.rglob("libraygraph.so.*")][:1]
environment = os.environ | {"LD_LIBRARY_PATH": ":".join(map(str, libraries)), "LC_ALL": "C"}
licenses = (SOURCE / "THIRD_PARTY.md").read_text()
for path in sorted(root.rglob("*")):
    if path.is_symlink():
        Expect(path.resolve().is_file() and FOLDER in path.resolve().parents, f"{path} points to {os.readlink(path)}")
    if path.is_symlink() or not path.is_file():
        continue
    content = path.read_bytes()
    if not content.startswith(b"\x7fELF"):
        for folder in (BUILD, SOURCE):
            Expect(f"{folder}/".encode() not in content, f"{path} names {folder}")
        continue
    dynamic = Run("readelf", "-dS", path)
    Expect(".symtab" not in dynamic and ".debug" not in dynamic, f"{path} is not stripped")
    for folders in re.findall(r"R(?:UN)?PATH.*\[(.*)\]", dynamic):
        Expect(all(folder.startswith("$ORIGIN") for folder in folders.split(":")), f"{path} looks for libraries in {folders}")
    Expect("not found" not in (found := Run("ldd", path, env=environment)), f"{path} lacks libraries:\n{found}")
    for library in re.findall(r"NEEDED.*\[(lib[A-Za-z_0-9]+?)(?:-[\d_.]+)?\.so", dynamic):
        Expect(library == "libraygraph" or re.search(rf"\b{library}\b", licenses), f"THIRD_PARTY.md does not list {library} of {path}")

program = root / "usr/bin/raygraph"
scene = root / "usr/share/raygraph/scenes/cornell.gltf"
Expect(Run(program, "--version").strip() == f"raygraph {version.split('-')[0]}", "the program has another version")
quick = ("--spp", 1, "--size", "16x16", "--quiet")
Run(program, "render", scene, "-o", FOLDER / "program.exr", *quick)
if "raygraph-mpi" in packages:
    Run("mpirun", "--allow-run-as-root", "--oversubscribe", "-n", 1, root / "usr/bin/raygraph-mpi", "render", scene,
        "-o", FOLDER / "mpi.exr", *quick)
    Run("cmp", FOLDER / "program.exr", FOLDER / "mpi.exr")
if "python3-raygraph" in packages:
    # The script of the README, in a folder with nothing but the installed scene.
    empty = FOLDER / "empty"
    empty.mkdir()
    (empty / "scenes").symlink_to(scene.parent)
    module = next(root.rglob("raygraph/__init__.py")).parents[1]
    script = (SOURCE / "python/examples/first.py").read_text()
    Run(PYTHON, "-B", "-c", script, cwd=empty, env=environment | {"PYTHONPATH": str(module)})
    Expect((empty / "cornell.png").is_file(), "the script wrote no picture")
if "libraygraph-dev" in packages:
    Run("cmake", "-S", SOURCE / "tests/embed/scene_reader", "-B", FOLDER / "host", "-G", "Ninja",
        "-D", f"CMAKE_PREFIX_PATH={root}/usr", "-D", "CMAKE_BUILD_TYPE=Debug")
    Run("cmake", "--build", FOLDER / "host")
    Run(FOLDER / "host/scene_reader", scene, env=environment)

desktop = root / "usr/share/applications/raygraph.desktop"
if desktop.exists():
    entry = dict(re.findall(r"^(\w+)=(.*)$", desktop.read_text(), re.MULTILINE))
    command, *words = entry["Exec"].split()
    Expect((root / "usr/bin" / command).is_file() and words[-1] == "%f", f"the desktop runs {entry['Exec']}")
    Expect(f"raygraph {words[0]} " in Run(program, words[0], "--help"), f"the program has no command {words[0]}")
    Expect(list(root.glob(f"usr/share/icons/hicolor/*/apps/{entry['Icon']}.*")), f"there is no icon {entry['Icon']}")
    types = Path("/usr/share/mime/globs2")
    for kind in filter(None, entry["MimeType"].split(";")):
        Expect(not types.exists() or f":{kind}:" in types.read_text(), f"{kind} is no MIME type of shared-mime-info")
checkers = {
    "desktop-file-validate": [desktop],
    "appstreamcli": ["validate-tree", "--no-net", root],
}
for checker, words in checkers.items():
    if not shutil.which(checker):
        print(f"not run: {checker} is not installed")
    elif desktop.exists():
        print(checker, Run(checker, *words))

if wrong:
    sys.exit("\n".join(wrong))
shutil.rmtree(FOLDER)
print(f"{len(packages)} packages with {len(owners)} files are right: {', '.join(packages)}")
