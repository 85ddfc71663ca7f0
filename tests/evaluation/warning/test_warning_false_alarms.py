"""Episodes of warnings on labelled drives, and following at a constant gap."""

import pytest
from drives.kitti_drive import SPEED_MPS, kitti_drive_at_a_standing_car

from fcw.evaluation.warning.false_alarms import FOLLOWINGS, kitti_episodes, run_following
from fcw.evaluation.warning.scenarios import BoxLevel
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel, WarningState


def test_a_standing_car_ahead_is_an_episode_with_its_true_figures(tmp_path):
    folder = kitti_drive_at_a_standing_car(tmp_path, lateral_m=0.0)
    episodes, hours = kitti_episodes(folder, ["0000"], make_policy, 1.0, 0)
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


def test_a_car_parked_beside_the_path_is_none(tmp_path):
    folder = kitti_drive_at_a_standing_car(tmp_path, lateral_m=-3.5)
    episodes, _ = kitti_episodes(folder, ["0000"], make_policy, 1.0, 0)
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
