"""Every command in the documents is one: the quick ones run, and of the others it is said what runs them."""

import re
import shutil
import tomllib
from pathlib import Path

import pytest
import tyro
from documents.commands import DOCUMENTS, ELSEWHERE, QUICK, ROOT, filled, shown_commands

from fcw_viz.cli import Command, main

DEMO = ROOT / "recordings" / "demo"
OF_OTHERS = {"fsspec[s3]", "fsspec[gcs]"}
"""What else is installed, for batches of drives in a store."""
SHOWN = sorted({(document, command) for document in DOCUMENTS for command in shown_commands(document)})


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_every_command_in_it_can_be_given(document: Path, capsys: pytest.CaptureFixture[str]):
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    targets = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    for command in shown_commands(document):
        program, *arguments = filled(command)
        if program == "make":
            assert arguments[0] in targets, command
        elif program == "pip":
            assert arguments[0] == "install"
            if arguments[1] not in OF_OTHERS:
                assert re.fullmatch(r"fcw(?:\[(\w+)\])?", arguments[1]), command
                assert re.sub(r"fcw\[?|\]", "", arguments[1]) in {"", *extras}, command
        elif program == "python":
            assert arguments[0] == "-m" or (ROOT / arguments[0]).is_file(), command
        elif "COMMAND" not in command and len(arguments) > 1 and "--help" not in arguments:
            try:
                tyro.cli(
                    Command,  # pyright: ignore[reportArgumentType] - as in fcw_viz.cli
                    args=[*arguments, *missing(arguments)],
                    config=(tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff),
                )
            except SystemExit:
                pytest.fail(f"{command}: {capsys.readouterr().err}")


def missing(arguments: list[str]) -> list[str]:
    """What a command needs and a sentence about one option leaves out."""
    if len(arguments) > 1 and arguments[-1] in {"--from-drive", "--labels"}:
        return ["DRIVE"]
    needed = {
        "export": {"--format": "csv", "--out": "OUT"},
        "train": {"--data": "DIR", "--out": "OUT"},
        "batch": {"--out": "DIR"},
        "simulate": {"--out": "DIR"},
    }
    more = [word for name, value in needed.get(arguments[0], {}).items() for word in (name, value)]
    given = [
        word for pair in zip(more[::2], more[1::2], strict=True) for word in pair if pair[0] not in arguments
    ]
    positional = {"run": "SOURCE", "evaluate detection": "LABELS"}
    if arguments[0] == "run" and all(word.startswith("-") or word == "ttc" for word in arguments[1:]):
        given.append(positional["run"])
    if arguments[:2] == ["evaluate", "detection"]:
        for name in ("--images", "--calibration"):
            if name not in arguments:
                given += [name, "DIR"]
        if len(arguments) == 2 or arguments[2].startswith("-"):
            given.append(positional["evaluate detection"])
    return given


@pytest.mark.parametrize("command", QUICK)
def test_a_quick_command_runs_as_it_stands(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    assert command in {shown for _, shown in SHOWN}
    shutil.copy(DEMO / "drive.mp4", tmp_path)
    monkeypatch.chdir(tmp_path)
    try:
        code = main(command.replace("COMMAND", "run").split()[1:])
    except SystemExit as ended:
        code = ended.code
    assert code == 0
    said = capsys.readouterr()
    if "--exact" in command:  # docs/theory.md: "gives no possible camera ... says so"
        assert "2.29 m" in said.out + said.err


def test_of_every_other_command_it_is_known_what_runs_it():
    for _, command in SHOWN:
        assert command in QUICK or any(command.startswith(start) for start in ELSEWHERE), command
    places = {place for value in ELSEWHERE.values() for place in re.findall(r"tests/[\w/.]+", value)}
    assert [place for place in sorted(places) if not (ROOT / place).exists()] == []
