"""Pictures whose time stamps are wrong: one of them costs none of the others."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from mcap_files import DELAY_NS, START_NS, demo_frames, encoded, foxglove_video, ros_file, ros_image

from fcw.frame import Source
from fcw.sources import open_source

IMAGE = "sensor_msgs/msg/Image"
PERIOD_NS = 33_333_333
HOUR_NS = 3600 * 10**9
COUNT = 20
TIMES_NS = [START_NS + number * PERIOD_NS for number in range(COUNT)]


def recording(
    folder: Path, wrong_by_ns: dict[int, int], logged_ns: list[int] | None = None, count: int = COUNT
) -> Source:
    """Grey pictures that are as bright as their number; the stamps of some are wrong."""
    messages = []
    logged_ns = logged_ns or [time_ns + DELAY_NS for time_ns in TIMES_NS]
    for number, (time_ns, log_ns) in enumerate(zip(TIMES_NS[:count], logged_ns, strict=False)):
        grey = np.full((4, 6, 1), number, np.uint8)
        stamped = ros_image(grey, "mono8", time_ns + wrong_by_ns.get(number, 0))
        messages.append(("/camera", IMAGE, log_ns, stamped))
    return open_source(ros_file(folder / "drive.mcap", messages))


@pytest.mark.parametrize("number", [0, 1, 9, COUNT - 1])
@pytest.mark.parametrize("wrong_by_ns", [HOUR_NS, -HOUR_NS, 6 * 10**9])
def test_a_picture_with_a_wrong_stamp_stands_where_it_was_logged(
    number: int, wrong_by_ns: int, tmp_path: Path
) -> None:
    source = recording(tmp_path, {number: wrong_by_ns})
    read = list(source.frames())
    assert [frame.time_ns for frame in read] == TIMES_NS
    assert [int(frame.image[0, 0, 0]) for frame in read] == list(range(COUNT))
    assert source.frame_rate_hz == pytest.approx(30, rel=1e-3)
    (note,) = source.notes
    assert note.endswith(": 1 picture with an impossible time stamp: its log time is used")


def test_pictures_are_found_by_their_times_also_behind_a_wrong_stamp(tmp_path: Path) -> None:
    source = recording(tmp_path, {0: HOUR_NS, 9: HOUR_NS})
    for number in (8, 9, 10, 15):
        assert next(source.frames(TIMES_NS[number])).index == number


def test_several_wrong_stamps_are_counted(tmp_path: Path) -> None:
    source = recording(tmp_path, {3: HOUR_NS, 4: 2 * HOUR_NS, 15: -HOUR_NS})
    assert [frame.time_ns for frame in source.frames()] == TIMES_NS
    assert "3 pictures with impossible time stamps: their log times are used" in source.notes[0]


def test_stamps_are_kept_where_the_log_times_are_those_of_a_copy(tmp_path: Path) -> None:
    """A script that writes a recording anew in no time; one that halts for a minute in the middle."""
    for halt_ns in (0, 60 * 10**9):
        copied_ns = [START_NS + HOUR_NS + i * 1000 + (i >= COUNT // 2) * halt_ns for i in range(COUNT)]
        source = recording(tmp_path, {}, copied_ns)
        assert [frame.time_ns for frame in source.frames()] == TIMES_NS
        assert source.notes == ()


def test_a_clock_that_is_set_is_followed(tmp_path: Path) -> None:
    source = recording(tmp_path, dict.fromkeys(range(10, COUNT), HOUR_NS))
    steps_ns = [b.time_ns - a.time_ns for a, b in pairwise(source.frames())]
    assert [round(step_ns / HOUR_NS) for step_ns in steps_ns] == [0] * 9 + [1] + [0] * 9
    assert source.notes == ()


def test_a_single_picture_keeps_its_stamp(tmp_path: Path) -> None:
    (frame,) = recording(tmp_path, {0: HOUR_NS}, count=1).frames()
    assert frame.time_ns == START_NS + HOUR_NS


def test_a_packet_of_a_video_with_a_wrong_stamp_stands_where_it_was_logged(tmp_path: Path) -> None:
    packets = encoded(demo_frames(COUNT), "libx264", {"tune": "zerolatency"})
    times_ns = [time_ns for time_ns, _ in packets]
    path = foxglove_video(tmp_path / "drive.mcap", packets, wrong_by_ns={0: HOUR_NS, 7: HOUR_NS})
    source = open_source(path)
    assert [frame.time_ns for frame in source.frames()] == times_ns
    (note,) = source.notes
    assert note.endswith("/video: 2 pictures with impossible time stamps: their log times are used")
