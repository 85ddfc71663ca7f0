"""Where a GPX track was at a moment."""

import pytest

from fcw.bounded.gpx import GpxTrack

TRACK = GpxTrack(0.0, (0.0, 2.0, 6.0), ((48.0, 179.9), (48.2, -179.9), (48.2, -179.5)), (None, None, None))
"""Over the date line."""


@pytest.mark.parametrize(
    ("time_s", "place"),
    [
        (0.0, (48.0, 179.9)),
        (0.5, (48.05, 179.95)),
        (1.5, (48.15, -179.95)),
        (2.0, (48.2, -179.9)),
        (5.0, (48.2, -179.6)),
        (6.0, (48.2, -179.5)),
    ],
)
def test_between_two_points_it_was_on_the_line(time_s: float, place: tuple[float, float]):
    assert TRACK.place_at(time_s) == pytest.approx(place, abs=1e-9)


@pytest.mark.parametrize("time_s", [-0.1, 6.1, float("nan")])
def test_before_its_first_and_after_its_last_point_nothing_is_known(time_s: float):
    assert TRACK.place_at(time_s) is None
