"""abi_test.py HEADER LIBRARY COMPILER: abi.py passes what was added, and refuses what is gone or has changed."""
import subprocess
import sys
import tempfile
from pathlib import Path

header, library, compiler = sys.argv[1:]
script = Path(__file__).with_name("abi.py")
folder = Path(tempfile.mkdtemp())
release = folder / "release.txt"
edited = folder / "raygraph.h"


def run(*options, of=header):
    ran = subprocess.run([sys.executable, script, of, library, compiler, release, *options], capture_output=True,
                         text=True)
    return ran.returncode, ran.stdout + ran.stderr


assert run()[0] == 1, "without a release there is nothing to compare with"
assert run("--write")[0] == 0
code, text = run()
assert code == 0 and "new:" not in text, text
original = Path(header).read_text()
for before, after, expected, is_error in [
    ("    uint32_t transfer_family;\n} RgDeviceSetup;",
     "    uint32_t transfer_family;\n    uint64_t later;\n} RgDeviceSetup;", "new: field RgDeviceSetup.later", False),
    ("    RG_FEATURE_RAY_QUERY = 1 << 0,", "    RG_FEATURE_RAY_QUERY = 1 << 0,\n    RG_FEATURE_NEW = 1 << 20,",
     "new: constant RG_FEATURE_NEW", False),
    ("    RG_ERROR_IO = 3,", "    RG_ERROR_IO = 9,", "changed: constant RG_ERROR_IO 3", True),
    ("    double relative_mse;\n    double flip;", "    double flip;\n    double relative_mse;", "changed: field", True),
    ("    uint32_t extension_count;\n    RgFeatures optional_features;  // those in the chain\n",
     "    int32_t extension_count;\n    RgFeatures optional_features;\n", "changed: field RgDeviceSetup.extension_count", True),
    ("    uint32_t reserved;\n    uint64_t value;  // 0: no work", "    uint64_t value;", "gone: field RgToken", True),
    ("    uint64_t value;  // 0: no work\n", "    uint64_t value;\n    uint64_t later;\n", "it has no struct_size", True),
    ("rg_device_wait(RgDevice* device, RgToken token)", "rg_device_wait(RgDevice* device, uint64_t token)",
     "changed: function rg_device_wait", True),
    ("RG_API int32_t rg_last_vk_result(void);", "", "gone: function rg_last_vk_result", True),
    ("RG_API int32_t rg_last_vk_result(void);", "", "rg_last_vk_result is exported, and not declared", True),
    ("RG_API int32_t rg_last_vk_result(void);",
     "RG_API int32_t rg_last_vk_result(void);\nRG_API int32_t rg_other(void);", "rg_other is declared, and", True),
    ("typedef uint32_t RgView;", "typedef uint64_t RgView;", "changed: type RgView", True),
]:
    assert before in original, before
    edited.write_text(original.replace(before, after, 1))
    code, text = run(of=edited)
    assert code == is_error and expected in text, f"{expected}: {text}"
