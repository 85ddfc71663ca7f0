"""Cuts of clips: where they are, and what is none."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fcw.motion.flow.cuts import CutWatch, Follows
from fcw.sources.video import VideoSource

Picture = NDArray[np.uint8]

DEMO = Path(__file__).parents[3] / "recordings" / "demo" / "drive.mp4"
FRAME_NS = 33_333_333
REAL_CUTS = {"kb_dashcam2": [364, 435], "tmo_seattlestreet2": [821]}
"""The second picture of each other view, in the two of ten clips that were edited; seen by eye."""


@pytest.fixture(scope="module")
def drive() -> list[Picture]:
    """Most of a second of the shipped drive."""
    frames = VideoSource(DEMO).frames(5_000_000_000)
    return [next(frames).image for _ in range(24)]


@pytest.fixture(scope="module")
def elsewhere(drive: list[Picture]) -> list[Picture]:
    """Another view: that of a camera that hangs upside down."""
    return [np.ascontiguousarray(image[::-1, ::-1]) for image in drive]


def seen(images: Iterable[Picture], step_ns: int = FRAME_NS) -> list[Follows]:
    watch = CutWatch()
    return [watch.see(number * step_ns, image) for number, image in enumerate(images)]


def cuts(follows: Iterable[Follows]) -> list[int]:
    return [number for number, one in enumerate(follows) if one is Follows.AFTER_CUT]


def test_a_cut_is_known_by_the_second_picture_after_it(drive: list[Picture], elsewhere: list[Picture]):
    follows = seen([*drive[:8], *elsewhere[8:16], *drive[16:]])
    same, unlike, cut = Follows.SAME_VIEW, Follows.UNLIKE, Follows.AFTER_CUT
    assert follows == [same] * 8 + [unlike, cut] + [same] * 6 + [unlike, cut] + [same] * 6


def test_one_foreign_picture_is_a_broken_one_and_no_cut(drive: list[Picture], elsewhere: list[Picture]):
    follows = seen([*drive[:9], elsewhere[9], *drive[10:]])
    assert [number for number, one in enumerate(follows) if one is not Follows.SAME_VIEW] == [9]
    assert follows[9] is Follows.UNLIKE


def test_a_smear_that_a_wiper_takes_off_is_no_cut(drive: list[Picture], elsewhere: list[Picture]):
    """With the blade in it the next picture is more like the smeared one; it is like the one before, too."""
    water = elsewhere[0].astype(np.float32) - cv2.blur(elsewhere[0], (161, 161))
    smeared, wet = (np.clip(drive[9] + part * water, 0, 255).astype(np.uint8) for part in (1.6, 0.7))
    wet[:, :200] = 255
    follows = seen([*drive[:9], smeared, wet, *drive[11:]])
    assert follows[9] is Follows.UNLIKE
    assert cuts(follows) == []


def test_pictures_that_are_all_unlike_each_other_are_no_cut(drive: list[Picture]):
    noise = np.random.default_rng(3).integers(0, 256, (12, 36, 64, 3)).astype(np.uint8)
    large = [cv2.resize(one, (1280, 720), interpolation=cv2.INTER_NEAREST) for one in noise]
    follows = seen([*drive[:8], *large])
    assert not cuts(follows)
    assert follows.count(Follows.UNLIKE) == 1  # none of the others is less alike than that one


@pytest.mark.parametrize("level", [0, 128, 255])
def test_a_lens_that_is_covered_for_a_while_is_no_cut(level: int, drive: list[Picture]):
    covered = np.full_like(drive[0], level)
    assert set(seen([*drive[:8], *[covered] * 5, *drive[8:]])) == {Follows.SAME_VIEW}


def test_after_a_pause_nothing_is_told(drive: list[Picture], elsewhere: list[Picture]):
    assert set(seen([*drive[:8], *elsewhere[:8]], step_ns=200_000_000)) == {Follows.SAME_VIEW}


@given(gain=st.floats(0.4, 1.6), offset=st.floats(-40, 40))
def test_a_picture_that_gets_darker_or_brighter_is_no_cut(drive: list[Picture], gain: float, offset: float):
    """As under a bridge, or when the camera adapts; also where much of it is over- or underexposed."""
    others = [cv2.convertScaleAbs(np.maximum(one * gain + offset, 0)).astype(np.uint8) for one in drive[8:11]]
    assert set(seen([*drive[:8], *others])) == {Follows.SAME_VIEW}


def test_the_shipped_drive_is_not_cut():
    assert set(seen(frame.image for frame in VideoSource(DEMO).frames())) == {Follows.SAME_VIEW}


def test_real_clips_are_cut_where_they_were_edited_and_nowhere_else(data_dir: Path):
    for path in sorted((data_dir / "clips").glob("*.mp4")):
        watch = CutWatch()
        follows = [watch.see(frame.time_ns, frame.image) for frame in VideoSource(path).frames()]
        expected = REAL_CUTS.get(path.stem, [])
        assert cuts(follows) == expected, path.name
        unlike = [number for number, one in enumerate(follows) if one is Follows.UNLIKE]
        assert unlike == [number - 1 for number in expected], path.name


def test_a_drive_of_ten_pictures_a_second_is_not_cut(data_dir: Path):
    watch = CutWatch()
    source = VideoSource(data_dir / "kitti-odometry-03" / "drive.mp4")
    follows = {watch.see(100_000_000 * frame.index, frame.image) for frame in source.frames()}
    assert follows == {Follows.SAME_VIEW}


def test_a_wiper_is_no_cut(drive: list[Picture]):
    wiped = [image.copy() for image in drive]
    for number, image in enumerate(wiped[8:]):
        cv2.line(image, (640, 860), (80 * number, 0), (15, 15, 15), 60)
    assert set(seen(wiped)) == {Follows.SAME_VIEW}


def test_a_repeated_picture_after_a_cut_tells_as_the_next_one_does(
    drive: list[Picture], elsewhere: list[Picture]
):
    """A video of 15 pictures a second, shown at 30."""
    twice = [image for image in [*drive[:8], *elsewhere[8:12]] for _ in range(2)]
    assert cuts(seen(twice)) == [17]


def dark_and_noisy(images: Iterable[Picture]) -> Iterator[Picture]:
    rng = np.random.default_rng(4)
    for image in images:
        noisy = image * 0.12 + rng.normal(4, 5, image.shape)
        yield np.clip(np.round(noisy), 0, 255).astype(np.uint8)


def test_the_noise_of_a_dark_drive_is_no_cut(drive: list[Picture]):
    assert set(seen(dark_and_noisy(drive))) == {Follows.SAME_VIEW}
