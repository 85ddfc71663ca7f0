"""A file is whole or not there, and an earlier one stays until the new one is whole."""

import os
from pathlib import Path

import pytest

from fcw.errors import UserError
from fcw.files import check_place, whole_file, write_whole


def test_a_file_that_fails_half_way_leaves_the_earlier_one_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "result.txt"
    write_whole(path, "earlier")

    def write_half() -> None:
        with whole_file(path) as partial:
            partial.write_text("lat")
            raise RuntimeError("half way")

    with pytest.raises(RuntimeError, match="half way"):
        write_half()
    assert path.read_text() == "earlier"
    assert [each.name for each in tmp_path.iterdir()] == ["result.txt"]


def test_the_partial_name_keeps_the_suffix_and_is_not_the_files_own(tmp_path: Path) -> None:
    with whole_file(tmp_path / "video.mp4") as partial:
        assert partial.suffix == ".mp4"
        assert partial.name != "video.mp4"
        partial.write_bytes(b"\x00")
    assert (tmp_path / "video.mp4").read_bytes() == b"\x00"


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"gone/result\.txt: cannot write this file"):
        write_whole(tmp_path / "gone" / "result.txt", "text")


def test_a_place_is_checked_before_the_work(tmp_path: Path) -> None:
    check_place(tmp_path / "new.yaml")
    with pytest.raises(UserError, match="there is no such folder; name another"):
        check_place(tmp_path / "missing" / "new.yaml")
    with pytest.raises(UserError, match="a folder; name a file"):
        check_place(tmp_path)


def test_a_pipe_or_device_is_never_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path in (pipe, tmp_path):
        with pytest.raises(UserError, match="this is no file, but a device, a pipe or a folder"):
            write_whole(path, "text")
    assert pipe.is_fifo()
