"""The picture shows what the state says, where the camera puts it, and it never varies."""

import dataclasses

import numpy as np
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st
from searching import examples

from fcw.box import iou
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.acf import AcfDetector
from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from fcw.frame import ImageSize
from fcw.simulation.picture.projection import dynamic_camera, project
from fcw.simulation.picture.renderer import Renderer
from fcw.simulation.picture.vehicles.painter import VehiclePainter
from fcw.simulation.world.road import Lane, LaneMarking, RoadProfile, Swell
from fcw.simulation.world.state import (
    VEHICLE_SIZES,
    EgoState,
    RoadMark,
    RoadsideItem,
    RoadsideKind,
    VehicleKind,
    VehicleState,
    WorldState,
)

pytestmark = pytest.mark.slow

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(
    pitch_rad=0.03, focal_y_px=1000.0, principal_row_px=359.5, height_m=1.3, principal_column_px=639.5
)
LANE_M = 3.6
STRAIGHT = RoadProfile(
    lanes=(Lane(0.0, LANE_M), Lane(LANE_M, LANE_M)),
    markings=(
        LaneMarking(-LANE_M / 2, dashed=False),
        LaneMarking(LANE_M / 2, dashed=True),
        LaneMarking(1.5 * LANE_M, dashed=False),
    ),
    right_edge_m=-LANE_M / 2 - 1.5,
    left_edge_m=1.5 * LANE_M + 1.5,
)
WINDING = dataclasses.replace(
    STRAIGHT, bends=(Swell(-100.0, 400.0, 1 / 500),), grades=(Swell(-100.0, 500.0, 0.03),)
)
PURPLE = (150, 20, 170)
"""The paint of the cars that tests look for: nothing else in the picture has this colour."""


@pytest.fixture(scope="module")
def renderer():
    return Renderer(CAMERA, SIZE, world_seed=5)


@pytest.fixture
def without_shadows(monkeypatch):
    monkeypatch.setattr(VehiclePainter, "paint_shadows", lambda self, view, vehicle: None)


def world(*vehicles: VehicleState, **changes) -> WorldState:
    state = WorldState(1_000_000_000, EgoState(s_m=0.0), tuple(vehicles), STRAIGHT)
    return dataclasses.replace(state, **changes)


def car(
    distance_m: float, lateral_m: float = 0.0, kind: VehicleKind = VehicleKind.HATCHBACK, **changes
) -> VehicleState:
    vehicle = VehicleState(
        name=f"{distance_m} {lateral_m}",
        kind=kind,
        size=VEHICLE_SIZES[kind],
        color=PURPLE,
        seed=7,
        s_m=distance_m,
        lateral_m=lateral_m,
    )
    return dataclasses.replace(vehicle, **changes)


def changed(one: np.ndarray, other: np.ndarray, threshold: int = 0) -> np.ndarray:
    """Where two pictures of the same noise differ."""
    return np.abs(one.astype(int) - other.astype(int)).max(axis=2) > threshold


def extent(mask: np.ndarray) -> tuple[float, float, float, float]:
    """Left, top, right and bottom edge of what is set, in continuous pixel coordinates."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    return columns[0] - 0.5, rows[0] - 0.5, columns[-1] + 0.5, rows[-1] + 0.5


def test_the_same_seed_and_state_give_the_same_picture_bit_for_bit(renderer):
    roadside = tuple(
        RoadsideItem(
            kind=kind, s_m=s_m, lateral_m=-6.5, width_m=2.0, height_m=7.0, length_m=9.0, clearance_m=5.0
        )
        for s_m, kind in enumerate(RoadsideKind, start=20)
    )
    state = world(car(12.0), road=WINDING, roadside=roadside)
    renderer.render(world(car(30.0), time_ns=5))  # what was rendered before leaves no trace
    picture = renderer.render(state)
    np.testing.assert_array_equal(picture, Renderer(CAMERA, SIZE, world_seed=5).render(state))
    assert not np.array_equal(picture, Renderer(CAMERA, SIZE, world_seed=4).render(state))


def test_noise_differs_from_frame_to_frame_and_is_as_weak_as_a_cameras(renderer):
    one, other = (renderer.render(world(time_ns=time_ns)).astype(float) for time_ns in (0, 33_366_667))
    difference = one[500:, 300:900] - other[500:, 300:900]
    assert 1.0 < difference.std() / np.sqrt(2) < 3.0


@pytest.mark.parametrize("kind", VehicleKind)
@pytest.mark.parametrize(("distance_m", "lateral_m"), [(9.0, 0.0), (22.0, 0.4), (50.0, -0.3)])
@pytest.mark.usefixtures("without_shadows")
def test_a_rear_is_painted_where_the_camera_puts_its_box(renderer, kind, distance_m, lateral_m):
    vehicle = car(distance_m, lateral_m, kind)
    # The flanks are seen beside the rear unless the car is so short that it ends there.
    vehicle = dataclasses.replace(vehicle, size=dataclasses.replace(vehicle.size, length_m=0.01))
    left, top, right, bottom = extent(changed(renderer.render(world(vehicle)), renderer.render(world()), 8))
    box = CAMERA.ground_box(distance_m, lateral_m, vehicle.size.width_m, vehicle.size.height_m)
    foot_px = CAMERA.row_at(distance_m + vehicle.size.overhang_m)
    assert left == pytest.approx(box.x, abs=1.5)
    assert right == pytest.approx(box.right, abs=1.5)
    assert top == pytest.approx(box.y, abs=1.5)
    assert bottom == pytest.approx(foot_px, abs=1.5)


@pytest.mark.usefixtures("without_shadows")
def test_pitch_and_bounce_move_the_rear_as_they_move_its_box(renderer):
    ego = EgoState(s_m=0.0, pitch_deviation_rad=0.02, bounce_m=0.04)
    vehicle = car(15.0)
    now = dynamic_camera(CAMERA, ego.pitch_deviation_rad, ego.bounce_m)
    box = now.ground_box(15.0, 0.0, vehicle.size.width_m, vehicle.size.height_m)
    foot_m = 15.0 + vehicle.size.overhang_m
    assert abs(now.row_at(foot_m) - CAMERA.row_at(foot_m)) > 10
    empty, full = renderer.render(world(ego=ego)), renderer.render(world(vehicle, ego=ego))
    _, top, _, bottom = extent(changed(full, empty, 8))
    assert top == pytest.approx(box.y, abs=1.5)
    assert bottom == pytest.approx(now.row_at(foot_m), abs=1.5)


@pytest.mark.parametrize("kind", VehicleKind)
@pytest.mark.parametrize("heading_rad", [np.pi / 2, -np.pi / 2])
def test_who_crosses_towards_our_path_shows_its_front_and_not_its_rear(renderer, kind, heading_rad):
    vehicle = car(15.0, -np.sign(heading_rad) * 8.0, kind, heading_rad=heading_rad, color=(120, 120, 120))
    dark = renderer.render(world(vehicle))
    lit = renderer.render(world(dataclasses.replace(vehicle, brake_lamps=True)))
    assert not changed(lit, dark).any(), "its rear looks away"
    # And away from our path its lamps are seen.
    leaving = car(15.0, np.sign(heading_rad) * 3.0, kind, heading_rad=heading_rad, color=(120, 120, 120))
    lit = renderer.render(world(dataclasses.replace(leaving, brake_lamps=True)))
    assert changed(lit, renderer.render(world(leaving))).any()


@pytest.mark.parametrize("kind", VehicleKind)
@pytest.mark.usefixtures("without_shadows")
def test_a_vehicle_across_is_painted_as_far_as_its_far_end_reaches(renderer, kind):
    half_m, length_m = VEHICLE_SIZES[kind].width_m / 2, VEHICLE_SIZES[kind].length_m
    vehicle = car(15.0, -5.0 - length_m, kind, heading_rad=np.pi / 2)
    left, _, right, bottom = extent(changed(renderer.render(world(vehicle)), renderer.render(world()), 8))
    # Its front looks at us, and ends at the corner that is farther from us, 40 px beside the nearer one. The
    # seam of its panes is 10 px wide.
    front = CAMERA.ground_box(15.0 + half_m, -5.0, 0.01, 1.0)
    rear = CAMERA.ground_box(15.0 - half_m, -5.0 - length_m, 0.01, 1.0)
    assert left == pytest.approx(front.x, abs=12.0)
    assert right == pytest.approx(min(rear.right, SIZE.width - 0.5), abs=12.0)
    assert bottom == pytest.approx(CAMERA.row_at(15.0 - half_m), abs=3.0)


@pytest.mark.parametrize("kind", VehicleKind)
def test_brake_lamps_light_up_red_and_nothing_else_changes(renderer, kind):
    vehicle = car(10.0, kind=kind, color=(120, 120, 120))
    dark = renderer.render(world(vehicle)).astype(int)
    lit = renderer.render(world(dataclasses.replace(vehicle, brake_lamps=True))).astype(int)
    difference = lit - dark
    where = np.abs(difference).max(axis=2) > 0
    box = CAMERA.ground_box(10.0, 0.0, vehicle.size.width_m, vehicle.size.height_m)
    left, top, right, bottom = extent(where)
    assert left >= box.x - 2
    assert right <= box.right + 2
    assert top >= box.y - 2
    assert bottom < box.bottom - 0.1 * box.h
    assert 0.005 < where.sum() / (box.w * box.h) < 0.12
    strong = np.abs(difference).max(axis=2) > 60
    assert difference[strong][:, 2].min() > 0
    assert lit[strong][:, 2].mean() > 200
    assert (lit[strong][:, 2] > lit[strong][:, 1] + 20).all()
    # One lamp at each side.
    columns = np.flatnonzero(strong.any(axis=0))
    assert columns[0] < box.x + 0.25 * box.w
    assert columns[-1] > box.right - 0.25 * box.w


def test_a_nearer_vehicle_hides_a_farther_one_in_whatever_order_they_come(renderer):
    van, saloon = car(12.0, kind=VehicleKind.VAN, color=(40, 40, 40)), car(40.0, kind=VehicleKind.SALOON)
    both = renderer.render(world(saloon, van))
    np.testing.assert_array_equal(both, renderer.render(world(van, saloon)))
    box = CAMERA.ground_box(40.0, 0.0, saloon.size.width_m, saloon.size.height_m)
    # Below the bumper both are dark.
    bumper_px = CAMERA.ground_box(40.0, 0.0, saloon.size.width_m, saloon.size.clearance_m).y
    inside = (slice(int(box.y), int(bumper_px)), slice(int(box.x) + 1, int(box.right)))
    np.testing.assert_array_equal(both[inside], renderer.render(world(van))[inside])
    assert changed(both, renderer.render(world(saloon)), 20)[inside].mean() > 0.8


@pytest.mark.parametrize(("lateral_m", "hidden"), [(-4.5, False), (2.0, True)])
def test_a_barrier_hides_what_is_behind_it_only(renderer, lateral_m, hidden):
    """A rail to the right of the car runs behind it, one between us and the car in front of it."""
    vehicle = car(9.0, LANE_M if hidden else -2.0, size=dataclasses.replace(VEHICLE_SIZES[VehicleKind.VAN]))
    barrier = RoadsideItem(
        kind=RoadsideKind.BARRIER, s_m=-40.0, lateral_m=lateral_m, width_m=0.3, height_m=0.75, length_m=200.0
    )
    alone, beside = renderer.render(world(vehicle)), renderer.render(world(vehicle, roadside=(barrier,)))
    box = CAMERA.ground_box(9.0, vehicle.lateral_m, vehicle.size.width_m, vehicle.size.height_m)
    # The middle of the rear: between the wheels one looks through.
    rear = (
        slice(round(box.y + 0.3 * box.h), round(box.y + 0.8 * box.h)),
        slice(round(box.x + 0.2 * box.w), round(box.x + 0.8 * box.w)),
    )
    assert changed(alone, beside, 3)[rear].any() == hidden


def test_a_crest_hides_what_stands_beyond_it(renderer):
    """Up 8 %, then down as steeply: of a saloon 150 m away not even the roof is seen."""
    road = dataclasses.replace(STRAIGHT, grades=(Swell(-80.0, 160.0, 0.08), Swell(80.0, 160.0, -0.08)))
    vehicle = car(150.0, kind=VehicleKind.SALOON)
    roof = world(road=road).road_points(150.0, 0.0, vehicle.size.height_m)
    crest = world(road=road).road_points(np.arange(1.0, 149.0), 0.0)
    assert project(roof, CAMERA)[1] > project(crest, CAMERA)[1].min()
    hidden = changed(renderer.render(world(vehicle, road=road)), renderer.render(world(road=road)), 3)
    assert not hidden.any()
    assert changed(renderer.render(world(vehicle)), renderer.render(world()), 3).any()


@pytest.mark.parametrize("kind", [RoadsideKind.TREE, RoadsideKind.BUSH, RoadsideKind.POST, RoadsideKind.SIGN])
def test_what_stands_beside_the_road_stands_where_it_is_projected(renderer, kind):
    item = RoadsideItem(
        kind=kind, s_m=25.0, lateral_m=-7.0, width_m=1.5, height_m=3.0, clearance_m=2.0, seed=3
    )
    state = world(road=WINDING, roadside=(item,))
    shown = changed(renderer.render(state), renderer.render(world(road=WINDING)), 40)
    foot, top = state.road_points(25.0, -7.0, np.array((0.0, 3.0)))
    (column, _), (low, high) = project(np.stack((foot, top)), CAMERA)
    # Its shadow on the ground is fainter than it.
    left, upper, right, lower = extent(shown[: round(low) + 3])
    # Leaves do not fill their outline up to the last twig.
    assert upper == pytest.approx(high, abs=0.2 * (low - high))
    assert upper > high - 2
    assert lower == pytest.approx(low, abs=4)
    assert left > column - 50
    assert right < column + 50


def test_a_bridge_spans_the_road_and_darkens_the_car_below_it(renderer):
    bridge = RoadsideItem(
        kind=RoadsideKind.BRIDGE,
        s_m=20.0,
        lateral_m=0.0,
        width_m=30.0,
        height_m=7.4,
        length_m=9.0,
        clearance_m=5.2,
    )
    vehicle = car(24.0)
    empty, bridged = renderer.render(world(vehicle)), renderer.render(world(vehicle, roadside=(bridge,)))
    state = world()
    (column, _), (low, high) = project(state.road_points(20.0, 0.0, np.array((5.2, 7.4))), CAMERA)
    shown = changed(bridged, empty, 25)[:, round(float(column))]
    assert shown[round(float(high)) + 3 : round(float(low)) - 3].all()
    assert not shown[: round(float(high)) - 3].any()
    box = CAMERA.ground_box(24.0, 0.0, vehicle.size.width_m, vehicle.size.height_m)
    body = (
        slice(round(box.y + 0.4 * box.h), round(box.y + 0.7 * box.h)),
        slice(round(box.x) + 5, round(box.right) - 5),
    )
    assert bridged[body].mean() < 0.95 * empty[body].mean()


@pytest.mark.parametrize("distance_m", [8.0, 20.0, 40.0])
def test_marks_lie_in_the_rows_of_the_camera(renderer, distance_m):
    mark = RoadMark(distance_m, 0.0, 0.6, 1.0)
    difference = renderer.render(world(marks=(mark,))).astype(int) - renderer.render(world()).astype(int)
    column = difference[:, 635:645].sum(axis=2).mean(axis=1).clip(0)
    # Light is conserved: half of what one edge's row lacks, the next one has.
    edge_rows = [CAMERA.row_at(distance_m + along) for along in (0.3, -0.3)]
    middle = (column * np.arange(SIZE.height)).sum() / column.sum()
    assert middle == pytest.approx(np.mean(edge_rows), abs=0.1)
    assert column.sum() / column.max() >= 0.9 * min(edge_rows[1] - edge_rows[0], 1.0)


def test_a_dashed_line_begins_and_ends_where_the_camera_sees_it(renderer):
    """The dash from s = 12 to 16 m at the left of our lane, against the same road without it."""
    plain = dataclasses.replace(STRAIGHT, markings=())
    difference = renderer.render(world()).astype(int) - renderer.render(world(road=plain)).astype(int)
    rows = np.arange(int(CAMERA.row_at(20.0)), int(CAMERA.row_at(8.5)))
    columns = np.round([CAMERA.column_at(LANE_M / 2, CAMERA.distance_at(float(row))) for row in rows]).astype(
        int
    )
    painted = rows[difference.max(axis=2)[rows, columns] > 30]
    assert painted[0] - 0.5 == pytest.approx(CAMERA.row_at(16.0), abs=1.2)
    assert painted[-1] + 0.5 == pytest.approx(CAMERA.row_at(12.0), abs=1.2)


@pytest.mark.parametrize("ahead_m", [10.0, 25.0, 60.0])
def test_a_winding_hilly_road_goes_where_its_points_are_projected(renderer, ahead_m):
    """The solid line at the right, found as the brightest place of a row near its projected point."""
    state = world(road=WINDING)
    picture = renderer.render(state).astype(int)
    bare = renderer.render(world(road=dataclasses.replace(WINDING, markings=()))).astype(int)
    points = state.road_points(ahead_m, np.array((-LANE_M / 2 + 0.075, -LANE_M / 2 - 0.075)))
    (left, right), (row, _) = project(points, CAMERA)
    brighter = (picture - bare).sum(axis=2)[round(float(row))].clip(0)
    near = slice(int(left) - 25, int(right) + 25)
    middle = (brighter[near] * np.arange(near.start, near.stop)).sum() / brighter[near].sum()
    # The row is rounded, and the line runs askew.
    assert middle == pytest.approx((left + right) / 2, abs=2.0)
    straight_column = CAMERA.column_at(-LANE_M / 2, ahead_m)
    assert ahead_m < 20 or abs(middle - straight_column) > 3


@examples(12, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    distance_m=st.sampled_from((-8.0, -2.0, 0.2, 1.0, 3.0, 150.0, 390.0)),
    lateral_m=st.sampled_from((-7.2, -3.0, 0.0, 3.6, 30.0)),
    kind=st.sampled_from(tuple(VehicleKind)),
    oncoming=st.booleans(),
    heading_rad=st.floats(-0.3, 0.3),
)
def test_vehicles_beside_very_near_and_far_can_be_painted(
    renderer, distance_m, lateral_m, kind, oncoming, heading_rad
):
    vehicle = car(distance_m, lateral_m, kind, oncoming=oncoming, heading_rad=heading_rad)
    picture = renderer.render(world(vehicle))
    assert picture.shape == (SIZE.height, SIZE.width, 3)
    # What is outside the picture's part that a vehicle can reach stays as it was.
    if distance_m >= 150:
        assert changed(picture, renderer.render(world()), 3).sum() < 0.01 * picture.size


def test_a_vehicle_very_near_fills_the_picture_and_one_far_away_some_pixels(renderer):
    empty = renderer.render(world())
    near = changed(renderer.render(world(car(3.0, kind=VehicleKind.VAN))), empty, 8)
    far = changed(renderer.render(world(car(150.0, kind=VehicleKind.VAN))), empty, 8)
    size = VEHICLE_SIZES[VehicleKind.VAN]
    assert near.mean() > 0.3
    assert far.sum() == pytest.approx(size.width_m * size.height_m * (1000 / 150) ** 2, rel=0.5)


def test_the_shipped_detector_finds_the_cars_and_little_else(renderer):
    model = Model.load(SHIPPED_MODEL_PATH)
    detector = AcfDetector(model, Calibration.from_camera(CAMERA, SIZE))
    cars = [VehicleKind.SALOON, VehicleKind.HATCHBACK, VehicleKind.VAN]
    colors = [(120, 62, 38), (222, 224, 224), (40, 40, 42), (34, 30, 128)]
    found, false = 0, 0
    cases = [(kind, distance_m) for kind in cars for distance_m in (8.0, 14.0, 25.0, 45.0)]
    for index, (kind, distance_m) in enumerate(cases):
        vehicle = car(distance_m, 0.2, kind, color=colors[index % 4], seed=index, brake_lamps=index % 3 == 0)
        box = CAMERA.ground_box(distance_m, 0.2, vehicle.size.width_m, vehicle.size.height_m)
        overlaps = [iou(d.box, box) for d in detector.detect(renderer.render(world(vehicle)))]
        found += max(overlaps, default=0.0) >= 0.5
        false += sum(overlap < 0.5 for overlap in overlaps)
    assert found >= len(cases) - 1
    assert false <= 1
