"""Logs of this program as drives to run again: their pictures, and when they were."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from export_drives import drive_header, marked_drive, marked_picture, write_log

from fcw.frame import DatedSource, ImageSize
from fcw.sources import open_source

UTC_NS = 1_760_000_000_123_456_789


@pytest.mark.parametrize("size", [ImageSize(63, 47), ImageSize(64, 47), ImageSize(63, 48)])
def test_pictures_of_an_own_log_keep_an_odd_size(size: ImageSize, tmp_path: Path) -> None:
    write_log(tmp_path / "drive.mcap", marked_drive(2, size), drive_header(size))
    source = open_source(tmp_path / "drive.mcap")
    assert source.image_size == size  # a calibration of another size would be stretched
    for frame in source.frames():
        assert frame.image.flags.c_contiguous
        assert np.abs(frame.image.astype(int) - marked_picture(frame.index, size)).mean() < 3


def test_an_own_log_knows_when_its_drive_was(tmp_path: Path) -> None:
    write_log(tmp_path / "drive.mcap", marked_drive(2), replace(drive_header(), zero_utc_ns=UTC_NS))
    source = open_source(tmp_path / "drive.mcap")
    assert isinstance(source, DatedSource)
    assert source.zero_utc_ns == UTC_NS
