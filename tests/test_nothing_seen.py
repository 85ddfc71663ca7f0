"""Pictures in which nothing can be seen, and real ones, also of the night, in which something can."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from fcw.frame import nothing_seen
from fcw.sources.video import VideoSource

DEMO = Path(__file__).parents[1] / "recordings" / "demo" / "drive.mp4"


def grey(level: int, noise: float = 0.0) -> NDArray[np.uint8]:
    values = np.random.default_rng(1).normal(level, noise, (720, 1280, 3))
    return np.clip(np.round(values), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("picture", [grey(0), grey(255), grey(16, 2.0), grey(3, 2.0)[:9, :9]])
def test_in_a_picture_of_one_brightness_nothing_can_be_seen(picture: NDArray[np.uint8]):
    assert nothing_seen(picture)


def test_the_time_that_a_recorder_writes_into_a_black_picture_shows_no_road():
    picture = grey(0)
    cv2.putText(
        picture, "2024-05-01 23:10:07  DRIVE 1", (20, 700), cv2.FONT_HERSHEY_SIMPLEX, 1.0, (255,) * 3, 2
    )
    assert nothing_seen(picture)


def test_at_night_tail_lights_and_the_road_before_the_own_lamps_can_be_seen():
    picture = grey(2, 1.0)
    cv2.ellipse(picture, (640, 700), (500, 200), 0, 180, 360, (45, 45, 45), -1)
    for left in (600, 660):
        cv2.circle(picture, (left, 380), 6, (40, 40, 200), -1)
    assert not nothing_seen(picture)


def test_in_the_shipped_drive_something_can_be_seen():
    assert not nothing_seen(next(VideoSource(DEMO).frames()).image)


def test_in_no_picture_of_the_real_drives_nothing_can_be_seen(data_dir: Path):
    for path in sorted((data_dir / "clips").glob("*.mp4")):
        for frame in VideoSource(path).frames():
            assert frame.index % 15 or not nothing_seen(frame.image), (path.name, frame.index)
