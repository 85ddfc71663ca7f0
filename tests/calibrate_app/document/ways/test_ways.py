"""Every way of the first screen leads to a calibration, and says of itself what the calibration says."""

import math
from dataclasses import replace

import numpy as np
import pytest
from session_helpers import SIZE

from fcw.camera.uncertainty import relative_errors
from fcw_viz.calibrate_app.document.document import Document, Line
from fcw_viz.calibrate_app.document.edits import AddMark
from fcw_viz.calibrate_app.document.solution import calibration_of, solve
from fcw_viz.calibrate_app.document.state import Status
from fcw_viz.calibrate_app.document.ways.height import TYPICAL_HEIGHTS
from fcw_viz.calibrate_app.document.ways.ways import CLIP, TAPE, TYPICAL_LENSES, WAYS, Way, chosen_way
from fcw_viz.calibrate_app.panels.way import typical_error

AT_M = np.array([10.0, 20.0, 40.0])


@pytest.mark.parametrize("way", WAYS, ids=lambda way: way.key)
def test_what_a_way_asks_for_is_enough(way: Way):
    assert solve(way.example(SIZE)).status in (Status.GOOD, Status.DOUBTFUL)
    assert 0 < typical_error(way, SIZE) < 0.3


@pytest.mark.parametrize("way", WAYS, ids=lambda way: way.key)
def test_choosing_a_way_loses_nothing_that_was_said(way: Way):
    document = AddMark(600.0, 500.0, 0, 8.0).apply(Document(SIZE, height_m=1.3))
    for edit in way.start(document):
        document = edit.apply(document)
    assert chosen_way(document) is way
    assert (document.height_m, [mark.distance_m for mark in document.marks]) == (1.3, [8.0])


def test_whoever_clicks_without_choosing_has_taped_points():
    assert chosen_way(Document(SIZE)) is None
    way = chosen_way(AddMark(600.0, 500.0).apply(Document(SIZE)))
    assert way is not None
    assert way.key == TAPE


def test_without_points_distances_are_proportional_to_the_height_and_so_is_their_error():
    example = next(way for way in WAYS if way.key == CLIP).example(SIZE)
    assert example.height_m is not None
    sure = calibration_of(replace(example, height_sigma_m=None))
    unsure = calibration_of(replace(example, height_sigma_m=0.13))
    assert sure is not None
    assert unsure is not None
    expected = np.hypot(relative_errors(sure, AT_M), 0.13 / example.height_m)
    assert relative_errors(unsure, AT_M) == pytest.approx(expected, rel=0.01)
    assert unsure.camera == sure.camera


def test_with_taped_points_the_height_moves_no_distance():
    example = next(way for way in WAYS if way.key == TAPE).example(SIZE)
    sure, unsure = calibration_of(example), calibration_of(replace(example, height_sigma_m=0.13))
    assert sure is not None
    assert unsure is not None
    # But for the field of view that every lens has, which takes part a little.
    assert relative_errors(unsure, AT_M) == pytest.approx(relative_errors(sure, AT_M), rel=0.01)


def test_the_interval_of_a_clip_without_a_tape_holds_its_errors():
    """Draws of height, lens and horizon, each as uncertain as was said, through the exact projection."""
    example = next(way for way in WAYS if way.key == CLIP).example(SIZE)
    calibration = calibration_of(example)
    view, horizon = example.field_of_view, example.horizon
    assert calibration is not None
    assert view is not None
    assert horizon is not None
    assert example.height_m is not None
    assert example.height_sigma_m is not None
    generator = np.random.default_rng(7)
    row_px = calibration.row_at(25.0)
    draws = 4000
    height_m = generator.normal(example.height_m, example.height_sigma_m, draws)
    focal_px = SIZE.width / 2 / np.tan(generator.normal(view.prior.value, view.prior.sigma, draws) / 2)
    horizon_px = generator.normal(horizon.prior.value, horizon.prior.sigma, draws)
    # Near the horizon the pitch of two degrees is of no account: v - horizon = f h / d.
    distances_m = height_m * focal_px / (row_px - horizon_px)
    low_m, high_m = calibration.distance_interval(row_px)
    assert np.mean((distances_m > low_m) & (distances_m < high_m)) == pytest.approx(0.68, abs=0.05)


def test_a_clip_is_told_what_is_missing_step_by_step_and_lane_lines_do_for_the_horizon():
    (way,) = (way for way in WAYS if way.key == CLIP)
    whole, document = way.example(SIZE), Document(SIZE)
    for edit in way.start(document):
        document = edit.apply(document)
    hints = [solve(document).hint]
    document = replace(document, height_m=whole.height_m, height_sigma_m=whole.height_sigma_m)
    hints.append(solve(document).hint)
    document = replace(document, field_of_view=whole.field_of_view)
    hints.append(solve(document).hint)
    for hint, words in zip(hints, ("camera's height", "field of view", "the horizon"), strict=True):
        assert words in hint
    lines = (Line((300.0, 700.0), (600.0, 360.0)), Line((979.0, 700.0), (679.0, 360.0)))
    assert solve(replace(document, lane_lines=lines)).status is Status.GOOD
    assert solve(replace(document, horizon=whole.horizon)).status is Status.GOOD


def test_guesses_are_less_sure_than_measurements():
    assert all(typical.sigma_m / typical.height_m > 0.05 for typical in TYPICAL_HEIGHTS)
    assert all(lens.sigma_rad > math.radians(3) for lens in TYPICAL_LENSES)
