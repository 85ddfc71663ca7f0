"""The secret of a user's pages: private, and the same from one start to the next."""

import os
from pathlib import Path

import pytest

from fcw_viz.page.guard.token import FILE_NAME, page_token, state_folder

pytestmark = pytest.mark.skipif(os.name != "posix", reason="rights of files are POSIX's")


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr("fcw_viz.page.guard.token.state_folder", lambda: tmp_path / "state" / "fcw")
    return tmp_path / "state" / "fcw" / FILE_NAME


def token() -> str:
    """As a program that was just started has it."""
    return page_token.__wrapped__()


def test_it_is_kept_where_nobody_else_can_read_it(file: Path):
    first = token()
    assert len(first) == 43
    assert file.stat().st_mode & 0o777 == 0o600
    assert file.parent.stat().st_mode & 0o777 == 0o700
    assert [path.name for path in file.parent.iterdir()] == [FILE_NAME]
    assert token() == first == file.read_text()


@pytest.mark.parametrize("text", ["", "short", "x" * 44, "ä" * 43, "\0" * 43])
def test_a_damaged_file_is_replaced(file: Path, text: str):
    file.parent.mkdir(parents=True)
    file.write_text(text)
    file.chmod(0o600)
    assert token() == token() == file.read_text() != text


def test_what_others_could_read_is_no_secret_any_more(file: Path):
    first = token()
    file.chmod(0o644)
    assert token() != first
    assert file.stat().st_mode & 0o777 == 0o600


def test_no_link_is_followed_and_no_pipe_waited_for(file: Path, tmp_path: Path):
    file.parent.mkdir(parents=True)
    other = tmp_path / "other"
    other.write_text("x" * 43)
    other.chmod(0o600)
    file.symlink_to(other)
    assert token() != "x" * 43
    assert other.read_text() == "x" * 43
    file.unlink()
    os.mkfifo(file, 0o600)
    assert len(token()) == 43


def test_without_a_place_to_keep_it_it_holds_for_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "file").touch()
    monkeypatch.setattr("fcw_viz.page.guard.token.state_folder", lambda: tmp_path / "file" / "fcw")
    assert token() != token()


def test_a_user_without_a_home_has_a_place_where_one_is_named():
    assert state_folder({"XDG_STATE_HOME": "/var/state"}) == Path("/var/state/fcw")
    assert state_folder({"XDG_STATE_HOME": "relative"}) == Path.home() / ".local" / "state" / "fcw"
