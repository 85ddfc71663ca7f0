"""What follows from a document: status, result, effects of beliefs."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from session_helpers import CAMERA, PAPER_POINTS, SIZE, mended, only_trouble, said, seen, untold

from fcw.camera.calibration import Gaussian
from fcw.camera.solve import calibrate
from fcw.camera.straight import Orientation, Straightening, straight_column
from fcw_viz.calibrate_app.document.document import Belief, Document, Line
from fcw_viz.calibrate_app.document.edits import AddMark, EnableMark, SetDistance
from fcw_viz.calibrate_app.document.solution import solve
from fcw_viz.calibrate_app.document.state import Status
from fcw_viz.calibrate_app.document.ways.ways import middle_row

# What is still missing


@pytest.mark.parametrize(
    ("document", "hint"),
    [
        (Document(SIZE), "Choose what you have to calibrate with, or click a mark whose distance you know."),
        (Document(SIZE, planned_m=(4, 5, 7)), "Click the mark at 4 m."),
        (Document(SIZE, planned_m=(3.048, 5, 7), imperial=True), "Click the mark at 10 ft."),
        (untold(461), "Type the distance of A."),
        (said((4, 461)), "Click two more marks at other distances, one of them far away."),
        (said((4, 461), (5, 428)), "Click one more mark at another distance, preferably far away."),
        (said((4, 461), planned_m=(4, 5, 7)), "Click the mark at 5 m."),
        (said(*PAPER_POINTS), "Type the camera's height above the road."),
        (
            said(*PAPER_POINTS, height_m=1.2, from_bumper=True),
            "Type how far the front bumper is ahead of the camera.",
        ),
    ],
)
def test_an_unfinished_document_is_told_exactly_what_comes_next(document, hint):
    solution = solve(document)
    assert solution.status is Status.INCOMPLETE
    assert solution.hint == hint
    assert not solution.troubles
    assert not solution.can_save


def test_priors_count_as_facts():
    belief = Belief(Gaussian(math.radians(65), 0.05))
    assert solve(said(*seen(6, 20), height_m=1.3, field_of_view=belief)).status is Status.GOOD
    off = replace(belief, enabled=False)
    assert solve(said(*seen(6, 20), height_m=1.3, field_of_view=off)).status is Status.INCOMPLETE


def test_without_a_height_the_distances_are_shown_and_nothing_can_be_saved():
    """The height all but cancels out of the distances of three points."""
    solution = solve(said(*seen(6, 15, 40)))
    assert solution.height_assumed
    assert not solution.can_save
    assert solution.result is not None
    for row in solution.result.rows:
        assert row.row_px == pytest.approx(CAMERA.row_at(row.distance_m), abs=0.5)


def test_the_preview_without_a_height_is_as_unsure_as_heights_are_where_no_distance_is_marked():
    """Lens and horizon tell distances in camera heights, and lenses are 0.8 to 2.2 m above the road."""
    view, horizon = Gaussian(2 * math.atan(0.64), math.radians(3)), Gaussian(CAMERA.horizon_row_px, 2.0)
    rows = Document(SIZE, field_of_view=Belief(view), principal_row=middle_row(SIZE), horizon=Belief(horizon))
    for document in (rows, replace(rows, yaw=Belief(Gaussian(0.0, 0.01)))):
        solution = solve(document)
        assert solution.height_assumed
        assert solution.result is not None
        seen_as_30_m = replace(CAMERA, height_m=1.7).row_at(30.0)
        low_m, high_m = solution.result.calibration.distance_interval(seen_as_30_m)
        assert low_m < 30.0 < high_m
        assert "Rough" in solution.result.quality
        sure = solve(replace(document, height_m=1.3, height_sigma_m=0.03))
        assert sure.result is not None
        assert "Rough" not in sure.result.quality


def test_two_repeated_clicks_on_one_mark_are_no_mistake():
    assert solve(said((6, 500), (6, 501), height_m=1.3)).status is Status.INCOMPLETE


# The result


def test_the_result_is_that_of_the_headless_calibration():
    document = said(*seen(6, 9, 15, 30, 45), height_m=1.3, from_bumper=True, bumper_offset_m=0.0)
    points = [mark.ground_point for mark in document.marks]
    result = solve(document).result
    assert result is not None
    assert result.calibration == calibrate([p for p in points if p is not None], SIZE, 1.3)


def test_rows_carry_their_error_and_their_interval():
    result = solve(said(*seen(5, 10, 20), height_m=1.3)).result
    assert result is not None
    assert [row.distance_m for row in result.rows] == [5, 10, 15, 20, 30, 40, 50, 80]
    at_10 = result.rows[1]
    assert 1.0 < at_10.row_sigma_px < 1.6, "as the click and the tape are"
    for row in result.rows:
        assert row.low_m < row.distance_m < row.high_m
        slope = (CAMERA.row_at(row.distance_m + 1e-4) - CAMERA.row_at(row.distance_m - 1e-4)) / 2e-4
        if row.distance_m <= 20:
            # Near, the percentiles are those of a normal.
            assert (row.high_m - row.low_m) / 2 == pytest.approx(row.row_sigma_px / -slope, rel=0.03)


@pytest.mark.parametrize(("imperial", "place"), [(False, "at about 40 m: "), (True, "at about 131 ft: ")])
def test_the_next_point_is_proposed_in_whole_metres_or_feet(imperial, place):
    solution = solve(said(*seen(5, 10, 20), height_m=1.3, imperial=imperial))
    assert solution.result is not None
    assert solution.result.next_click is not None
    assert solution.result.next_click.distance_m == pytest.approx(40.0)
    assert place in solution.hint


def test_imperial_rows_are_round_in_feet():
    result = solve(said(*seen(5, 10, 20), height_m=1.3, imperial=True)).result
    assert result is not None
    feet = [row.distance_m / 0.3048 for row in result.rows]
    assert feet == pytest.approx([15, 30, 50, 75, 100, 150, 200, 250])
    assert result.quality.startswith("A reading of 131 ft "), "40 m, as everywhere"


def test_residuals_are_told_by_mark_in_pixels_and_metres():
    points = seen(6, 9, 15, 30, 45)
    points[2] = (15, points[2][1] + 1.0)
    document = EnableMark(2, False).apply(said(*points, height_m=1.3))
    result = solve(document).result
    assert result is not None
    assert set(result.residuals) == {1, 3, 4, 5}
    assert not result.exact
    residual = result.residuals[3]
    assert residual.row_px > 0, "clicked too low"
    assert residual.distance_m < 0, "so it seems too near"
    calibration = result.calibration
    assert residual.row_px == pytest.approx(points[2][1] - calibration.row_at(15.0))
    assert residual.distance_m == pytest.approx(calibration.distance_at(points[2][1]) - 15.0)


def test_three_points_are_met_whatever_they_are_and_that_is_said():
    result = solve(said(*PAPER_POINTS, height_m=1.2)).result
    assert result is not None
    assert result.exact


def test_near_points_are_said_to_leave_the_far_open():
    """As clicked in a picture a twentieth as large: their horizon is anywhere."""
    result = solve(said(*seen(4, 5, 7), height_m=1.3, row_sigma_px=20.0)).result
    assert result is not None
    assert "only means farther than" in result.quality
    assert "far point" in result.quality


# More information


def test_lane_lines_give_the_horizon_and_sharpen_the_far_distances():
    def along(lateral_m: float) -> Line:
        (near, far) = ((CAMERA.column_at(lateral_m, d), CAMERA.row_at(d)) for d in (6.0, 40.0))
        return Line(near, far)

    document = said(*seen(4, 5, 7), height_m=1.3, lane_lines=(along(1.8), along(-1.8)))
    solution = solve(document)
    assert solution.lane_horizon is not None
    assert solution.lane_horizon.value == pytest.approx(CAMERA.horizon_row_px, abs=1e-6)
    effect = solution.effects["lane_lines"]
    assert effect.error_with < effect.error_without / 2
    assert effect.shift == pytest.approx(0, abs=0.01)
    assert solve(replace(document, lane_lines_enabled=False)).effects["lane_lines"] == effect


def test_parallel_lane_lines_are_told_and_do_not_take_part():
    parallel = (Line((100, 700), (110, 400)), Line((300, 700), (310, 400)))
    document = said(*seen(6, 15, 40), height_m=1.3, lane_lines=parallel)
    solution = solve(document)
    assert solution.lane_horizon is None
    assert "nearly parallel" in only_trouble(solution).text
    assert solution.status is Status.GOOD


def test_a_dragged_horizon_and_the_lane_lines_count_together():
    lines = (Line((300.0, 700.0), (600.0, 330.0)), Line((979.0, 700.0), (679.0, 330.0)))
    document = said(*seen(6, 15), height_m=1.3, lane_lines=lines, row_sigma_px=2.0)
    ahead = tuple(replace(mark, column_px=639.5) for mark in document.marks)
    document = replace(document, marks=ahead)  # between the lines: the camera is level
    lanes = solve(document).lane_horizon
    assert lanes is not None
    dragged = Gaussian(lanes.value + 1.0, lanes.sigma)
    result = solve(replace(document, horizon=Belief(dragged))).result
    assert result is not None
    horizon = result.calibration.priors.horizon_row_px
    assert horizon is not None
    assert horizon.value == pytest.approx(lanes.value + 0.5)
    assert horizon.sigma == pytest.approx(lanes.sigma / math.sqrt(2))


def test_horizons_that_disagree_are_told_before_what_follows_from_it():
    lines = (Line((300.0, 700.0), (600.0, 330.0)), Line((979.0, 700.0), (679.0, 330.0)))
    horizon = Belief(Gaussian(400.0, 2.0))
    document = said(*seen(6, 15, 40), height_m=1.3, lane_lines=lines, horizon=horizon)
    first = solve(document).troubles[0]
    assert "one of the two is wrong" in first.text
    assert mended(document, first.mend).horizon == replace(horizon, enabled=False)


def test_an_effect_is_what_switching_the_belief_does():
    belief = Belief(Gaussian(359.5, 10.0))
    on = said(*seen(5, 10, 20), height_m=1.3, principal_row=belief)
    off = replace(on, principal_row=replace(belief, enabled=False))
    effect = solve(on).effects["principal_row"]
    assert solve(off).effects["principal_row"] == effect

    def error(document: Document) -> float:
        result = solve(document).result
        assert result is not None
        (row,) = (row for row in result.rows if row.distance_m == 40)
        slope = (CAMERA.row_at(40.0 + 1e-4) - CAMERA.row_at(40.0 - 1e-4)) / 2e-4
        return row.row_sigma_px / -slope / 40

    assert effect.error_without == pytest.approx(error(off), rel=1e-3)
    assert effect.error_with == pytest.approx(error(on), rel=1e-3)
    assert effect.error_with < effect.error_without


def test_a_belief_that_makes_the_camera_determined_is_said_to():
    belief = Belief(Gaussian(math.radians(65.2), 0.02))
    effect = solve(said(*seen(6, 30), height_m=1.3, field_of_view=belief)).effects["field_of_view"]
    assert math.isinf(effect.error_without)
    assert effect.error_with < 0.1


def test_every_click_noise_is_counted_in_the_next_click():
    result = solve(said(*seen(4, 5, 7), height_m=1.3)).result
    assert result is not None
    click = result.next_click
    assert click is not None
    assert click.distance_m > 20, "near points need a far one"
    with_click = solve(said(*seen(4, 5, 7, click.distance_m), height_m=1.3)).result
    assert with_click is not None
    targets = np.array([row.row_sigma_px for row in with_click.rows])
    assert np.all(targets <= np.array([row.row_sigma_px for row in result.rows]) + 1e-3)


def test_a_distance_taken_back_is_asked_for_again():
    document = SetDistance(2, None).apply(said(*PAPER_POINTS, height_m=1.2))
    assert solve(document).hint == "Type the distance of B."


def test_a_point_in_the_sky_is_said_of_that_point_at_once_and_of_no_other():
    document = said(*seen(6, 15, 40), height_m=1.3)
    result = solve(document).result
    assert result is not None
    row_px = result.calibration.horizon_row_px - 60
    clicked = AddMark(600.0, row_px).apply(document)
    (trouble,) = solve(clicked).troubles
    assert trouble.mark_ids == (4,)
    assert "D lies above the horizon, in the sky" in trouble.text
    # Its distance makes the points contradict each other; the others are still not accused.
    typed = SetDistance(4, 60.0).apply(clicked)
    (trouble,) = solve(typed).troubles
    assert trouble.mark_ids == (4,)
    assert trouble.mend is not None
    for edit in trouble.mend.edits:
        typed = edit.apply(typed)
    assert solve(typed).troubles == ()


def test_a_point_in_the_sky_is_named_though_the_rest_were_measured_from_the_bumper():
    from_bumper = [(d - 2.0, row) for d, row in seen(6, 15, 30)]
    document = said(*from_bumper, height_m=1.3)
    assert solve(document).status is not Status.GOOD, "that is told of them"
    for distance_m in (None, 60.0):
        (trouble,) = solve(AddMark(300.0, 60.0, 0, distance_m).apply(document)).troubles[:1]
        assert trouble.mark_ids == (4,)
        assert "in the sky" in trouble.text


def test_distances_that_contradict_the_rest_put_no_good_mark_in_the_sky():
    """Two taped distances are exchanged: what they give is no horizon, and nothing lies in its sky."""
    rows_px = [CAMERA.row_at(true_m) for true_m in (8.0, 15.0)]

    def road(side_m: float, distance_m: float) -> tuple[float, float]:
        return CAMERA.column_at(side_m, distance_m), CAMERA.row_at(distance_m)

    exchanged = said(
        *zip((25.0, 15.0), rows_px, strict=True),
        height_m=1.3,
        field_of_view=Belief(Gaussian(math.radians(85), math.radians(15))),
        principal_row=Belief(Gaussian(359.5, 20.0)),
        lane_lines=tuple(
            Line(*((CAMERA.column_at(side, d), CAMERA.row_at(d)) for d in (7.0, 40.0)))
            for side in (1.8, -1.8)
        ),
        lane_width=Belief(Gaussian(3.6, 0.1)),
    )
    far = AddMark(640.0, CAMERA.row_at(40.0)).apply(exchanged)
    troubles = solve(far, effects=False).troubles
    assert troubles
    assert not any("sky" in trouble.text for trouble in troubles)


# A camera that is turned


def rolled(
    *places_m: tuple[float, float], roll_deg: float = 0.0, yaw_deg: float = 0.0
) -> list[tuple[float, float]]:
    """Columns and rows where `CAMERA` would see places (distance, to the left) if it were so turned."""
    turned = Orientation(math.radians(yaw_deg), math.radians(roll_deg))
    straight = replace(CAMERA, principal_column_px=straight_column(CAMERA, turned))
    places = [(straight.column_at(left_m, d), straight.row_at(d)) for d, left_m in places_m]
    way = Straightening(straight, turned, None, SIZE)
    return [(float(column), float(row)) for column, row in way.to_picture(np.array(places))]


def clicked(distances_m: Sequence[float], places_px: Sequence[tuple[float, float]], **fields) -> Document:
    document = Document(SIZE, height_m=1.3, **fields)
    for distance_m, (column_px, row_px) in zip(distances_m, places_px, strict=True):
        document = AddMark(column_px, row_px, 0, distance_m).apply(document)
    return document


@pytest.mark.parametrize(
    "places_m",
    [
        ((5, 0.9), (10, -0.9), (20, 0.9)),
        ((6, 1.5), (15, -1.5), (40, 1.5)),
        ((6, 1.8), (6, -1.8), (15, 1.8), (15, -1.8), (30, 0.0)),
    ],
)
def test_a_tilted_camera_is_found_by_marks_to_both_sides_and_no_mark_is_blamed(places_m):
    document = clicked([d for d, _ in places_m], rolled(*places_m, roll_deg=2.0))
    solution = solve(document)
    assert solution.status is Status.GOOD
    assert solution.result is not None
    turned = solution.result.calibration.orientation
    assert turned.roll_sigma_rad < math.radians(0.6)
    assert turned.roll_rad == pytest.approx(math.radians(2.0), abs=2 * turned.roll_sigma_rad)
    for row in solution.result.rows:
        assert row.row_px == pytest.approx(CAMERA.row_at(row.distance_m), abs=2 * row.row_sigma_px)


def test_rows_that_only_a_tilt_explains_are_asked_about_and_not_refused():
    """Straight ahead, rows at 5 and 7 m so near to each other would be those of no road."""
    places_m = ((4, 0.9), (5, -1.6), (7, 1.2))
    solution = solve(clicked([d for d, _ in places_m], rolled(*places_m, roll_deg=-4.0)))
    assert solution.status is Status.DOUBTFUL
    assert solution.result is not None
    assert solution.result.calibration.orientation.roll_rad == pytest.approx(math.radians(-4.0), rel=0.1)
    assert solution.result.calibration.row_at(20.0) == pytest.approx(CAMERA.row_at(20.0), abs=3.0)
    said_m = [4.0, 7.0, 5.0]
    assert solve(clicked(said_m, rolled(*places_m, roll_deg=-4.0))).status is Status.DEGENERATE


def test_lane_lines_tell_which_way_the_camera_looks():
    marks_m = ((6, 0.9), (15, -0.9), (30, 0.9))
    ends = [rolled((7, side), (40, side), roll_deg=2.0, yaw_deg=3.0) for side in (1.8, -1.8)]
    lines = (Line(*ends[0]), Line(*ends[1]))
    document = clicked([d for d, _ in marks_m], rolled(*marks_m, roll_deg=2.0, yaw_deg=3.0), lane_lines=lines)
    solution = solve(document)
    assert solution.status is Status.GOOD
    assert solution.result is not None
    turned = solution.result.calibration.orientation
    assert turned.yaw_sigma_rad < math.radians(0.5)
    assert turned.yaw_rad == pytest.approx(math.radians(3.0), abs=2 * turned.yaw_sigma_rad)


def test_distances_from_the_bumper_may_look_like_a_tilt_and_are_asked_about():
    """Of three marks alternating in side a tilt of 1.4 degrees explains them nearly as well."""
    places_m = ((5, 1.2), (10, -1.8), (20, 2.5))
    places_px = rolled(*((d + 2.0, left_m) for d, left_m in places_m))
    document = clicked([d for d, _ in places_m], places_px)
    solution = solve(document)
    assert solution.status is Status.DOUBTFUL
    (trouble,) = solution.troubles
    assert (
        "if it is level, the distances do not start where you said (camera or front bumper)" in trouble.text
    )
    tilted = replace(document, roll=Belief(Gaussian(math.radians(-1.4), math.radians(0.3))))
    assert solve(tilted).status is Status.GOOD


def test_a_slip_of_ten_is_no_roll():
    """A roll that three marks alternating in side would need is odd, and asked about."""
    places_m = ((5, 1.2), (10, -1.8), (20, 2.5))
    distances_m = (5.0, 10.0, 200.0)
    solution = solve(clicked(distances_m, rolled(*places_m)))
    assert solution.status is not Status.GOOD
    assert solution.troubles
