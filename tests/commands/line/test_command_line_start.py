"""What the command line loads before it knows what to do."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from fcw.versions import __version__
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


def test_without_a_command_all_of_them_are_listed_with_what_they_do(capsys) -> None:
    assert main([]) == 2
    out, said = capsys.readouterr()
    assert out == ""
    assert "recover    Write a complete log from the log of a run that was killed" in said
    assert all(f"• {command.split()[0]} " in said for command in COMMANDS)


def test_without_what_to_evaluate_all_of_it_is_listed_with_what_it_measures(capsys) -> None:
    assert main(["evaluate"]) == 2
    out, said = capsys.readouterr()
    assert out == ""
    assert "warning    Measure warnings: in standard scenarios" in said
    assert all(f"• {command.split()[1]} " in said for command in COMMANDS if command.startswith("evaluate "))


def test_the_version_is_printed(capsys) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"fcw {__version__}\n"


ENDED_LATE = """
import os, signal, sys
from fcw_viz.signals import keep_exit_code

class Late:
    def __del__(self, end=os.kill, process=os.getpid(), number=signal.Signals[sys.argv[1]].value):
        end(process, number)

sys.late = Late()  # goes with the last modules, when Python no longer handles signals
keep_exit_code(0)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_at_the_very_end_does_not_change_the_exit_code(name: str) -> None:
    assert subprocess.run([sys.executable, "-c", ENDED_LATE, name], check=False).returncode == 0


def with_no_reader(arguments: list[str], *, of_errors: bool = False) -> "subprocess.CompletedProcess[str]":
    """Run `fcw` with a pipe that nobody reads any more for its standard output, or error."""
    reader, writer = os.pipe()
    os.close(reader)
    out, err = (subprocess.PIPE, writer) if of_errors else (writer, subprocess.PIPE)
    command = [sys.executable, "-m", "fcw_viz", *arguments]
    done = subprocess.run(command, stdout=out, stderr=err, text=True, check=False)
    os.close(writer)
    return done


@pytest.mark.parametrize("results", [[], ["--json"]], ids=["table", "json"])
def test_the_work_is_done_though_nobody_reads_its_results(results: list[str], tmp_path: Path) -> None:
    saved = tmp_path / "camera.yaml"
    points = ["--points", "6:640", "15:520", "30:480", "--height", "1.25", "--image-size", "1280x720"]
    done = with_no_reader(["calibrate", *points, "--save", str(saved), *results])
    assert (done.returncode, done.stderr) == (0, "")
    assert saved.is_file()


def test_help_may_be_left_unread() -> None:
    done = with_no_reader(["run", "--help"])
    assert (done.returncode, done.stderr) == (0, "")


def test_a_mistake_keeps_its_exit_code_though_nobody_reads_of_it() -> None:
    assert with_no_reader(["run", "no-such.mp4"], of_errors=True).returncode == 2


@pytest.mark.skipif(os.name != "posix", reason="closing a program's outputs is the shell's")
@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_the_work_is_done_where_outputs_are_closed_from_the_start(closed: str, tmp_path: Path) -> None:
    saved = tmp_path / "camera.yaml"
    points = ["--points", "6:640", "15:520", "30:480", "--height", "1.25", "--image-size", "1280x720"]
    command = [sys.executable, "-m", "fcw_viz", "calibrate", *points, "--save", str(saved)]
    done = subprocess.run(
        ["sh", "-c", f'exec "$0" "$@" {closed}', *command], capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert saved.is_file()
