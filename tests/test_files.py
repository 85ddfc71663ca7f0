"""A file is whole or not there, and an earlier one stays until the new one is whole."""

import errno
import os
import re
from pathlib import Path

import pytest

from fcw.errors import UserError
from fcw.files import check_place, whole_file, whole_files, write_whole


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


def test_files_that_belong_together_get_their_names_together(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("a.txt", "b.txt")]
    for path in paths:
        write_whole(path, "earlier")

    def write_one() -> None:
        with whole_files(paths) as (first, _):
            first.write_text("later")
            raise OSError(errno.ENOSPC, "no room")

    with pytest.raises(UserError, match=r"a\.txt, .*b\.txt: cannot write these files"):
        write_one()
    assert [path.read_text() for path in paths] == ["earlier", "earlier"]
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.txt", "b.txt"]
    with whole_files(paths) as partials:
        for partial in partials:
            partial.write_text("later")
    assert [path.read_text() for path in paths] == ["later", "later"]


@pytest.mark.parametrize(
    ("number", "told"),
    [
        (errno.ENOSPC, "(No space left on device); make room on the disk"),
        (errno.EDQUOT, "(Disk quota exceeded); make room on the disk"),
        (errno.EFBIG, "(File too large); allow larger files (ulimit -f)"),
        (errno.EACCES, "(Permission denied); name a file in a folder that exists and can be written"),
    ],
)
def test_what_to_do_about_a_file_that_cannot_be_written_depends_on_why(
    tmp_path: Path, number: int, told: str
) -> None:
    def write() -> None:
        with whole_file(tmp_path / "a.txt"):
            raise OSError(number, "as a library says it")

    with pytest.raises(UserError, match=re.escape(f"a.txt: cannot write this file {told}")):
        write()


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
