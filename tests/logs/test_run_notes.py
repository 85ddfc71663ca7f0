"""What a run told is read from beside its log, and only from there."""

import json
from pathlib import Path

import pytest

from fcw.logs.run_notes import notes_of_run


@pytest.mark.parametrize(
    ("log_name", "summary", "notes"),
    [
        ("drive.mcap", json.dumps({"notes": ["one", "two"]}), ("one", "two")),
        ("drive.mcap", json.dumps({"notes": []}), ()),
        ("failed.drive.mcap", json.dumps({"notes": ["of another run"]}), ()),
        ("drive.mcap", '{"notes": ["to', ()),
        ("drive.mcap", '{"notes": "one"}', ()),
        ("drive.mcap", "[]", ()),
        ("drive.mcap", None, ()),
    ],
)
def test_notes_are_those_of_the_summary_beside_the_log(log_name, summary, notes, tmp_path: Path):
    if summary is not None:
        (tmp_path / "summary.json").write_text(summary)
    assert notes_of_run(tmp_path / log_name) == notes
