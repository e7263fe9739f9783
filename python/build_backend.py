"""The PEP 517 backend that pyproject.toml names: makes a wheel of what CMake has built and installs."""
import base64
import hashlib
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

TREE = Path(__file__).resolve().parents[1]


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Builds in build/release, or in the folder that `--config-settings build=FOLDER` names."""
    build = Path((config_settings or {}).get("build", TREE / "build/release"))
    if not (build / "CMakeCache.txt").exists():
        _Cmake("-S", TREE, "-B", build, "-G", "Ninja", "-D", "CMAKE_BUILD_TYPE=Release", "-D", "RAYGRAPH_PACKAGE_SHARED=ON",
               "-D", "RAYGRAPH_BUILD_TESTS=OFF", "-D", f"RAYGRAPH_PYTHON={sys.executable}")
    _Cmake("--build", build, "--target", "raygraph_python")
    with tempfile.TemporaryDirectory() as prefix:
        for component in ("python", "runtime"):
            _Cmake("--install", build, "--prefix", prefix, "--strip", "--component", f"raygraph_{component}")
        package = next(Path(prefix).rglob("raygraph/__init__.py")).parent
        # The module looks for the library beside itself, by the name that is the link.
        library = next(path for path in Path(prefix).rglob("libraygraph.so.*") if path.is_symlink())
        files = {f"raygraph/{path.name}": path.read_bytes() for path in sorted([*package.iterdir(), library])}
    if f"raygraph/_core{sysconfig.get_config_var('EXT_SUFFIX')}" not in files:
        raise SystemExit(f"{build} was configured for another Python: -D RAYGRAPH_PYTHON={sys.executable} is this one")

    numbers = re.findall(r"define RAYGRAPH_VERSION_\w+ (\d+)", (TREE / "base/version.h").read_text())
    version = ".".join(numbers)
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"
    about = f"raygraph-{version}.dist-info"
    files[f"{about}/METADATA"] = (f"Metadata-Version: 2.1\nName: raygraph\nVersion: {version}\nLicense: MIT\n"
                                  "Summary: A glTF path tracer on Vulkan\nRequires-Dist: numpy\n").encode()
    files[f"{about}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: raygraph\nRoot-Is-Purelib: false\nTag: {tag}\n").encode()
    for name in ("LICENSE", "THIRD_PARTY.md"):
        files[f"{about}/{name}"] = (TREE / name).read_bytes()
    record = "".join(f"{name},sha256={_Hash(content)},{len(content)}\n" for name, content in files.items())
    files[f"{about}/RECORD"] = f"{record}{about}/RECORD,,\n".encode()

    wheel = f"raygraph-{version}-{tag}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return wheel


def _Cmake(*arguments):
    subprocess.run(["cmake", *map(str, arguments)], check=True)


def _Hash(content):
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
