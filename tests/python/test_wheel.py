"""The wheel, by the backend that pip calls: it is whole, and runs where nothing else of the package is."""
import base64
import csv
import hashlib
import os
import subprocess
import sys
import zipfile
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]


def test_wheel_runs_alone(tmp_path):
    build = Path(os.environ["RAYGRAPH_PROGRAM"]).parent
    name = subprocess.run([sys.executable, "-B", "-c", "import build_backend, sys\n"
                           "print(build_backend.build_wheel(sys.argv[1], {'build': sys.argv[2]}))", tmp_path, build],
                          check=True, capture_output=True, text=True, cwd=TREE / "python").stdout.split()[-1]
    site = tmp_path / "site"
    with zipfile.ZipFile(tmp_path / name) as wheel:
        wheel.extractall(site)
        names = set(wheel.namelist())
        record = {row[0]: row[1:] for row in csv.reader(wheel.read(next(n for n in names if n.endswith("/RECORD"))).decode().split())}
        assert set(record) == names
        for member, (digest, size) in record.items():
            content = wheel.read(member)
            expected = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
            assert (digest, size) == (f"sha256={expected}", str(len(content))) or member.endswith("/RECORD")
    # The library beside the module is the one that is loaded.
    script = "import raygraph\nprint(raygraph.__version__)\nprint([l for l in open('/proc/self/maps') if 'libraygraph' in l][0])"
    environment = {**os.environ, "PYTHONPATH": str(site)}
    output = subprocess.run([sys.executable, "-B", "-c", script], check=True, capture_output=True, text=True, cwd=tmp_path,
                            env=environment).stdout.split()
    assert name.startswith(f"raygraph-{output[0]}-")
    assert output[-1].startswith(str(site / "raygraph/libraygraph.so."))
