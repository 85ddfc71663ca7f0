"""Pictures that are shown again: of a slower video, of a stuck camera; not where we stand."""

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from fcw.frame import Frame
from fcw.sources.repeated import RepeatedPictures

RATE_HZ = 30.0


def repeated(images: Sequence[NDArray[np.float64]]) -> list[bool]:
    shown = RepeatedPictures()
    return [
        shown.is_repeated(Frame(index, round(index * 1e9 / RATE_HZ), image.clip(0, 255).astype(np.uint8)))
        for index, image in enumerate(images)
    ]


def road(count: int, contrast: float = 60.0) -> list[NDArray[np.float64]]:
    """Pictures of a scene that moves 2 px to the side from each to the next."""
    scene = np.random.default_rng(1).normal(100, contrast, (24, 120, 3)).repeat(10, 0).repeat(10, 1)
    return [scene[:, 2 * index : 2 * index + 320] for index in range(count)]


@pytest.mark.parametrize("times", [2, 3, 4, 6])
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_every_picture_that_is_shown_several_times_is_told_after_a_second(times: int, noise: float):
    draw = np.random.default_rng(2)
    images = [one + draw.normal(0, noise, one.shape) for one in road(20) for _ in range(times)]
    assert repeated(images)[30:] == [index % times > 0 for index in range(30, 20 * times)]


def test_the_fifth_picture_of_a_film_that_was_made_for_24_a_second_is_a_repeated_one():
    new = road(48)
    images = [new[index * 24 // 30] for index in range(60)]
    assert repeated(images)[30:] == [index % 5 == 1 for index in range(30, 60)]


def test_no_picture_of_a_drive_is_repeated_however_dark():
    assert not any(repeated(road(60)))
    assert not any(repeated(road(60, contrast=1.0)))


def test_where_we_stand_pictures_are_new_however_they_are_encoded():
    (still,), draw = road(1), np.random.default_rng(3)
    encoded = [draw.normal(0, 3, still.shape) for _ in range(4)]  # afresh twice a second
    afresh = [still + encoded[index // 15] + draw.normal(0, 0.2, still.shape) for index in range(60)]
    assert not any(repeated([still] * 60))
    assert not any(repeated(afresh))


def test_a_stuck_recorder_repeats_its_picture_for_a_second_and_then_the_world_stands():
    images = road(30)
    stuck = repeated([*images, *images[-1:] * 90])
    assert stuck == [*[False] * 30, *[True] * 30, *[False] * 60]


def test_where_we_stop_pictures_are_new_after_a_second_at_the_latest():
    (still,), draw = road(1), np.random.default_rng(3)
    standing = [still + draw.normal(0, 0.2, still.shape) for _ in range(120)]
    assert not any(repeated([*road(30)[::-1], *standing])[60:])
