"""How often people would be warned in ordinary traffic, an hour, by policy and timing.

All policies judge the same threats, so that they differ by their rules alone.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fcw.evaluation.distance.kitti_tracking import time_ns
from fcw.evaluation.warning.false_alarms import FOLLOWINGS, Following, kitti_threats
from fcw.evaluation.warning.scenarios import CAR_WIDTH_M, BoxLevel
from fcw.motion.ego import assumed_ego
from fcw.threat.of_tracker import threats_of
from fcw.threat.threat import Threat
from fcw.warning.policies import POLICIES, TIMINGS_S, make_policy
from fcw.warning.types import WarningLevel, WarningPolicy


@dataclass(frozen=True, slots=True)
class Policy:
    """A policy and how early it warns."""

    name: str
    timing: str

    def make(self) -> WarningPolicy:
        """A fresh one."""
        return make_policy(self.name, self.timing)


Rates = Mapping[WarningLevel, float]
"""How often a level is reached from below, an hour."""
Moment = tuple[int, Sequence[Threat], float | None]
"""Time, threats and own speed."""


def all_policies() -> tuple[Policy, ...]:
    """Every policy with every timing."""
    return tuple(Policy(name, timing) for name in POLICIES for timing in TIMINGS_S)


class _Counts:
    def __init__(self, policies: Sequence[Policy]) -> None:
        self.counts = {policy: dict.fromkeys(WarningLevel, 0) for policy in policies}
        self.hours = 0.0

    def take(self, moments: Iterator[Moment], hours: float) -> None:
        """Judge a drive by fresh policies."""
        policies = [(counts, policy.make()) for policy, counts in self.counts.items()]
        before = [WarningLevel.NONE] * len(policies)
        for moment in moments:
            for index, (counts, policy) in enumerate(policies):
                level = policy.update(*moment).level
                for reached in WarningLevel:
                    counts[reached] += before[index] < reached <= level
                before[index] = level
        self.hours += hours

    @property
    def rates(self) -> dict[Policy, Rates]:
        return {
            policy: {level: count / self.hours for level, count in counts.items()}
            for policy, counts in self.counts.items()
        }


def nuisance_on_kitti(
    folder: Path,
    names: Sequence[str],
    policies: Sequence[Policy],
    box_noise_px: float,
    seed: int,
    on_drive: Callable[[], None] = lambda: None,
) -> dict[Policy, Rates]:
    """On the drives of KITTI tracking, with own motion as the picture measures it; see `kitti_episodes`."""
    counts = _Counts(policies)
    for name in names:
        moments = list(kitti_threats(folder, name, box_noise_px, seed))
        counts.take(
            ((time_ns(m.frame), m.threats, m.own_mps) for m in moments), time_ns(len(moments)) / 3.6e12
        )
        on_drive()
    return counts.rates


def nuisance_following(
    policies: Sequence[Policy],
    view: BoxLevel,
    hours: float,
    seed: int,
    on_hour: Callable[[float], None] = lambda hours: None,
) -> dict[Policy, Rates]:
    """When following at constant gaps; see `run_following`."""
    counts, share_h = _Counts(policies), hours / len(FOLLOWINGS)
    for number, following in enumerate(FOLLOWINGS):
        for part in range(math.ceil(share_h)):
            part_h = min(1.0, share_h - part)
            rng = np.random.default_rng([seed, number, part])
            counts.take(_following(following, view, part_h, rng), part_h)
            on_hour(part_h)
    return counts.rates


def _following(
    following: Following, view: BoxLevel, hours: float, rng: np.random.Generator
) -> Iterator[Moment]:
    width_m, own_mps = float(rng.uniform(*CAR_WIDTH_M)), following.own_mps
    tracker, ego = view.tracker(rng), assumed_ego(own_mps)
    for frame in range(round(hours * 3600 * view.frame_rate_hz)):
        at_ns = round(frame / view.frame_rate_hz * 1e9)
        tracks = tracker.update(at_ns, view.see(following.gap_m, width_m, rng), ego)
        yield at_ns, threats_of(tracker, tracks, ego), own_mps
