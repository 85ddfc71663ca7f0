"""Pictures that show too little: which they are, and what is said of them."""

import re
from collections.abc import Iterator
from itertools import islice
from math import sqrt
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import ndtr

from fcw.frame import nothing_seen
from fcw.motion.ego import EgoEstimator
from fcw.motion.flow.sight import Look, PoorSight, SightWatch, look_at, poor_sight
from fcw.sources.video import VideoSource

Picture = NDArray[np.uint8]

DEMO = Path(__file__).parents[3] / "recordings" / "demo" / "drive.mp4"
HALF_S = 500_000_000
CLEAR = Look(blur=0.8 / 640, contrast=40.0, brightness=100.0, white=0.0)


def posts(sigma_px: float, width: int = 640, dark: float = 40.0, bright: float = 200.0) -> Picture:
    """Upright edges, 32 to a picture, blurred by a Gaussian, as samples of the exact curve."""
    columns, apart = np.arange(width), width / 32
    edges = (np.arange(32) + 0.4) * apart
    steps = ndtr((columns[:, None] - edges) / sigma_px) * (-1.0) ** np.arange(32)
    row = dark + (bright - dark) * steps.sum(axis=1)
    return np.broadcast_to(np.rint(row)[None, :, None], (width * 9 // 16, width, 3)).astype(np.uint8)


@pytest.fixture(scope="module")
def drive() -> list[Picture]:
    """Four seconds of the shipped drive, two pictures of each."""
    frames: Iterator = VideoSource(DEMO).frames()
    return [frame.image for frame in islice(frames, 0, 120, 15)]


def told(images: list[Picture], focal_part: float | None = None) -> list[str]:
    watch = SightWatch(focal_part)
    return [watch.see(number * HALF_S, image) for number, image in enumerate(images)]


@pytest.mark.parametrize("sigma_px", [1.0, 1.5, 2.0, 3.0])
@pytest.mark.parametrize(("dark", "bright"), [(40, 200), (90, 130)])
def test_the_blur_of_edges_is_measured_whatever_their_contrast(sigma_px: float, dark: float, bright: float):
    """A difference of pixels two apart is a mean over two pixels, which adds 2^2 / 12 to the variance.

    The rest is rounding to whole grey values.
    """
    expected = sqrt(sigma_px**2 + 1 / 3)
    assert 640 * look_at(posts(sigma_px, 640, dark, bright)).blur == pytest.approx(expected, rel=0.1)


def test_the_blur_is_a_part_of_the_width_however_many_pixels_there_are():
    small, large = look_at(posts(2.0, 640)).blur, look_at(posts(6.0, 1920)).blur
    assert large == pytest.approx(small, rel=0.03)


@pytest.mark.parametrize("sigma", [4.0, 6.0, 12.0])
def test_noise_is_measured(sigma: float):
    """Less is lost in whole grey values."""
    noisy = np.random.default_rng(1).normal(120, sigma, (360, 640, 3))
    assert look_at(np.rint(noisy).astype(np.uint8)).noise == pytest.approx(sigma, rel=0.15)


def test_a_picture_without_edges_has_no_blur_but_no_contrast_either():
    look = look_at(np.full((360, 640, 3), 90, np.uint8))
    assert np.isnan(look.blur)
    assert poor_sight(look) is PoorSight.FAINT


@pytest.mark.parametrize(
    ("look", "poor"),
    [
        (CLEAR, None),
        (CLEAR._replace(blur=1.5 / 640), PoorSight.SOFT),
        (CLEAR._replace(contrast=5.0), PoorSight.FAINT),
        (CLEAR._replace(contrast=5.0, brightness=20.0), PoorSight.DARK),
        (CLEAR._replace(brightness=20.0), None),
        (CLEAR._replace(noise=5.0), None),
        (CLEAR._replace(noise=15.0), PoorSight.FAINT),
        (CLEAR._replace(noise=15.0, brightness=20.0), PoorSight.DARK),
        (CLEAR._replace(white=0.7), PoorSight.OVEREXPOSED),
        (CLEAR._replace(blur=float("nan")), None),
    ],
)
def test_what_a_picture_lacks_is_named(look: Look, poor: PoorSight | None):
    assert poor_sight(look) is poor


@pytest.mark.parametrize(
    ("look", "poor"),
    [
        (CLEAR._replace(blur=1.25 / 640), PoorSight.SOFT),
        (CLEAR._replace(contrast=10.0), PoorSight.FAINT),
        (CLEAR._replace(white=0.45), PoorSight.OVEREXPOSED),
    ],
)
def test_what_was_said_stands_until_it_is_clearly_better(look: Look, poor: PoorSight):
    assert poor_sight(look) is None
    assert poor_sight(look, before=poor) is poor
    assert poor_sight(CLEAR, before=poor) is None


def test_of_the_shipped_drive_nothing_is_said(drive: list[Picture]):
    assert set(told(drive)) == {""}


def test_a_lens_out_of_focus_is_said_after_a_second_with_how_far_cars_are_found(drive: list[Picture]):
    soft = [np.asarray(cv2.GaussianBlur(image, (0, 0), 4.0), np.uint8) for image in drive]
    first, second, *rest = told(soft, focal_part=1000 / 1280)
    assert first == second == ""
    assert all(note.startswith("soft picture, half of the cars ") for note in rest)
    distance_m = float(re.findall(r"cars (\d+) m away", rest[-1])[0])
    # A car 1.5 m high is there fourteen sigmas high; the rendered lens has a blur of its own beside ours.
    assert 4.0 < 1.5 * 1000 / distance_m / 14 < 4.6
    assert told(soft)[-1].startswith("soft picture, vehicles are missed, far ones first: ")


@pytest.mark.parametrize(("focal_px", "told_m"), [(1000, 25), (960, 25), (1040, 25), (1200, 30), (60, 5)])
def test_how_far_cars_are_found_is_said_in_steps_of_5_m(drive: list[Picture], focal_px: float, told_m: int):
    soft = [np.asarray(cv2.GaussianBlur(image, (0, 0), 4.0), np.uint8) for image in drive]
    assert f" cars {told_m} m away " in told(soft, focal_part=focal_px / 1280)[-1]


def test_the_dark_is_said_and_fog_is(drive: list[Picture]):
    noise = np.random.default_rng(0).standard_normal(drive[0].shape)
    dark = [np.clip(image * 0.15 + 2 * noise, 0, 255).astype(np.uint8) for image in drive]
    fog = [(image * 0.12 + 170).astype(np.uint8) for image in drive]
    assert not any(map(nothing_seen, dark))
    assert told(dark)[-1].startswith("dark picture, vehicles are missed, far ones first: ")
    assert told(fog)[-1].startswith("faint picture, vehicles are missed, far ones first: ")


def test_one_bad_picture_says_nothing(drive: list[Picture]):
    wiped = [np.zeros_like(image) if number == 4 else image for number, image in enumerate(drive)]
    assert set(told(wiped)) == {""}


def test_pictures_in_between_are_not_looked_at(drive: list[Picture], monkeypatch: pytest.MonkeyPatch):
    looked: list[int] = []
    monkeypatch.setattr("fcw.motion.flow.sight.look_at", lambda image: looked.append(1) or CLEAR)
    watch = SightWatch()
    for number in range(61):
        watch.see(number * HALF_S // 15, drive[0])
    assert len(looked) == 5


def test_after_a_cut_it_is_judged_anew(drive: list[Picture]):
    step_ns, ego = 33_333_333, EgoEstimator()
    soft = np.asarray(cv2.GaussianBlur(drive[0], (0, 0), 6.0), np.uint8)
    before = [ego.update(number * step_ns, soft) for number in range(40)]
    assert before[-1].poor_sight
    elsewhere = np.ascontiguousarray(drive[0][::-1, ::-1])
    after = [ego.update(number * step_ns, elsewhere) for number in range(40, 44)]
    assert after[-1].poor_sight == ""


def test_of_the_real_drives_nothing_is_said(data_dir: Path):
    for path in sorted((data_dir / "clips").glob("*.mp4")):
        watch = SightWatch()
        frames = islice(VideoSource(path).frames(), 200)
        notes = {watch.see(frame.time_ns, frame.image) for frame in frames}
        assert notes == {""}, path.name
