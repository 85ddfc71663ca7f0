"""The channel kernel against an independent float64 implementation of the same definition."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from fcw.detection.channels.aggregated import CONTEXT_PX, ChannelComputer, compute_channels
from fcw.frame import ImageSize

Floats = NDArray[np.float64]


def reference_channels(image: NDArray[np.uint8]) -> Floats:
    """The ten channels before quantisation, after the module's definition, with whole-picture operations."""
    rows, columns = image.shape[0] // 4, image.shape[1] // 4
    rgb = image[: rows * 4, : columns * 4, ::-1] / 255.0
    to_xyz = np.array(
        [[0.430574, 0.341550, 0.178325], [0.222015, 0.706655, 0.071330], [0.020183, 0.129553, 0.939180]]
    )
    x, y, z = np.moveaxis(rgb @ to_xyz.T, -1, 0)
    lightness = np.where(y > (6 / 29) ** 3, 116 * np.cbrt(y) - 16, (29 / 3) ** 3 * y)
    total = x + 15 * y + 3 * z + 1e-35
    u = 13 * lightness * (4 * x / total - 0.197833)
    v = 13 * lightness * (9 * y / total - 0.468331)
    luv = np.stack([lightness, u + 88, v + 134]) / 270

    luv = _separable(luv, [1 / 4, 2 / 4, 1 / 4])
    padded = np.pad(luv, ((0, 0), (1, 1), (1, 1)), mode="edge")
    gx = (padded[:, 1:-1, 2:] - padded[:, 1:-1, :-2]) / 2
    gy = (padded[:, 2:, 1:-1] - padded[:, :-2, 1:-1]) / 2
    strongest = np.hypot(gx, gy).argmax(axis=0)[None]
    gx, gy = np.take_along_axis(gx, strongest, 0)[0], np.take_along_axis(gy, strongest, 0)[0]
    magnitude = np.hypot(gx, gy)
    magnitude /= _separable(magnitude[None], np.array([1, 2, 3, 4, 5, 6, 5, 4, 3, 2, 1]) / 36)[0] + 0.005
    position = np.arctan2(gy, gx) % np.pi / (np.pi / 6)
    channels = [*luv, magnitude]
    for k in range(6):
        away = np.abs(position - k)
        channels.append(magnitude * np.clip(1 - np.minimum(away, 6 - away), 0, None))
    cells = np.stack(channels).reshape(10, rows, 4, columns, 4).mean(axis=(2, 4))
    return _separable(cells, [1 / 4, 2 / 4, 1 / 4])


def _separable(planes: Floats, weights: list[float] | Floats) -> Floats:
    smooth = ndimage.convolve1d(planes, weights, axis=1, mode="nearest")
    return ndimage.convolve1d(smooth, weights, axis=2, mode="nearest")


def stored(channels: Floats) -> Floats:
    """The values as stored, before they are rounded."""
    scaled = np.sqrt(channels) * 200
    scaled[0] = channels[0] * 255 * 2.7
    scaled[1] = 112 + 510 * (channels[1] - 88 / 270)
    scaled[2] = 112 + 510 * (channels[2] - 134 / 270)
    return np.clip(scaled, 0, 255)


def random_picture(height: int, width: int, seed: int = 0) -> NDArray[np.uint8]:
    """Blobs of all sizes in all colours."""
    noise = np.random.default_rng(seed).normal(size=(height, width, 3))
    picture = sum(ndimage.gaussian_filter(noise, (s, s, 0)) * s for s in (0.7, 3, 12))
    return np.clip(128 + 60 * np.asarray(picture), 0, 255).astype(np.uint8)


def correlations(channels: NDArray[np.uint8] | Floats, expected: Floats) -> list[float]:
    return [float(np.corrcoef(a.ravel(), b.ravel())[0, 1]) for a, b in zip(channels, expected, strict=True)]


def assert_agreement(picture: NDArray[np.uint8]):
    """Correlation of each channel with the definition: 0.999 but for the rounding, 0.98 as stored.

    The kernel's values leave it rounded to 256 steps; the definition's are rounded alike for the first
    comparison, where only a difference of the values themselves can then show.
    """
    reference = reference_channels(picture)
    channels = compute_channels(picture)
    assert min(correlations(channels, np.rint(stored(reference)))) >= 0.999
    # The square root undone: the channels themselves.
    linear = channels.astype(np.float64)
    linear[3:] **= 2
    assert min(correlations(linear, reference)) >= 0.98


def test_kernel_agrees_with_the_definition_on_a_random_picture():
    picture = random_picture(121, 187)
    channels = compute_channels(picture)
    expected = stored(reference_channels(picture))
    assert channels.shape == (10, 30, 46)
    assert np.abs(channels - expected).max() < 1.5
    assert np.abs(channels - expected).mean() < 0.3
    assert_agreement(picture)


@pytest.mark.parametrize("name", ["kitti-sfnd/images", "labels/images/solidWhiteRight", "tusimple/images"])
def test_kernel_agrees_with_the_definition_on_real_frames(data_dir: Path, name: str):
    path = min((data_dir / name).iterdir())
    assert_agreement(np.asarray(cv2.imread(str(path)), np.uint8))


@pytest.mark.parametrize(
    ("bgr", "luv"),
    [
        # sRGB primaries' white in the toolbox's matrix is L = 100 with u = v = 0; black is L = 0.
        ((255, 255, 255), (100.0, 0.0, 0.0)),
        ((0, 0, 0), (0.0, 0.0, 0.0)),
        # Half grey without undoing gamma: Y = 128/255, L = 116 Y^(1/3) - 16.
        ((128, 128, 128), (76.189, 0.0, 0.0)),
        ((0, 64, 192), None),
    ],
)
def test_uniform_colours_have_known_luv_and_no_gradient(
    bgr: tuple[int, int, int], luv: tuple[float, float, float] | None
):
    picture = np.full((16, 16, 3), bgr, np.uint8)
    channels = compute_channels(picture)
    assert (channels == channels[:, :1, :1]).all()
    assert not channels[3:].any()
    if luv is not None:
        assert channels[0, 0, 0] == pytest.approx(luv[0] * 2.55, abs=0.6)
        # The matrix is rounded: grey lies within half a step of (0, 0).
        assert channels[1, 0, 0] == pytest.approx(112 + luv[1] * 510 / 270, abs=1)
        assert channels[2, 0, 0] == pytest.approx(112 + luv[2] * 510 / 270, abs=1)
    else:
        assert channels[1, 0, 0] > 120  # towards red


@pytest.mark.parametrize("bin_index", range(6))
def test_gratings_fall_into_the_orientation_of_their_gradient(bin_index: int):
    angle = bin_index * np.pi / 6
    v, u = np.mgrid[:64, :64]
    wave = 128 + 100 * np.sin((u * np.cos(angle) + v * np.sin(angle)) * 0.5)
    channels = compute_channels(np.repeat(np.rint(wave).astype(np.uint8)[..., None], 3, axis=2))
    inner = channels[4:, 4:-4, 4:-4].astype(np.float64).mean(axis=(1, 2))
    assert inner.argmax() == bin_index
    assert inner[bin_index] > 2 * np.delete(inner, bin_index).max()


def test_a_band_of_rows_equals_those_rows_of_the_whole_picture():
    picture = random_picture(160, 100)
    computer = ChannelComputer(ImageSize(100, 160))
    whole = computer.compute(picture)
    for first, end in [(0, 1), (0, 40), (5, 17), (39, 40), (30, 40)]:
        np.testing.assert_array_equal(computer.compute(picture, first, end), whole[:, first:end])


def test_a_crop_with_its_context_gives_the_values_of_the_whole_picture():
    picture = random_picture(240, 320)
    margin = -(-CONTEXT_PX // 4)
    crop = compute_channels(np.ascontiguousarray(picture[40:160, 80:240]))
    whole = compute_channels(picture)[:, 10:40, 20:60]
    inner = slice(margin, -margin)
    difference = crop[:, inner, inner].astype(int) - whole[:, inner, inner]
    # Vectorised and scalar code may round the last bit of a float differently.
    assert np.abs(difference).max() <= 1
    assert (difference != 0).mean() < 1e-3


def test_computing_again_gives_the_same_whatever_came_before():
    picture = random_picture(64, 96)
    computer = ChannelComputer(ImageSize(96, 64))
    first = computer.compute(picture)
    computer.compute(random_picture(64, 96, seed=1), 3, 9)
    np.testing.assert_array_equal(computer.compute(picture), first)


def test_writes_into_the_given_array():
    picture = random_picture(64, 96)
    computer = ChannelComputer(ImageSize(96, 64))
    padded = np.zeros((10, 20, 30), np.uint8)
    computer.compute(picture, out=padded[:, 2:18, 3:27])
    np.testing.assert_array_equal(padded[:, 2:18, 3:27], computer.compute(picture))
    assert not padded[:, :2].any()
    assert not padded[:, :, :3].any()


def test_wrong_pictures_and_rows_are_refused():
    computer = ChannelComputer(ImageSize(96, 64))
    with pytest.raises(ValueError, match="96x64"):
        computer.compute(np.zeros((96, 64, 3), np.uint8))
    with pytest.raises(ValueError, match="uint8"):
        computer.compute(np.zeros((64, 96, 3), np.float32))  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="rows"):
        computer.compute(np.zeros((64, 96, 3), np.uint8), 10, 17)
    with pytest.raises(ValueError, match="shape"):
        computer.compute(np.zeros((64, 96, 3), np.uint8), out=np.zeros((10, 3, 3), np.uint8))
    with pytest.raises(ValueError, match="smaller than one cell"):
        compute_channels(np.zeros((3, 3, 3), np.uint8))
