"""What is said of calibrations that no windscreen camera can have."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.plausibility import FindingKind, plausibility
from fcw.camera.solve import calibrate
from fcw.camera.straight import Orientation
from fcw.camera.verdicts.hypotheses import Fault
from fcw.camera.verdicts.judgement import judge
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
PAPER_POINTS = (GroundPoint(4, 461), GroundPoint(5, 428), GroundPoint(7, 383))


def kinds(calibration: Calibration) -> set[FindingKind]:
    return {finding.kind for finding in plausibility(calibration)}


def seen_by(camera: GroundPlaneCamera, *distances_m: float) -> list[GroundPoint]:
    return [GroundPoint(d, camera.row_at(d)) for d in distances_m]


def test_papers_points_lead_to_the_bumper_and_an_offset_of_2_29_m():
    for exact in (False, True):
        findings = plausibility(calibrate(PAPER_POINTS, SIZE, 1.225, exact=exact))
        camera_kinds = {FindingKind.PITCH, FindingKind.FIELD_OF_VIEW, FindingKind.PRINCIPAL_ROW}
        assert ({f.kind for f in findings} > camera_kinds) == exact
        cause = findings[-1]
        assert cause.kind is FindingKind.CAUSE
        assert cause.suspicion is not None
        assert cause.suspicion.fault is Fault.BUMPER
        assert cause.offset is not None
        assert cause.offset.offset_m == pytest.approx(2.29, abs=0.005)
        assert (cause.offset.low_m, cause.offset.high_m) == pytest.approx((2.1, 2.4))
        assert "measured from the front bumper" in cause.text
        assert "2.29 m" in cause.text
        assert "2.1 to 2.4 m" in cause.text


def test_proposed_offset_puts_the_principal_row_at_the_middle_and_silences_the_warning():
    offset = plausibility(calibrate(PAPER_POINTS, SIZE, 1.225))[-1].offset
    assert offset is not None
    exact = calibrate(PAPER_POINTS, SIZE, 1.225, offset.offset_m, exact=True)
    assert exact.camera.principal_row_px == pytest.approx(359.5, abs=1e-6)
    for offset_m in (offset.low_m, offset.offset_m, offset.high_m):
        assert plausibility(calibrate(PAPER_POINTS, SIZE, 1.225, reference_offset_m=offset_m)) == ()


def test_wrong_offset_is_told_from_a_missing_one():
    camera = GroundPlaneCamera(0.05, 1000, 359.5, 1.3, 639.5)
    from_bumper = [GroundPoint(d - 2.2, camera.row_at(d)) for d in (7.0, 12.0, 22.0, 40.0)]
    findings = plausibility(calibrate(from_bumper, SIZE, 1.3, reference_offset_m=0.5))
    offset = findings[-1].offset
    assert offset is not None
    assert offset.offset_m == pytest.approx(2.2, abs=0.4)
    assert "the reference offset is not what was given" in findings[-1].text


@pytest.mark.parametrize(
    ("camera", "kind"),
    [
        (GroundPlaneCamera(0.45, 900, 359.5, 1.3, 639.5), FindingKind.PITCH),
        (GroundPlaneCamera(-0.45, 900, 300, 1.3, 639.5), FindingKind.PITCH),
        (GroundPlaneCamera(0.05, 200, 359.5, 1.3, 639.5), FindingKind.FIELD_OF_VIEW),
        (GroundPlaneCamera(0.0, 5000, 359.5, 1.3, 639.5), FindingKind.FIELD_OF_VIEW),
        (GroundPlaneCamera(0.05, 900, 120, 1.3, 639.5), FindingKind.PRINCIPAL_ROW),
        (GroundPlaneCamera(0.3, 1600, 400, 1.3, 639.5), FindingKind.HORIZON),
    ],
)
def test_each_implausible_quantity_is_found_and_a_cause_named(camera, kind):
    calibration = Calibration.from_camera(camera, SIZE)
    assert kind in kinds(calibration)
    assert FindingKind.CAUSE in kinds(calibration)


def test_plausible_cameras_are_left_in_peace():
    for camera in (
        GroundPlaneCamera(0.1194, 1094.313, 363.331, 1.225, 639.5),
        GroundPlaneCamera(-0.03, 700, 340, 1.6, 639.5),
    ):
        assert plausibility(calibrate(seen_by(camera, 6, 15, 40), SIZE, camera.height_m)) == ()


def test_feet_for_metres_are_not_explained_by_an_offset():
    """Distances in feet make the map 3.28 times longer: the focal length comes out as long."""
    camera = GroundPlaneCamera(0.05, 1700, 359.5, 1.3, 639.5)
    in_feet = [GroundPoint(d / 0.3048, camera.row_at(d)) for d in (6.0, 9.0, 16.0)]
    findings = plausibility(calibrate(in_feet, SIZE, 1.3, row_sigma_px=0.1))
    assert FindingKind.FIELD_OF_VIEW in {finding.kind for finding in findings}
    assert all(finding.offset is None for finding in findings)
    assert "the distances are in feet" in findings[-1].text


def test_noise_of_near_clicks_accuses_nobody_and_is_named_of_the_exact_solution():
    camera = GroundPlaneCamera(0.03, 1100, 359.5, 1.225, 639.5)
    near = seen_by(camera, 4, 5, 7)
    noisy = [GroundPoint(p.distance_m, p.row_px + n) for p, n in zip(near, (1.0, -1.0, 1.0), strict=True)]
    assert plausibility(calibrate(noisy, SIZE, 1.225)) == ()
    exact = plausibility(calibrate(noisy, SIZE, 1.225, exact=True))
    assert FindingKind.PRINCIPAL_ROW in {finding.kind for finding in exact}
    assert "add a point far away" in exact[-1].text


def test_a_measured_offset_is_not_doubted_for_noise_alone():
    """The shipped drive's marks, clicked up to 0.7 px off: the offset of 1.6 m is the true one."""
    clicked = [GroundPoint(d, v) for d, v in ((6, 500.2), (15, 408.0), (30, 371.1), (10.6, 437.5))]
    assert plausibility(calibrate(clicked, SIZE, 1.3, reference_offset_m=1.6)) == ()


def test_wrong_click_among_many_is_named():
    camera = GroundPlaneCamera(0.05, 1000, 359.5, 1.3, 639.5)
    points = seen_by(camera, 5, 8, 13, 21, 34)
    points[2] = GroundPoint(13.0, points[2].row_px + 12)
    (finding,) = plausibility(calibrate(points, SIZE, 1.3))
    assert finding.point == points[2]
    assert str(points[2]) in finding.text
    assert "wrong mark" in finding.text


def test_two_points_that_contradict_the_rest_are_told_by_the_worst():
    camera = GroundPlaneCamera(0.05, 1000, 359.5, 1.3, 639.5)
    points = seen_by(camera, 5, 6, 8, 13, 21, 34)
    points[2] = GroundPoint(8.0, points[2].row_px + 25)
    points[4] = GroundPoint(21.0, points[4].row_px - 9)
    assert plausibility(calibrate(points, SIZE, 1.3))


def test_contradicted_prior_is_named():
    camera = GroundPlaneCamera(0.05, 1000, 359.5, 1.3, 639.5)
    true_deg = math.degrees(2 * math.atan(640 / 1000))
    calibration = calibrate(
        seen_by(camera, 5, 12, 30, 45),
        SIZE,
        1.3,
        row_sigma_px=0.01,
        tape_error=0.0,
        field_of_view=Gaussian(math.radians(100), math.radians(3)),
    )
    texts = [f.text for f in plausibility(calibration) if f.kind is FindingKind.PRIOR]
    assert len(texts) == 1
    assert "field of view of 100 ± 3 degrees contradicts" in texts[0]
    assert f"{true_deg:.1f}" in texts[0]


def test_point_outside_the_picture_is_named():
    camera = GroundPlaneCamera(0.05, 1000, 359.5, 1.3, 639.5)
    findings = plausibility(calibrate(seen_by(camera, 3, 12, 30), SIZE, 1.3))
    assert [finding.kind for finding in findings] == [FindingKind.POINT_OUTSIDE]
    assert "outside the picture of 1280x720" in findings[0].text


@pytest.mark.parametrize("row_sigma_px", [0.0, 1e-300, 1e-9])
@pytest.mark.parametrize("tape_error", [0.0, 1e-300])
def test_points_that_a_file_calls_exact_are_judged_as_clicks_of_a_hundredth_of_a_pixel(
    row_sigma_px: float, tape_error: float
):
    camera = GroundPlaneCamera(0.03, 1000.0, 360.0, 1.3, 640.0)
    for points, suspect in ((seen_by(camera, 6, 15, 30, 50), False), (PAPER_POINTS, True)):
        solved = calibrate(points, SIZE, 1.3 if not suspect else 1.225, tape_error=0.0)
        with np.errstate(divide="raise", invalid="raise", over="raise"):
            told = [
                [finding.kind for finding in plausibility(called)]
                for called in (
                    replace(solved, row_sigma_px=row_sigma_px, tape_error=tape_error),
                    replace(solved, row_sigma_px=0.01, tape_error=tape_error),
                )
            ]
        assert told[0] == told[1]
        assert bool(told[0]) == suspect


def test_a_camera_that_has_a_mark_behind_it_is_judged_by_the_marks_as_they_were_clicked():
    """Turned this far up and aside, without its roll it would not see the nearest mark."""
    marks = (
        GroundPoint(4.0, 647.7, 564.6),
        GroundPoint(5.0, 549.5, 704.1),
        GroundPoint(7.0, 441.0, 654.1),
        GroundPoint(20.0, 135.6, 581.4),
    )
    camera = GroundPlaneCamera(-math.pi / 4, 100.0, 359.5, 1.83, 716.8)
    calibration = replace(
        Calibration.from_camera(camera, SIZE),
        points=marks,
        row_sigma_px=1.0,
        orientation=Orientation(1.0, -0.92, 0.02, 0.01),
    )
    assert not all(math.isfinite(row_px) for row_px in level(calibration).straight_rows_px)
    judgement = judge(calibration)
    assert judgement.as_said + sum(s.probability for s in judgement.suspicions) == pytest.approx(1.0)


def level(calibration: Calibration) -> Calibration:
    return replace(calibration, orientation=replace(calibration.orientation, roll_rad=0.0))
