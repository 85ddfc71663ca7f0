"""Which windows are looked at: those where a vehicle of plausible size can stand, and all of those."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from searching import examples

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.boxes.overlap import intersection_over_union
from fcw.detection.model import VehicleStatistics, Window
from fcw.detection.windows.plan import DistancePrior, Level, full_levels, prior_levels
from fcw.frame import ImageSize

WINDOW = Window()
STATISTICS = VehicleStatistics(0.9, 2.1, 4.5, (6.0, 10.0, 25.0, 40.0), (1.6, 1.5, 1.4, 1.2))
NEAREST_M, FARTHEST_M, TOLERANCE_RAD = 4.0, 80.0, math.radians(1.0)
LARGEST_SCALE = 2.4

SIZES = [ImageSize(1280, 720), ImageSize(640, 360), ImageSize(1242, 375), ImageSize(854, 480)]


@st.composite
def mounted_cameras(draw: st.DrawFn) -> tuple[GroundPlaneCamera, ImageSize]:
    """Dash cameras of 45 to 100 degrees that see the horizon."""
    size = draw(st.sampled_from(SIZES))
    focal_px = draw(st.floats(0.42, 1.2)) * size.width
    principal_row = size.height / 2 + draw(st.floats(-0.05, 0.05)) * size.height
    pitch = draw(st.floats(-0.08, 0.12))
    camera = GroundPlaneCamera(
        pitch, focal_px, principal_row, draw(st.floats(1.0, 2.2)), (size.width - 1) / 2
    )
    assume(0.1 * size.height < camera.horizon_row_px < 0.8 * size.height)
    return camera, size


def prior_of(camera: GroundPlaneCamera) -> DistancePrior:
    return DistancePrior(camera, STATISTICS, NEAREST_M, FARTHEST_M, TOLERANCE_RAD)


def levels_of(camera: GroundPlaneCamera, size: ImageSize) -> tuple[Level, ...]:
    return prior_levels(size, WINDOW, prior_of(camera), 4, LARGEST_SCALE)


def vehicles_of(level: Level) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Column of the middle, bottom row and size of the vehicle in each of a level's windows."""
    rows = np.arange(level.first_window, level.end_window)
    rows, columns = np.meshgrid(rows, np.arange(level.window_columns), indexing="ij")
    middles, bottoms, size_px = level.vehicles(WINDOW, rows.ravel(), columns.ravel())
    return middles, bottoms, np.full(level.window_count, size_px)


@examples(60)
@given(mounted_cameras())
def test_every_window_holds_a_vehicle_of_plausible_size_for_some_pitch_within_the_tolerance(
    setup: tuple[GroundPlaneCamera, ImageSize],
):
    camera, size = setup
    levels = levels_of(camera, size)
    assert levels
    # The horizon of a camera pitched by d more is f tan(d) or more higher, as far as it is off the axis.
    horizons = [
        camera.principal_row_px + camera.focal_y_px * math.tan(sign * TOLERANCE_RAD - camera.pitch_rad)
        for sign in (-1, 1)
    ]
    for level in levels:
        _, bottoms, sizes_px = vehicles_of(level)
        assert len(bottoms) == level.window_count
        assert (bottoms <= size.height - 0.5 + 1e-9).all()
        # The height seen under the pitch most in favour must not be too small, nor too large.
        smallest_m = sizes_px * camera.height_m / (bottoms - horizons[0])
        below = bottoms - horizons[1]
        largest_m = np.divide(
            sizes_px * camera.height_m, below, out=np.full(len(below), math.inf), where=below > 0
        )
        # The two axes' cells differ by rounding: sqrt(w h) of the windows is up to 3 % off the planned size.
        assert (smallest_m <= 1.03 * STATISTICS.size_high_m).all()
        assert (largest_m >= STATISTICS.size_low_m / 1.03).all()


@examples(60)
@given(mounted_cameras(), st.floats(5, 60), st.floats(-6, 6))
def test_every_vehicle_of_median_size_on_the_road_has_a_window(
    setup: tuple[GroundPlaneCamera, ImageSize], distance_m: float, lateral_m: float
):
    camera, size = setup
    aspect = float(STATISTICS.aspect_ratio(distance_m))
    bottom = camera.row_at(distance_m)
    size_px = STATISTICS.size_median_m * (bottom - camera.horizon_row_px) / camera.height_m
    w, h = size_px * math.sqrt(aspect), size_px / math.sqrt(aspect)
    middle = float(camera.column_at(lateral_m, distance_m))
    assume(middle - w / 2 >= 0 and middle + w / 2 <= size.width - 1)
    assume(bottom - h >= 0 and bottom <= size.height - 1)
    assume(size_px >= WINDOW.vehicle_size_px / LARGEST_SCALE)
    box = np.array([[middle - w / 2, bottom - h, w, h]])
    best = 0.0
    for level in levels_of(camera, size):
        x, y, sizes_px = vehicles_of(level)
        ratio = np.sqrt(prior_of(camera).aspect_ratios(y))
        windows = np.column_stack(
            [x - sizes_px * ratio / 2, y - sizes_px / ratio, sizes_px * ratio, sizes_px / ratio]
        )
        best = max(best, float(intersection_over_union(windows, box).max()))
    # Steps of a cell (a tenth of the vehicle) and of 19 % in scale: the worst of both together.
    assert best >= 0.7


@examples(40)
@given(mounted_cameras())
def test_windows_stay_within_the_padded_picture(setup: tuple[GroundPlaneCamera, ImageSize]):
    camera, size = setup
    for level in (*levels_of(camera, size), *full_levels(size, WINDOW, 8, 1.0)):
        assert 0 <= level.first_window < level.end_window <= level.rows - WINDOW.cells + 1
        assert level.window_columns == level.columns - WINDOW.cells + 1 >= 1


def test_the_prior_looks_at_a_small_part_of_what_plain_acf_looks_at():
    # The notes' 51,800 windows of 19 scales over 4 to 80 m against some 300,000 of 28.
    camera = GroundPlaneCamera(0.05, 900.0, 360.0, 1.3, 639.5)
    size = ImageSize(1280, 720)
    prior = [level for level in levels_of(camera, size) if level.octave <= 0]
    full = full_levels(size, WINDOW, 8, 1.0)
    assert sum(level.window_count for level in prior) < sum(level.window_count for level in full) / 5


def test_plain_acf_has_28_scales_over_the_whole_picture():
    # 8 an octave from 64 px windows up to the picture's 720 rows: floor(8 log2(720 / 64)) + 1.
    levels = full_levels(ImageSize(1280, 720), WINDOW, 8, 1.0)
    assert len(levels) == 28
    for level in levels:
        middles, bottoms, sizes_px = vehicles_of(level)
        # A vehicle flush with the picture's left and right edge, and with its lower one, is looked at.
        step = sizes_px[0] / 10
        for edge, at in ((middles.min(), -0.5), (1279.5 - middles.max(), 0.0)):
            assert edge <= at + sizes_px[0] * 0.6 + step
        assert bottoms.max() >= 719.5 - 2 * step


def test_an_enlarged_octave_is_used_for_far_vehicles_only():
    camera = GroundPlaneCamera(0.05, 900.0, 360.0, 1.3, 639.5)
    levels = levels_of(camera, ImageSize(1280, 720))
    scales = [4 / math.sqrt(math.prod(level.cell_px)) for level in levels]
    assert scales == sorted(scales, reverse=True)
    assert scales[0] == pytest.approx(2 ** (5 / 4), rel=0.02)
    assert {1, 0, -1, -2} <= {level.octave for level in levels}
    for level, scale in zip(levels, scales, strict=True):
        assert 0.69 < scale / 2.0**level.octave < 1.22


def test_a_steady_camera_looks_at_fewer_rows_than_a_shaking_one():
    camera = GroundPlaneCamera(0.05, 900.0, 360.0, 1.3, 639.5)
    counts = [
        sum(
            level.window_count
            for level in prior_levels(
                ImageSize(1280, 720),
                WINDOW,
                DistancePrior(camera, STATISTICS, NEAREST_M, FARTHEST_M, math.radians(degrees)),
                4,
                LARGEST_SCALE,
            )
        )
        for degrees in (0, 1, 2)
    ]
    assert counts[0] < counts[1] < counts[2]


def test_aspect_ratio_follows_the_distance_and_stays_that_of_the_limits_beyond():
    camera = GroundPlaneCamera(0.05, 900.0, 360.0, 1.3, 639.5)
    rows = np.array([camera.row_at(6.0), camera.row_at(25.0), camera.horizon_row_px - 5])
    np.testing.assert_allclose(prior_of(camera).aspect_ratios(rows), [1.6, 1.4, 1.2])
