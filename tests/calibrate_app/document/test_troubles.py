"""What is wrong with a document: troubles beside their marks, and mends that mend."""

import math
from dataclasses import replace

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from session_helpers import CAMERA, PAPER_POINTS, SIZE, edits, mended, only_trouble, said, seen

from fcw.camera.calibration import Gaussian
from fcw.camera.lens.model import Lens
from fcw.errors import UserError
from fcw_viz.calibrate_app.document.document import Belief, Line
from fcw_viz.calibrate_app.document.edits import (
    AddMark,
    DeleteMark,
    Edit,
    EnableMark,
    SetFieldOfView,
    SetHeight,
    SetReference,
)
from fcw_viz.calibrate_app.document.solution import solve
from fcw_viz.calibrate_app.document.state import Mend, Status


def test_the_papers_points_are_asked_about_and_the_bumper_at_2_29_m_makes_them_good():
    document = said(*PAPER_POINTS, height_m=1.225)
    solution = solve(document)
    # Marks each off by the tape's 1 % would explain them as well, so nobody is accused.
    assert solution.status is Status.DOUBTFUL
    assert solution.can_save
    trouble = only_trouble(solution)
    assert "front bumper" in trouble.text
    assert "2.1 to 2.4 m" in trouble.text
    assert trouble.mend == Mend(
        "Distances were measured from the bumper: set the offset to 2.29 m", (SetReference(True, 2.29),)
    )
    good = solve(mended(document, trouble.mend))
    assert good.status is Status.GOOD
    assert not good.troubles
    assert good.result is not None
    assert good.result.calibration.camera.principal_row_px == pytest.approx(359.5, abs=2.5)


def test_a_wrong_offset_is_corrected_rather_than_introduced():
    from_bumper = [(d - 2.2, row) for d, row in seen(7.0, 12.0, 22.0, 40.0)]
    trouble = only_trouble(solve(said(*from_bumper, height_m=1.3, from_bumper=True, bumper_offset_m=0.5)))
    assert trouble.mend is not None
    assert trouble.mend.label.startswith("Set the bumper offset to ")
    assert "not 0.50 m" in trouble.text


@pytest.mark.parametrize(
    ("points", "mark_ids", "words"),
    [
        (((4, 461), (4, 400), (7, 383)), (1, 2), "A and B have the same distance, 4 m"),
        (((4, 461), (5, 461), (7, 383)), (1, 2), "A (4 m) and B (5 m) are in the same row"),
        (((4, 461), (5, 428), (7, 440)), (2, 3), "C (7 m) is farther than B (5 m) but lower"),
        (((4, 461), (5, 440), (7, 383)), (1, 2, 3), "the rows of A, B and C do not crowd together"),
        (((5, 400.3), (10, 400.2), (20, 400.1)), (1, 2, 3), "A, B and C differ by less than the click error"),
        (((10, 461), (5, 428)), (1, 2), "A (10 m) is farther than B (5 m) but lower"),
        (((4, 461), (4, 400)), (1, 2), "A and B have the same distance"),
    ],
)
def test_degenerate_points_are_named_by_their_letters_beside_their_marks(points, mark_ids, words):
    solution = solve(said(*points, height_m=1.225))
    assert solution.status is Status.DEGENERATE
    assert solution.result is None
    assert not solution.can_save
    trouble = only_trouble(solution)
    assert set(trouble.mark_ids) == set(mark_ids)
    assert words in trouble.text


def test_degenerate_points_are_named_in_feet_where_feet_are_typed():
    document = said((3.048, 461), (6.096, 428), (9.144, 440), height_m=1.2, imperial=True)
    assert "C (30 ft) is farther than B (20 ft)" in only_trouble(solve(document)).text


@pytest.mark.parametrize("paced", [False, True])
def test_a_mark_farther_than_anybody_measures_is_named_by_its_letter(paced):
    """Of dashes the fit counts from the first one, but the person from where the marks are."""
    rows_px = (row_px for _, row_px in seen(9.0, 21.0, 33.0))
    points = tuple(zip((300.0, 600.0, 900.0), rows_px, strict=True))
    document = said(*points, height_m=1.3, paced=paced)
    solution = solve(document)
    assert solution.status is Status.DEGENERATE
    trouble = only_trouble(solution)
    assert trouble.mark_ids == (3,)
    assert "C (900 m) is farther than anyone can measure (500 m)" in trouble.text


def test_what_is_known_of_lens_and_horizon_has_a_say_in_what_went_wrong():
    """Three rows alone do not tell 150 m for 15 from two distances that are swapped."""
    view, horizon = Gaussian(2 * math.atan(0.64), 0.03), Gaussian(CAMERA.horizon_row_px, 2.0)
    (near, slip, far) = seen(7, 15, 25)
    document = said(near, (150.0, slip[1]), far, height_m=1.3)
    document = replace(document, field_of_view=Belief(view), horizon=Belief(horizon))
    trouble = only_trouble(solve(document))
    assert "B is 15 m away, not 150 m" in trouble.text
    good = solve(mended(document, trouble.mend))
    assert good.status is Status.GOOD
    assert good.result is not None
    assert good.result.calibration.distance_at(CAMERA.row_at(30.0)) == pytest.approx(30.0, rel=0.02)


def test_swapped_distances_are_swapped_back():
    points = seen(6, 15, 40)
    document = said((6, points[0][1]), (40, points[1][1]), (15, points[2][1]), height_m=1.3)
    trouble = only_trouble(solve(document))
    assert trouble.mend is not None
    assert trouble.mend.label == "Swap the distances of B and C"
    assert solve(mended(document, trouble.mend)).status is Status.GOOD


def test_distances_typed_in_reverse_are_sorted_by_row():
    points = seen(6, 15, 25, 40)
    reverse = [(near[0], far[1]) for near, far in zip(points, points[::-1], strict=True)]
    document = said(*reverse, height_m=1.3)
    trouble = only_trouble(solve(document))
    assert trouble.mend is not None
    assert trouble.mend.label == "Sort the distances by row, nearest at the bottom"
    assert solve(mended(document, trouble.mend)).status is Status.GOOD


@pytest.mark.parametrize("wrong", range(6))
@pytest.mark.parametrize("shift_px", [-25.0, 25.0])
def test_the_one_wrong_mark_among_many_is_the_one_to_leave_out(wrong, shift_px):
    points = seen(5, 8, 12, 18, 27, 40)
    points[wrong] = (points[wrong][0], points[wrong][1] + shift_px)
    document = said(*points, height_m=1.3)
    solution = solve(document)
    assert solution.status in (Status.IMPLAUSIBLE, Status.DEGENERATE)
    mends = [trouble.mend for trouble in solution.troubles if trouble.mend]
    assert (EnableMark(wrong + 1, False),) in [mend.edits for mend in mends]
    assert solve(mended(document, mends[-1])).status is Status.GOOD


def test_feet_typed_as_metres_are_proposed_and_shown_as_typed():
    document = said(*((d / 0.3048, row) for d, row in seen(6.096, 15.24, 39.624)), height_m=1.3)
    trouble = only_trouble(solve(document))
    assert "were typed as metres, but are in feet" in trouble.text
    assert trouble.mend is not None
    assert trouble.mend.label == "Read the distances as feet"
    right = mended(document, trouble.mend)
    assert right.imperial
    assert [mark.distance_m for mark in right.marks] == pytest.approx([6.096, 15.24, 39.624])
    assert solve(right).status is Status.GOOD


@pytest.mark.parametrize(
    ("height_m", "imperial", "label", "meant_m"),
    [
        (4.3, False, "Read the height as 4.3 feet", 1.3106),
        (130.0, False, "Read the height as 130 centimetres", 1.3),
        (51.0, False, "Read the height as 51 inches", 1.2954),
        (1300.0, False, "Read the height as 1300 millimetres", 1.3),
        (1.3 * 0.3048, True, "Read the height as 1.3 metres", 1.3),
    ],
)
def test_a_height_in_another_unit_is_proposed(height_m, imperial, label, meant_m):
    document = said(*seen(6, 15, 40), height_m=height_m, imperial=imperial)
    solution = solve(document)
    assert solution.status is Status.IMPLAUSIBLE
    trouble = solution.troubles[0]
    assert "above the road cannot be behind a windscreen" in trouble.text
    assert trouble.mend == Mend(label, (SetHeight(meant_m),))
    assert solve(mended(document, trouble.mend)).status is Status.GOOD


def test_where_the_cause_is_known_no_other_one_is_guessed_at():
    points = seen(7.6, 16.6, 31.6)
    trouble = only_trouble(
        solve(said((7.6, points[0][1]), (166, points[1][1]), (31.6, points[2][1]), height_m=1.3))
    )
    assert "B (166 m) is farther than C (31.6 m) but lower" in trouble.text
    assert "a slip of the decimal point" in trouble.text
    assert "swapped" not in trouble.text


def test_a_near_mark_that_bends_the_camera_rather_than_the_residuals_is_found_out():
    points = seen(5, 8, 12, 18, 27, 40)
    points[0] = (5, points[0][1] + 25)
    trouble = only_trouble(solve(said(*points, height_m=1.3)))
    assert trouble.mark_ids == (1,)
    assert "without it, all others agree" in trouble.text


def test_a_contradicting_prior_is_switched_off_not_forgotten():
    belief = Belief(Gaussian(math.radians(100), math.radians(3)))
    document = said(*seen(5, 12, 30, 45), height_m=1.3, row_sigma_px=0.01, field_of_view=belief)
    troubles = [t for t in solve(document).troubles if "field of view of 100 ± 3° contradicts" in t.text]
    assert len(troubles) == 1
    contradictory = solve(document).result
    assert contradictory is not None
    assert "no interval here can be trusted" in contradictory.quality
    right = mended(document, troubles[0].mend)
    assert right.field_of_view == replace(belief, enabled=False)
    assert solve(right).status is Status.GOOD


def test_noise_accuses_nobody():
    noisy = [(d, row + n) for (d, row), n in zip(seen(4, 5, 7), (1.0, -1.0, 1.0), strict=True)]
    solution = solve(said(*noisy, height_m=1.3))
    assert solution.status is Status.GOOD
    assert not solution.troubles


def test_a_slip_of_the_decimal_point_is_mended_in_the_points_own_words():
    points = seen(6, 16.6, 40)
    document = said((6, points[0][1]), (1.66, points[1][1]), (40, points[2][1]), height_m=1.3)
    trouble = only_trouble(solve(document))
    assert trouble.mend is not None
    assert trouble.mend.label == "Set the distance of B to 16.6 m"
    assert solve(mended(document, trouble.mend)).status is Status.GOOD


def test_a_lens_that_contradicts_the_height_is_said():
    """The marks of a camera of 1000 px, and the lens of one that has 1300."""
    lens = Lens("radtan", 1300.0, 1300.0, 639.5, 359.5, (0.0, 0.0, 0.0, 0.0), SIZE)
    solution = solve(said(*seen(6, 15, 40), height_m=1.3, lens=lens))
    assert solution.status is Status.IMPLAUSIBLE
    assert any("camera height of 1.3 ± 0.03 m contradicts" in trouble.text for trouble in solution.troubles)
    assert solution.result is not None
    assert "no interval here can be trusted" in solution.result.quality


WIDE = Belief(Gaussian(2.0, 0.125), True)


def far_apart(*rows_px: float) -> list[Edit]:
    """Six marks in columns far apart, clicked so badly that a lens that bends lines explains them best."""
    columns_px, distances_m = (100.0, 1180.0, 300.0, 900.0, 200.0, 1000.0), (5.0, 8.0, 12.0, 18.0, 27.0, 40.0)
    marks = zip(columns_px, rows_px, distances_m, strict=True)
    added = [AddMark(column_px, row_px, 0, distance_m) for column_px, row_px, distance_m in marks]
    return [*map(DeleteMark, range(1, 5)), *added, SetHeight(1.3)]


GOOD_BUT_FOR_THE_LENS = far_apart(566.08, 475.32, 418.58, 381.95, 351.48, 341.54)
DOUBTFUL_BUT_FOR_THE_LENS = far_apart(569.52, 475.36, 419.4, 379.86, 355.55, 336.53)


@pytest.mark.parametrize("steps", [GOOD_BUT_FOR_THE_LENS, DOUBTFUL_BUT_FOR_THE_LENS])
def test_a_bent_picture_is_implausible_already_while_somebody_drags(steps):
    document = said(*PAPER_POINTS, (12, 330), height_m=1.2)
    for edit in steps:
        document = edit.apply(document)
    for solution in (solve(document), solve(document, effects=False)):
        assert solution.status is Status.IMPLAUSIBLE
        assert any("the lens bends this picture" in trouble.text.lower() for trouble in solution.troubles)


@pytest.mark.slow
@given(st.lists(edits, max_size=12))
@example([DeleteMark(1), SetReference(True, 2.0), SetFieldOfView(WIDE)])  # a bumper behind the camera
@example(GOOD_BUT_FOR_THE_LENS)
@example(DOUBTFUL_BUT_FOR_THE_LENS)
def test_any_document_has_a_solution_and_whatever_it_proposes_can_be_applied(steps):
    document = said(*PAPER_POINTS, (12, 330), height_m=1.2)
    for edit in steps:
        try:
            document = edit.apply(document)
        except UserError:
            continue
    solution, quick = solve(document), solve(document, effects=False)
    assert (solution.status, solution.result is None) == (quick.status, quick.result is None)
    assert (solution.status is Status.DEGENERATE) <= bool(solution.troubles)
    assert (solution.status is Status.IMPLAUSIBLE) <= bool(solution.troubles)
    assert solution.hint
    ids = {mark.id for mark in document.marks}
    for trouble in solution.troubles:
        assert set(trouble.mark_ids) <= ids
        if trouble.mend is not None:
            assert mended(document, trouble.mend) != document
    if solution.result is not None:
        assert all(math.isfinite(row.row_px) for row in solution.result.rows)
        assert all(not math.isnan(row.high_m) for row in solution.result.rows)


def test_a_height_that_the_rest_contradicts_is_told_in_the_units_that_are_typed():
    """With its error: `1.6 ± 0.0984 ft` would be wrong by a factor of three."""
    lines = tuple(
        Line((CAMERA.column_at(y, 7.0), CAMERA.row_at(7.0)), (CAMERA.column_at(y, 40.0), CAMERA.row_at(40.0)))
        for y in (1.75, -1.75)
    )
    stated = said(*seen(9, 25, 45), height_m=1.6, height_sigma_m=0.03)
    stated = replace(stated, lane_lines=lines, lane_width=Belief(Gaussian(3.5, 0.05)))
    for imperial, words in ((False, "1.6 ± 0.03 m contradicts"), (True, "5.25 ± 0.0984 ft contradicts")):
        troubles = solve(replace(stated, imperial=imperial)).troubles
        assert any(words in trouble.text for trouble in troubles)
