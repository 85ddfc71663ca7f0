"""The truth of an instant against the camera's own geometry, and its file."""

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.errors import UserError
from fcw.simulation.picture.projection import dynamic_camera
from fcw.simulation.truth.file import read_truth, write_truth
from fcw.simulation.truth.truth import FrameTruth, VehicleTruth, frame_truth, warning_is_due
from fcw.simulation.world.road import Lane, RoadProfile
from fcw.simulation.world.scenario import IMAGE_SIZE
from fcw.simulation.world.state import EgoState, VehicleKind, VehicleSize, VehicleState, WorldState

CAMERA = GroundPlaneCamera(0.03, 1000.0, 359.5, 1.3, 639.5)
OFFSET_M = 1.6
ROAD = RoadProfile((Lane(0.0, 3.5),), (), -3.0, 3.0)
SIZE = VehicleSize(1.8, 1.5, 4.5, overhang_m=0.8, clearance_m=0.3)


def vehicle(name: str, distance_m: float, lateral_m: float = 0.0, **more) -> VehicleState:
    state = VehicleState(
        name=name,
        kind=VehicleKind.SALOON,
        size=SIZE,
        color=(0, 0, 0),
        seed=0,
        s_m=distance_m + OFFSET_M,
        lateral_m=lateral_m,
    )
    return dataclasses.replace(state, **more)


def truth_of(*vehicles: VehicleState, **ego) -> FrameTruth:
    state = WorldState(0, EgoState(s_m=0.0, **ego), vehicles, ROAD)
    return frame_truth(state, CAMERA, IMAGE_SIZE, OFFSET_M)


@given(
    st.floats(3.0, 100.0), st.floats(-8.0, 8.0), st.floats(-0.02, 0.02), st.floats(-0.05, 0.05)
)  # fmt: skip
def test_a_box_is_the_dynamic_cameras_own_down_to_the_tyres_or_the_bumper(
    distance_m, lateral_m, pitch_rad, bounce_m
):
    truth = truth_of(vehicle("a", distance_m, lateral_m), pitch_deviation_rad=pitch_rad, bounce_m=bounce_m)
    now = dynamic_camera(CAMERA, pitch_rad, bounce_m)
    rear_m = distance_m + OFFSET_M
    rear = now.ground_box(rear_m, lateral_m, SIZE.width_m, SIZE.height_m)
    bumper = now.ground_box(rear_m, lateral_m, SIZE.width_m, SIZE.clearance_m)
    bottom_px = max(bumper.y, now.row_at(rear_m + SIZE.overhang_m))
    box = truth.vehicles[0].box
    assert (box.y, box.bottom) == pytest.approx((rear.y, bottom_px), abs=1e-6)
    # By the camera's pitch the bumper is a little farther along its axis than the foot of the same plane,
    # which draws both sides towards the axis by the same part of how far they are from it.
    aside_px = max(abs(side_px - now.principal_column_px) for side_px in (rear.x, rear.right))
    assert (box.x, box.right) == pytest.approx((rear.x, rear.right), abs=0.01 * aside_px)
    assert truth.horizon_row_px == pytest.approx(now.horizon_row_px)


def test_the_body_box_holds_the_near_face_and_reaches_as_far_as_the_far_one():
    (seen,) = truth_of(vehicle("a", 10, 3.5)).vehicles
    body, face = seen.body_box, seen.box
    far = CAMERA.ground_box(10 + SIZE.length_m + OFFSET_M, 3.5, SIZE.width_m, SIZE.height_m)
    assert body.x == pytest.approx(face.x, abs=1e-3)
    assert body.bottom == pytest.approx(face.bottom, abs=1e-3)
    assert body.right == pytest.approx(far.right, abs=1e-3), "its right side is in sight"


@pytest.mark.parametrize("to_left", [True, False])
@pytest.mark.parametrize("lateral_m", [-7.0, 0.0, 7.0])
def test_of_a_vehicle_that_stands_across_it_is_its_near_side(to_left, lateral_m):
    heading_rad = math.copysign(math.pi / 2, 1 if to_left else -1)
    (seen,) = truth_of(vehicle("a", 20.0, lateral_m, heading_rad=heading_rad)).vehicles
    assert seen.distance_m == pytest.approx(20.0 - SIZE.width_m / 2)
    middle_m = lateral_m + math.copysign(SIZE.length_m / 2, heading_rad)
    assert (seen.lateral_m, seen.path_lateral_m) == pytest.approx((middle_m, middle_m))
    side_m = seen.distance_m + OFFSET_M
    side = CAMERA.ground_box(side_m, middle_m, SIZE.length_m, SIZE.height_m)
    # As above, the pitch draws both ends towards the axis by a hundredth.
    assert (seen.box.x, seen.box.right) == pytest.approx((side.x, side.right), abs=0.01 * 640)
    assert seen.box.bottom == pytest.approx(CAMERA.row_at(side_m), abs=0.5), "its tyres stand at its side"
    assert seen.visible_fraction == 1.0


def test_a_face_that_looks_away_is_not_seen():
    # It turns to our left, far to our right: we see its left side and its front.
    (seen,) = truth_of(vehicle("a", 15.0, -12.0, heading_rad=0.75)).vehicles
    assert seen.visible_fraction == 0.0
    assert seen.body_box.w > seen.box.w


@given(st.floats(0.0, 30.0), st.floats(-30.0, 30.0), st.floats(1.0, 80.0))
def test_distance_closing_speed_and_ttc_are_from_the_bumper(ego_mps, other_mps, distance_m):
    (seen,) = truth_of(vehicle("a", distance_m, speed_mps=other_mps), speed_mps=ego_mps).vehicles
    assert seen.distance_m == pytest.approx(distance_m)
    assert seen.closing_speed_mps == ego_mps - other_mps
    if ego_mps > other_mps:
        assert seen.ttc_s == pytest.approx(distance_m / (ego_mps - other_mps))
    else:
        assert seen.ttc_s is None


def test_what_hides_a_vehicle_is_nearer_and_in_front_of_it():
    near, far = vehicle("near", 10), vehicle("far", 30)
    truth = truth_of(far, near)
    assert [v.name for v in truth.vehicles] == ["near", "far"]
    assert truth.vehicles[0].visible_fraction == 1.0
    # The near roof is 0.2 m above the camera: it hides all of a car as high behind it but the rear's top.
    assert truth.vehicles[1].visible_fraction < 0.1
    beside = truth_of(near, vehicle("far", 30, 3.5))
    assert beside.vehicles[1].visible_fraction == 1.0


def test_half_a_car_covers_half_a_car():
    # Same distance from the camera's axis: at twice the depth an offset is half as wide in the picture.
    depth_m = 10 + OFFSET_M
    near = vehicle("near", 10, 0.0, size=VehicleSize(1.8, 3.0, 0.01, 0.0, 0.0))
    far = vehicle("far", 2 * depth_m - OFFSET_M, 1.8)
    # The near one covers lateral -1.8 to 1.8 at the far one's depth, which reaches from 0.9 to 2.7.
    assert truth_of(near, far).vehicles[1].visible_fraction == pytest.approx(0.5, abs=0.03)


def test_a_face_half_outside_the_picture_is_half_visible():
    # The picture's left border at a depth of 10 m is 6.4 m to the left.
    (seen,) = truth_of(vehicle("a", 10 - OFFSET_M - 1.3 * math.tan(0.03), 6.4)).vehicles
    assert seen.visible_fraction == pytest.approx(0.5, abs=0.03)


def test_the_lead_is_the_nearest_in_our_path_that_does_not_come_towards_us():
    truth = truth_of(
        vehicle("beside", 10, 3.5),
        vehicle("oncoming", 15, 0.5, oncoming=True, speed_mps=-20.0),
        vehicle("lead", 20, -0.5),
        vehicle("next", 40),
    )
    assert truth.lead is not None
    assert truth.lead.name == "lead"
    assert truth_of(vehicle("behind", -10)).lead is None


def test_a_warning_is_due_at_the_gap_that_the_driver_needs():
    # 10 m/s: 1.2 s of it, and 100 / (2 * 0.4 g).
    needed_m = 12 + 100 / (2 * 0.4 * 9.80665)
    nearer, farther = (
        truth_of(vehicle("a", needed_m + more, speed_mps=5.0), speed_mps=15.0).vehicles[0]
        for more in (-0.01, 0.01)
    )
    assert warning_is_due(nearer)
    assert not warning_is_due(farther)
    assert not warning_is_due(truth_of(vehicle("a", 1.0, speed_mps=5.0), speed_mps=5.0).vehicles[0])


def test_a_file_gives_back_what_was_written(tmp_path):
    frames = [
        truth_of(vehicle("a", 10, speed_mps=12.5), vehicle("b, far", 40, 3.5, oncoming=True), speed_mps=15.0),
        dataclasses.replace(truth_of(), time_ns=33_333_333),
    ]
    write_truth(tmp_path / "truth.csv", frames)
    again = read_truth(tmp_path / "truth.csv")
    assert [frame.time_ns for frame in again] == [0, 33_333_333]
    assert [[v.name for v in frame.vehicles] for frame in again] == [["a", "b, far"], []]
    for one, two in zip(frames[0].vehicles, again[0].vehicles, strict=True):
        for field in dataclasses.fields(VehicleTruth):
            value, read = getattr(one, field.name), getattr(two, field.name)
            if isinstance(value, float):
                assert read == pytest.approx(value, abs=1e-3)
            elif field.name not in ("box", "body_box"):
                assert read == value


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: "a,b\n1,2\n", "the first line must be frame,time_s"),
        (
            lambda text: text.replace("10.0000", "near", 1),
            "line 2: could not convert string to float: 'near'",
        ),
    ],
)
def test_a_damaged_file_is_named_with_its_line(tmp_path, change, message):
    path = tmp_path / "truth.csv"
    write_truth(path, [truth_of(vehicle("a", 10))])
    path.write_text(change(path.read_text()))
    with pytest.raises(UserError) as error:
        read_truth(path)
    assert message in str(error.value)
    assert str(path) in str(error.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(UserError, match="make it with `fcw simulate`"):
        read_truth(tmp_path / "truth.csv")
