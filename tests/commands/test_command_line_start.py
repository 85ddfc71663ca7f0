"""What the command line loads before it knows what to do."""

import subprocess
import sys

import pytest

HEAVY = {"numpy", "scipy", "cv2", "numba", "av", "rerun", "viser", "mcap", "pyarrow", "onnxruntime"}
PRINT_HEAVY = f"""
import sys
from fcw_viz.cli import main
try:
    main(sys.argv[1:])
except SystemExit as end:
    assert end.code == 0, end.code
print("loaded:", *sorted(set(sys.modules) & {HEAVY}))
"""


@pytest.mark.parametrize(
    "arguments", [["--help"], ["run", "--help"], ["calibrate", "--help"], ["bench", "--help"]]
)
def test_help_loads_no_heavy_library(arguments: list[str]) -> None:
    process = subprocess.run(
        [sys.executable, "-c", PRINT_HEAVY, *arguments], capture_output=True, text=True, check=True
    )
    assert process.stdout.splitlines()[-1] == "loaded:"
