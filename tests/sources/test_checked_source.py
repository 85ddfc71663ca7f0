"""A source of one's own: what it gives is a picture of its size, or one message says what is wrong."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import fcw
from fcw.frame import DatedSource
from fcw.sources.checked import CheckedSource

SIZE = fcw.ImageSize(64, 48)
PICTURE = np.full((48, 64, 3), 99, np.uint8)


class Mine:
    """Three pictures, the last one changed."""

    name, image_size, frame_count, frame_rate_hz, relays_video, notes = "mine", SIZE, 3, 25.0, False, ()

    def __init__(self, change: Callable[[Any], Any] = lambda image: image, time_ns: Any = 80_000_000) -> None:
        self._change, self._time_ns = change, time_ns

    def frames(self, start_ns: int | None = None):
        for index in range(2):
            yield fcw.Frame(index, index * 40_000_000, PICTURE)
        yield fcw.Frame(2, self._time_ns, self._change(PICTURE))


class Dated(Mine):
    zero_utc_ns = 1_760_000_000_000_000_000


def test_pictures_of_the_size_are_passed_on() -> None:
    source = CheckedSource(Mine(lambda image: image[:, ::-1], np.int64(80_000_000)))
    assert [frame.index for frame in source.frames()] == [0, 1, 2]
    assert (source.name, source.image_size, source.frame_count) == ("mine", SIZE, 3)


def test_it_knows_when_the_drive_was_where_the_source_does() -> None:
    for source, zero_utc_ns in ((Mine(), None), (Dated(), Dated.zero_utc_ns)):
        checked = CheckedSource(source)
        assert isinstance(checked, DatedSource)
        assert checked.zero_utc_ns == zero_utc_ns


@pytest.mark.parametrize(
    ("change", "came"),
    [
        (lambda image: image[::2, ::2], "a picture of the shape (24, 32, 3) of uint8"),
        (lambda image: np.dstack([image, image[..., :1]]), "a picture of the shape (48, 64, 4) of uint8"),
        (lambda image: image[..., 0], "a picture of the shape (48, 64) of uint8"),
        (lambda image: image / np.float32(255), "a picture of the shape (48, 64, 3) of float32"),
        (lambda image: image.astype(np.uint16), "a picture of the shape (48, 64, 3) of uint16"),
    ],
)
def test_what_is_no_picture_of_the_size_is_named_with_its_frame(change: Any, came: str) -> None:
    frames = CheckedSource(Mine(change)).frames()
    assert [next(frames).index, next(frames).index] == [0, 1]
    with pytest.raises(fcw.UserError) as raised:
        next(frames)
    expected = "(48, 64, 3) of uint8, which is BGR of the source's image_size 64x48"
    assert str(raised.value) == f"source 'mine', frame 2: {came}; expected {expected}"


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (Mine(lambda image: None), "frame 2: a picture of the type NoneType; expected an array of NumPy"),
        (Mine(time_ns=0.08), "frame 2: the time 0.08; expected nanoseconds in a whole number"),
        (Mine(time_ns=0), "frame 2: the time 0 ns; expected 40000000, as of the frame before, or later"),
    ],
)
def test_what_is_no_array_or_no_time_is_named(source: Mine, message: str) -> None:
    with pytest.raises(fcw.UserError, match=f"source 'mine', {message}"):
        list(CheckedSource(source).frames())
