"""How commands speak: notes as they are, JSON that any reader takes, bars for terminals alone."""

import io
import json
import math
import re
import subprocess
import sys

import pytest
from rich.console import Console

from fcw_viz.console import Bar, note, print_json, progress
from fcw_viz.console_text import counted
from fcw_viz.jobs.drive import STARTING


def drawn(
    work_total: float,
    rate_of: str = "",
    terminal: bool = True,
    text: str = "work [of] many",
    width: int = 100,
) -> str:
    console = Console(
        file=io.StringIO(), force_terminal=terminal, width=width, color_system=None, soft_wrap=True
    )
    with progress(text, work_total, console, rate_of) as bar:
        bar.reach(work_total / 2)
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def test_a_bar_shows_steps_or_a_share_and_the_unchanged_name():
    assert "2/4" in drawn(4)
    assert "50%" in drawn(4.0)
    assert "work [of] many" in drawn(4)
    assert "frames/s" in drawn(4, "frames")


def test_without_a_terminal_no_bar_is_drawn():
    assert not drawn(4, terminal=False)


@pytest.mark.parametrize("width", [80, 40])
@pytest.mark.parametrize("text", [STARTING, "2026-11-20 on the way to work and back again, in the rain.mp4"])
def test_a_bar_is_one_line_also_in_a_narrow_terminal(text: str, width: int):
    said = drawn(100_000, "frames", text=text, width=width)
    pictures = re.split(r"\x1b\[[?0-9]*[a-zA-Z]|\r", said.removesuffix("\n"))
    assert "0 frames/s" in said
    assert max(len(picture.rstrip("\n")) for picture in pictures) <= width
    assert said.count("\n") == 1  # at its end


def test_in_80_columns_it_is_said_whole_that_a_run_starts():
    assert STARTING in drawn(100_000, "frames", text=STARTING, width=80)


def test_a_new_task_starts_at_zero():
    console = Console(file=io.StringIO(), force_terminal=True, width=100, color_system=None)
    with progress("first", 4, console) as bar:
        bar.advance(3)
        bar.begin("second", 7)
        assert isinstance(bar, Bar)
    assert isinstance(console.file, io.StringIO)
    assert "0/7" in console.file.getvalue()


def test_json_has_null_for_what_is_not_finite(capsys: pytest.CaptureFixture[str]):
    print_json({"a": [math.nan, 1.5], "b": -math.inf})
    assert json.loads(capsys.readouterr().out) == {"a": [None, 1.5], "b": None}


def test_notes_go_to_standard_error_as_they_are(capsys: pytest.CaptureFixture[str]):
    note("a [b] " + "long " * 40)
    out, err = capsys.readouterr()
    assert (out, err) == ("", "note: a [b] " + "long " * 40 + "\n")


def test_what_goes_to_a_file_is_not_wrapped():
    sentence = "word " * 60 + "end"
    code = f"from fcw_viz.console import RESULTS; RESULTS.print({sentence!r})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == f"{sentence}\n"


@pytest.mark.parametrize(("count", "said"), [(0, "0 frames"), (1, "1 frame"), (2, "2 frames")])
def test_one_thing_is_told_as_one(count: int, said: str):
    assert counted(count, "frame") == said
