"""Which parts of a picture a glance is shown, by the calibration."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.net.bands import FINER, SHOWN, SIDES_PX, bands_of, whole
from fcw.errors import UserError
from fcw.frame import ImageSize

CAMERA = GroundPlaneCamera(0.02, 1000.0, 359.5, 1.3, 639.5)
SIZE = ImageSize(1280, 720)


@given(st.integers(160, 4000), st.integers(120, 2200))
def test_the_whole_picture_is_shown_in_nearly_its_shape_with_about_as_many_pixels(width, height):
    if not 1 / 2 <= width / height <= 4:
        return
    shown = whole(ImageSize(width, height)).shown
    assert shown.width % SIDES_PX == shown.height % SIDES_PX == 0
    assert 0.6 <= shown.width * shown.height / (SHOWN.width * SHOWN.height) <= 1.6
    assert 0.75 <= shown.width / shown.height / (width / height) <= 1.34


@given(
    st.sampled_from([(640, 360), (1280, 720), (1242, 375), (1920, 1080), (800, 600), (3840, 2160)]),
    st.floats(-0.08, 0.15),
    st.floats(0.7, 2.0),
    st.floats(0.9, 3.0),
    st.floats(0.0, 0.05),
)
def test_a_band_has_the_rows_of_every_car_that_it_is_there_for(size, pitch, focal, height_m, tolerance):
    picture = ImageSize(*size)
    focal_px = focal * picture.height
    camera = GroundPlaneCamera(pitch, focal_px, (picture.height - 1) / 2, height_m, picture.width / 2)
    everything, *finer = bands_of(picture, camera, tolerance, largest_scale=100.0)
    assert everything.is_cut == ((False, False), (False, False))
    for band, (by, largest_px) in zip(finer, list(FINER.items())[: len(finer)], strict=True):
        # Whole columns and rows are cut.
        rounding = [0.51 * 2**band.level / shown for shown in (band.shown.width, band.shown.height)]
        assert abs(band.scale[0] - everything.scale[0] / by) <= (rounding[0] if by == max(FINER) else 1e-9)
        assert abs(band.scale[1] - everything.scale[1] / by) <= rounding[1]
        _, top_px = band.corner_px
        end_px = top_px + band.shown.height * band.scale[1]
        assert -1e-6 <= top_px < end_px <= picture.height + 1e-6
        size_px = largest_px * everything.scale[1] / by
        for pitch_error in (-tolerance, tolerance):
            horizon = camera.horizon_row_px - focal_px * math.tan(pitch_error)
            bottom = horizon + size_px * height_m / 1.6  # a car of 1.6 m, sqrt(w h)
            for row in (bottom, bottom - 0.9 * size_px):
                if 0 <= row <= picture.height - 1:
                    # Cut rows are whole ones of the level, and the tangents of sums are not sums of tangents.
                    assert top_px - 0.03 * picture.height <= row <= end_px + 0.03 * picture.height


def test_the_finer_a_band_the_nearer_to_the_horizon():
    everything, middle, far = bands_of(SIZE, CAMERA, math.radians(1.0), 2.0)
    horizon = CAMERA.horizon_row_px
    for outer, inner in ((everything, middle), (middle, far)):
        (_, outer_top), (_, inner_top) = outer.corner_px, inner.corner_px
        outer_end = outer_top + outer.shown.height * outer.scale[1]
        assert outer_top <= inner_top < horizon
        assert horizon < inner_top + inner.shown.height * inner.scale[1] <= outer_end


def test_a_camera_that_is_less_known_is_shown_in_higher_bands():
    sure, unsure = (bands_of(SIZE, CAMERA, math.radians(deg), 2.0) for deg in (0.5, 3.0))
    for one, other in zip(sure[1:], unsure[1:], strict=True):
        assert other.shown.height > one.shown.height


@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080), (3840, 2160)])
@pytest.mark.parametrize(("view_deg", "count"), [(60, 3), (67, 4), (104, 4)])
@pytest.mark.parametrize("looks_aside_deg", [0, 10])
def test_through_a_wide_lens_a_band_more_shows_what_is_far_and_hardly_aside(
    size, view_deg, count, looks_aside_deg
):
    picture = ImageSize(*size)
    focal_px = picture.width / 2 / math.tan(math.radians(view_deg) / 2)
    ahead_px = picture.width / 2 + focal_px * math.tan(math.radians(looks_aside_deg))
    camera = GroundPlaneCamera(0.02, focal_px, (picture.height - 1) / 2, 1.3, ahead_px)
    _, *finer = bands_of(picture, camera, math.radians(1.0), 2.0)
    assert len(finer) == count - 1
    for band in finer[:2]:
        assert band.corner_px[0] == 0.0
        assert band.shown.width * band.scale[0] == pytest.approx(picture.width)
    assert 1.4 * focal_px / 60.0 / finer[-1].scale[0] >= 16.0  # a small car 60 m away, sqrt(w h)
    for band in finer[2:]:
        left_px = band.corner_px[0]
        end_px = left_px + band.shown.width * band.scale[0]
        for aside_m in (-20.0, 20.0):
            column_px = ahead_px + focal_px * aside_m / 60.0
            assert left_px - band.scale[0] <= min(column_px, picture.width) <= end_px + band.scale[0]
        assert end_px - left_px <= 0.6 * picture.width


@pytest.mark.parametrize(("sigma_part", "count"), [(0.0, 3), (0.05, 3), (0.3, 4), (7.0, 4), (math.nan, 4)])
def test_what_a_lens_of_60_degrees_has_not_one_that_may_be_far_wider_has(sigma_part, count):
    camera = GroundPlaneCamera(0.02, 640.0 / math.tan(math.radians(30.0)), 359.5, 1.3, 639.5)
    _, *finer = bands_of(SIZE, camera, 0.01, 2.0, sigma_part * camera.focal_y_px)
    assert len(finer) == count - 1
    for band in finer[2:]:  # what is 20 m aside and 60 m away, if it is
        columns = band.shown.width * band.scale[0]
        aside_px = max(0.5, 1 - sigma_part) * camera.focal_y_px * 20.0 / 60.0
        assert 2 * aside_px <= columns < 2 * aside_px + 32 * band.scale[0]


def test_small_pictures_are_not_enlarged_beyond_what_is_asked():
    small = ImageSize(320, 180)
    camera = GroundPlaneCamera(0.02, 250.0, 89.5, 1.3, 159.5)
    assert [band.shown.width for band in bands_of(small, camera, 0.01, 2.0)] == [224, 448]
    assert [band.shown.width for band in bands_of(small, camera, 0.01, 1.0)] == [224]


@pytest.mark.parametrize("pitch_rad", [-1.2, 1.2])
def test_a_camera_that_sees_no_road_ahead_is_refused(pitch_rad):
    camera = GroundPlaneCamera(pitch_rad, 1000.0, 359.5, 1.3, 639.5)
    with pytest.raises(UserError, match="horizon in row"):
        bands_of(SIZE, camera, math.radians(1.0), 2.0)


def test_a_road_that_may_be_in_the_picture_is_looked_for():
    # Its farthest rows begin 5 px below the picture, and 1 degree of pitch is 17 px.
    below = GroundPlaneCamera(0.0, 1000.0, 719.5 - 1000.0 * 1.3 / 80.0 + 5.0, 1.3, 639.5)
    assert len(bands_of(SIZE, below, math.radians(1.0), 2.0)) == 3
    with pytest.raises(UserError, match="horizon in row"):
        bands_of(SIZE, below, math.radians(0.1), 2.0)
