"""What the command line loads before it knows what to do."""

import re
import subprocess
import sys

import pytest

from fcw_viz.cli import main

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


COMMANDS = (
    *("demo", "calibrate", "run", "batch", "review", "export", "recover", "train", "simulate", "bench"),
    *("evaluate detection", "evaluate distance", "evaluate motion", "evaluate warning"),
)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_running_text_without_defaults_that_say_nothing(command, monkeypatch, capsys) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    with pytest.raises(SystemExit):
        main([*command.split(), "--help"])
    said = capsys.readouterr().out
    assert not re.search(r"\(default: (None|False)?\)", said)
    # Each option has its line, or two where its name is long; only a break of the text adds another.
    rows = [row.strip("│ \n") for row in said.splitlines() if row.startswith("│")]
    texts = [row for row in rows if not row.startswith("-")]
    assert all(text.endswith((".", ")")) for text in texts), texts
