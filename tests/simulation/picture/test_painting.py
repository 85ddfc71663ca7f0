"""The painter's tools keep to geometry: cover is area, colours blend, and dashes are integrated exactly."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fcw.simulation.picture.canvas import Canvas
from fcw.simulation.picture.light import Daylight
from fcw.simulation.picture.quads import Texture, paint_quad
from fcw.simulation.picture.road.kernel import _bump, _dash_cover, _overlap
from fcw.simulation.picture.vehicles.rears import rear_texture
from fcw.simulation.world.state import VehicleKind


def white(rows: int = 64, columns: int = 64) -> Texture:
    image = np.ones((rows, columns, 4), np.float32)
    image[..., :3] = 200
    return Texture(image)


def area(corners: np.ndarray) -> float:
    x, y = corners.T
    return abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2


def test_a_canvas_covers_as_many_square_metres_as_are_filled():
    canvas = Canvas(2.0, 1.0)
    canvas.rectangle(-0.731, 0.113, 0.402, 0.887, (10, 20, 30))
    finished = canvas.finished()
    cell_m2 = 2.0 * 1.0 / (finished.shape[0] * finished.shape[1])
    assert finished[..., 3].sum() * cell_m2 == pytest.approx(1.133 * 0.774, rel=0.01)
    # Premultiplied: also at its edges the colour is the one that was asked for.
    shown = finished[..., 3] > 0.01
    np.testing.assert_allclose(
        finished[shown][:, :3] / finished[shown][:, 3:], [[10, 20, 30]] * shown.sum(), atol=0.1
    )


def test_shade_is_interpolated_between_its_heights():
    canvas = Canvas(1.0, 1.0)
    canvas.rectangle(-0.5, 0.0, 0.5, 1.0, (100, 100, 100), ((0.0, 0.5), (1.0, 1.5)))
    column = canvas.finished()[:, 80, 0]
    assert column[0] == pytest.approx(150, abs=1)
    assert column[-1] == pytest.approx(50, abs=1)
    assert column[80] == pytest.approx(100, abs=1)


@given(
    corner=st.tuples(st.floats(10, 40), st.floats(10, 40)),
    size=st.tuples(st.floats(3, 70), st.floats(3, 70)),
    skew=st.floats(-4, 4),
)
@example(corner=(10.3125, 10.3125), size=(11.375, 11.34375), skew=0.0)
def test_a_quad_covers_its_area(corner, size, skew):
    (x, y), (w, h) = corner, size
    corners = np.array([(x, y), (x + w, y + skew / 4), (x + w, y + h), (x, y + h - skew / 4)])
    image = np.zeros((128, 128, 3), np.float32)
    paint_quad(image, white(), corners)
    # An edge is soft over a texel of 0.7 to 1 px. Seen once a pixel, it is off by half of what that lacks of
    # a pixel at most: 0.15 px.
    assert image[..., 0].sum() / 200 == pytest.approx(area(corners), rel=0.02, abs=2 * 0.15 * (w + h))
    inside = image[int(y + 4) : int(y + h - 4), int(x + 4) : int(x + w - 4)]
    assert inside.size == 0 or inside == pytest.approx(200, abs=0.01)


def test_haze_and_light_blend_as_they_should():
    image = np.zeros((20, 20, 3), np.float32)
    corners = np.array([(-5.0, -5.0), (25, -5), (25, 25), (-5, 25)])
    paint_quad(image, white(), corners, light=0.5, clarity=0.75, haze=(220.0, 200.0, 180.0))
    np.testing.assert_allclose(image[10, 10], (0.75 * 100 + 0.25 * np.array((220, 200, 180))), atol=0.01)


def test_nothing_is_painted_below_the_lowest_row():
    image = np.zeros((40, 40, 3), np.float32)
    paint_quad(image, white(), np.array([(5.0, 5.0), (35, 5), (35, 35), (5, 35)]), lowest_row_px=20.0)
    assert image[21:].sum() == 0
    assert image[18, 20, 0] > 0


@given(
    position=st.floats(0, 200),
    foot=st.floats(0.01, 60),
    dash=st.floats(0.5, 6),
    gap=st.floats(0.5, 9),
)
def test_dashes_are_averaged_over_what_a_pixel_sees(position, foot, dash, gap):
    period = dash + gap
    samples = position + foot * ((np.arange(20_000) + 0.5) / 20_000 - 0.5)
    expected = np.mean(samples % period < dash)
    assert _dash_cover(position, foot, dash, period) == pytest.approx(expected, abs=2e-3)


def test_overlap_is_the_common_part_of_two_intervals():
    assert _overlap(0.0, 0.1, 0.0, 0.05) == pytest.approx(1)
    assert _overlap(0.0, 0.1, 0.1, 0.1) == pytest.approx(0.5)
    assert _overlap(0.0, 0.1, 0.5, 0.1) == 0


def test_wheel_tracks_fade_out_smoothly():
    assert _bump(0.0) == 1
    assert _bump(1.0) == _bump(-3.0) == 0
    assert _bump(0.5) == _bump(-0.5) == pytest.approx(0.75**2)


@pytest.mark.parametrize("kind", VehicleKind)
def test_rears_touch_all_four_sides_of_their_picture(kind):
    """The true box is drawn around the body's measures: there must be body up to them."""
    cover = rear_texture(kind, (90, 90, 90), 1, braking=False)[..., 3]
    height, width = cover.shape
    margin = 0.01
    rows, columns = np.flatnonzero(cover.max(axis=1) > 0.5), np.flatnonzero(cover.max(axis=0) > 0.5)
    assert rows[0] <= margin * height
    assert rows[-1] == height - 1
    assert columns[0] <= margin * width
    assert columns[-1] >= (1 - margin) * width - 1


@given(seed=st.integers(0, 2**32 - 1))
def test_daylight_of_any_seed_is_one_that_a_camera_could_see(seed):
    light = Daylight.drawn(np.random.default_rng(seed))
    for color in (
        light.zenith,
        light.haze,
        light.asphalt,
        light.gravel,
        light.grass,
        light.dry_grass,
        light.paint,
    ):
        assert all(0 < channel < 256 for channel in color)
    assert sum(light.paint) > 1.8 * sum(light.asphalt)  # markings stand out
    assert 0 < light.shadow < 1
    assert 0.7 < light.rear_light < 1.2
