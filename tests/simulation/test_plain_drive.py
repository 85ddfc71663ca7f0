"""The plain drive: its motion is physics, its pictures show what its truth says, and it never varies."""

import csv
import itertools

import av
import numpy as np
import pytest

from fcw.camera.calibration import Calibration
from fcw.simulation.plain_drive import (
    ACTORS,
    CAMERA,
    EGO,
    IMAGE_SIZE,
    REFERENCE_OFFSET_M,
    Motion,
    exact_calibration,
    render_plain_drive,
    truth_at,
    write_plain_drive,
)
from fcw.simulation.scene import PlacedVehicle, Scene
from fcw.warning.ego_speed import EgoSpeed


@pytest.fixture(scope="module")
def scene():
    return Scene(CAMERA, IMAGE_SIZE, seed=1)


def test_motion_is_uniformly_accelerated_in_each_phase():
    motion = Motion(10.0, 20.0, ((1.0, -4.0), (3.0, 0.0)))
    # 20 m in the first second, 2 * 20 - 4 * 4 / 2 = 32 m in the next two, then 12 m/s.
    assert motion.at(0.0) == pytest.approx((10, 20, 0))
    assert motion.at(2.0) == pytest.approx((10 + 20 + 18, 16, -4))
    assert motion.at(5.0) == pytest.approx((10 + 20 + 32 + 24, 12, 0))


@pytest.mark.parametrize("motion", [EGO, *(actor.motion for actor in ACTORS)])
def test_speed_is_the_derivative_of_position_and_never_negative(motion):
    for time_s in np.linspace(0.05, 23.9, 200):
        slope = (motion.at(time_s + 1e-4)[0] - motion.at(time_s - 1e-4)[0]) / 2e-4
        assert slope == pytest.approx(motion.at(time_s)[1], abs=1e-3)
        assert motion.at(time_s)[1] > 0


def test_the_lead_brakes_hard_and_is_never_touched():
    lead = [truth_at(time_s)[0] for time_s in np.arange(0, 24, 0.05)]
    assert min(vehicle.distance_m for vehicle in lead) > 2
    shortest_ttc_s = min(
        vehicle.distance_m / vehicle.closing_speed_mps for vehicle in lead if vehicle.closing_speed_mps > 1
    )
    assert shortest_ttc_s < 2.0


def test_two_renderings_are_the_same_bit_for_bit_and_another_seed_is_not():
    first, again, other = (list(itertools.islice(render_plain_drive(seed, 1), 2)) for seed in (3, 3, 4))
    for (one, truth), (two, same_truth) in zip(first, again, strict=True):
        assert one.time_ns == two.time_ns
        assert truth == same_truth
        np.testing.assert_array_equal(one.image, two.image)
    assert not np.array_equal(first[0][0].image, other[0][0].image)


@pytest.mark.parametrize(("distance_m", "lateral_m"), [(8.0, 0.0), (25.0, 0.0), (40.0, 0.8)])
def test_a_vehicle_is_painted_where_the_camera_puts_its_box(scene, distance_m, lateral_m):
    body = ACTORS[0].body
    empty = scene.paint(50.0, ()).astype(int)
    painted = scene.paint(50.0, (PlacedVehicle(body, distance_m, lateral_m, False),)).astype(int)
    # The paint is blue and the shadow has no colour: what became bluer than the road is the body.
    change = np.abs(painted - empty).max(axis=2) > 40
    box = CAMERA.ground_box(distance_m, lateral_m, body.width_m, body.height_m)
    columns = np.flatnonzero(change[: round(box.y + 0.6 * box.h)].any(axis=0))
    rows = np.flatnonzero(change.any(axis=1))
    assert columns[0] == pytest.approx(box.x, abs=1.5)
    assert columns[-1] == pytest.approx(box.right, abs=1.5)
    assert rows[0] == pytest.approx(box.y, abs=1.5)


def test_lane_markings_move_with_the_own_speed(scene):
    start = scene.paint(0.0, ())
    # A dash and its gap are 12 m: the road looks the same after 96 m, a period of all its textures.
    below = int(CAMERA.row_at(30.0))
    assert not np.array_equal(start[below:], scene.paint(6.0, ())[below:])
    dashes = start[below:, 300:980].max(axis=2) > 180
    moved = scene.paint(12.0, ())[below:, 300:980].max(axis=2) > 180
    assert (dashes & moved).sum() > 0.9 * (dashes | moved).sum()


def test_the_calibration_has_the_true_distances_from_the_bumper():
    calibration = exact_calibration()
    for distance_m in (5.0, 20.0, 80.0):
        row_px = CAMERA.row_at(distance_m + REFERENCE_OFFSET_M)
        assert calibration.distance_at(row_px) == pytest.approx(distance_m, rel=1e-9)


def test_written_files_can_be_relayed_read_and_agree(tmp_path):
    write_plain_drive(tmp_path, duration_s=1)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "drive.calibration.yaml",
        "drive.mp4",
        "drive.speed.csv",
        "truth.csv",
    ]
    with av.open(str(tmp_path / "drive.mp4")) as container:
        stream = container.streams.video[0]
        packets = [packet for packet in container.demux(stream) if packet.size]
        assert [packet.pts for packet in packets] == [packet.dts for packet in packets]
        assert len(packets) == 30
        assert float(stream.average_rate or 0) == 30
    assert Calibration.load(tmp_path / "drive.calibration.yaml").image_size == IMAGE_SIZE
    with (tmp_path / "truth.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 30 * len(ACTORS)
    speed = EgoSpeed.read_csv(tmp_path / "drive.speed.csv")
    for row in rows:
        assert speed.at(round(float(row["time_s"]) * 1e9)) == pytest.approx(float(row["ego_speed_mps"]))
    lead = rows[-len(ACTORS)]
    truth = truth_at(29 / 30)[0]
    assert truth.box is not None
    assert float(lead["distance_m"]) == pytest.approx(truth.distance_m, abs=1e-4)
    assert float(lead["box_y"]) == pytest.approx(truth.box.y, abs=0.01)


def test_own_speed_between_its_samples_is_exact():
    knots = (0.0, *(start_s for start_s, _ in EGO.phases), 24.0)
    speed = EgoSpeed(knots, tuple(EGO.at(time_s)[1] for time_s in knots))
    for time_s in np.linspace(0, 24, 97):
        assert speed.at(round(time_s * 1e9)) == pytest.approx(EGO.at(time_s)[1], abs=1e-6)
