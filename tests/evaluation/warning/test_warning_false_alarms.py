"""Episodes of warnings on labelled drives, and following at a constant gap."""

import math

import pytest

from fcw.evaluation.warning.false_alarms import FOLLOWINGS, kitti_episodes, run_following
from fcw.evaluation.warning.scenarios import BoxLevel
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel, WarningState

FOCAL_PX, U0, V0, HEIGHT_M, LENGTH_M = 720.0, 611.5, 184.5, 1.65, 4.0
SPEED_MPS = 10.0


@pytest.fixture
def drive(tmp_path):
    """Makes a KITTI folder: we drive straight at 10 m/s towards a standing car, from 60 m to 5 m."""

    def make(lateral_m):
        for name in ("label_02", "calib", "poses"):
            (tmp_path / name).mkdir()
        (tmp_path / "calib" / "0000.txt").write_text(f"P2: {FOCAL_PX} 0 {U0} 0 0 {FOCAL_PX} {V0} 0 0 0 1 0\n")
        labels, poses = [], []
        for frame in range(56):
            rear_m = 60 - frame * SPEED_MPS / 10
            left, right = (U0 + FOCAL_PX * (-lateral_m + side) / rear_m for side in (-0.9, 0.9))
            top, bottom = (V0 + FOCAL_PX * (HEIGHT_M - up) / rear_m for up in (1.5, 0.0))
            labels.append(
                f"{frame} 7 Car 0 0 0 {left} {top} {right} {bottom} 1.5 1.8 {LENGTH_M} "
                f"{-lateral_m} {HEIGHT_M} {rear_m + LENGTH_M / 2} {-math.pi / 2}"
            )
            poses.append(f"1 0 0 0 0 1 0 0 0 0 1 {frame * SPEED_MPS / 10}")
        (tmp_path / "label_02" / "0000.txt").write_text("\n".join(labels))
        (tmp_path / "poses" / "0000.txt").write_text("\n".join(poses))
        return tmp_path

    return make


def test_a_standing_car_ahead_is_an_episode_with_its_true_figures(drive):
    episodes, hours = kitti_episodes(drive(0.0), ["0000"], make_policy, 1.0, 0)
    assert hours == pytest.approx(5.6 / 3600)
    (episode,) = episodes
    assert (episode.vehicle, episode.oncoming, episode.on_course) == ("Car 7", False, True)
    assert episode.own_mps == pytest.approx(SPEED_MPS)
    assert episode.distance_m is not None
    assert episode.distance_m == pytest.approx(60 - SPEED_MPS * episode.start_s, abs=0.01)
    assert episode.ttc_s == pytest.approx(episode.distance_m / SPEED_MPS)
    assert episode.required_mps2 == pytest.approx(SPEED_MPS**2 / (2 * episode.distance_m))
    assert episode.miss_m == pytest.approx(0, abs=0.01)
    # The driver of 1.2 s and 0.4 g needs 24.7 m; nobody needs a warning above 4 s.
    assert 24.7 <= episode.distance_m <= 40


def test_a_car_parked_beside_the_path_is_none(drive):
    episodes, _ = kitti_episodes(drive(-3.5), ["0000"], make_policy, 1.0, 0)
    assert episodes == ()


class Always:
    """Warns of nothing in particular, in every second frame."""

    name = "always"

    def __init__(self):
        self.on = False

    def update(self, time_ns, threats, ego_speed_mps):
        self.on = not self.on
        return WarningState(WarningLevel.WARNING if self.on else WarningLevel.NONE)


def test_every_rise_while_following_counts_and_the_hours_are_shared():
    hours = len(FOLLOWINGS) * 20 / 3600
    results = run_following(Always, BoxLevel(frame_rate_hz=10.0), hours, 0)
    assert [result.warnings for result in results] == [100] * len(FOLLOWINGS)
    assert sum(result.hours for result in results) == pytest.approx(hours)
