"""A log that is being written is followed; one that is another by now is noticed."""

from pathlib import Path

import numpy as np
import pytest
from review_drives import FRAMES, RATE_HZ, SIZE, DriveWriting, result

from fcw.errors import UserError
from fcw.logs.mcap.following import LogChange, LogWatch
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.pictures import LogPictures


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "drive.mcap"


@pytest.mark.slow
def test_a_growing_log_is_at_each_look_what_is_read_from_its_beginning(path: Path):
    writing = DriveWriting(path)
    writing.write(range(60))
    log = DriveLog(path)
    watch = LogWatch(log)
    lengths = [len(log.series())]
    for start in range(60, 240, 37):
        writing.write(range(start, start + 37))
        assert watch.look() is LogChange.GROWN
        log = log.grown()
        watch = LogWatch(log)
        assert watch.look() is LogChange.NONE
        series, anew = log.series(), DriveLog(path).series()
        assert series.to_bytes() == anew.to_bytes()
        lengths.append(len(series))
    assert lengths == sorted(set(lengths))
    last = int(log.series().time_ns[-1])
    # What was written is known within 0.3 s of the drive's time.
    assert result(244).time_ns - last <= 0.3e9 + 1e9 / RATE_HZ
    pictures = LogPictures(log)
    assert pictures.at(200).shape == (SIZE.height, SIZE.width, 3)
    writing.write(range(245, FRAMES))
    writing.close()
    assert watch.look() is LogChange.GROWN
    log = log.grown()
    assert log.complete
    assert np.array_equal(log.series().frame_index, np.arange(FRAMES))
    assert LogWatch(log).look() is LogChange.NONE


@pytest.mark.slow
def test_a_log_that_is_written_anew_or_deleted_is_not_taken_for_the_same(path: Path):
    writing = DriveWriting(path)
    writing.write(range(100))
    growing = LogWatch(DriveLog(path))
    writing.close()
    finished = LogWatch(DriveLog(path))
    again = DriveWriting(path)
    again.write(range(50, 400))
    assert growing.look() is LogChange.REPLACED
    assert finished.look() is LogChange.REPLACED
    path.unlink()
    assert growing.look() is LogChange.GONE


def test_reading_on_in_a_log_that_was_deleted_is_told_in_words(path: Path):
    writing = DriveWriting(path)
    writing.write(range(30))
    writing.close()
    log = DriveLog(path)
    path.unlink()
    with pytest.raises(UserError, match=r"drive.mcap: cannot read the log \(No such file"):
        log.result_at(3)
