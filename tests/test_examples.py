"""The examples run as they stand, with the library alone."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
RUN = """
import json, runpy, sys
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
json.dump(sorted(sys.modules), sys.stderr)
"""


@pytest.mark.slow
def test_a_drive_is_run_and_read_back_without_the_application(tmp_path):
    example = ROOT / "examples" / "01_run_a_drive.py"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(
        [sys.executable, "-c", RUN, str(example), str(tmp_path / "out")],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=environment,
    )
    assert done.returncode == 0, done.stderr
    packages = {module.split(".")[0] for module in json.loads(done.stderr)}
    assert "fcw" in packages
    assert packages.isdisjoint({"fcw_viz", "viser", "rerun", "rich", "tyro"})

    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    first, *warnings = done.stdout.splitlines()
    assert first == f"{summary['frames']} frames, a lead vehicle in {summary['frames_with_lead']}"
    # A line for each change of level; an event of the summary lasts from the first of them to the last.
    changes = [re.fullmatch(r"(.+) s: (\w+) about vehicle (\d+) \(.+\)", line) for line in warnings]
    assert summary["warnings"]
    for span in summary["warnings"]:
        within = [
            change[2]
            for change in changes
            if change
            and span["start_s"] - 0.01 <= float(change[1]) <= span["end_s"]
            and int(change[3]) == span["track_id"]
        ]
        assert span["level"] in within
    assert all(changes)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["drive.mcap", "summary.json"]
