"""Warnings that should not come: on real drives, episode by episode, and when following at a constant gap."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.evaluation.distance.kitti import TRUE_SPEED_HALF_WINDOW_S, detections_of, tracker_settings
from fcw.evaluation.distance.kitti_tracking import (
    KittiSequence,
    KittiVehicle,
    read_own_motion,
    read_sequence,
    time_ns,
)
from fcw.evaluation.motion.measured import MeasuredMotion, MotionErrors
from fcw.evaluation.warning.scenarios import CAR_WIDTH_M, BoxLevel, PolicyMaker, warning_states
from fcw.motion.ego import NOTHING_KNOWN, assumed_ego
from fcw.threat.of_tracker import threats_of
from fcw.threat.threat import Threat, required_deceleration_mps2
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track
from fcw.warning.types import WarningLevel, WarningPolicy, WarningState

SAME_EDGES_PX = 15.0
"""A track is of the vehicle whose sides are on average this near to its box's, at most."""
TOUCHING_M = 1.8
"""Two cars 1.8 m wide touch when their middles are nearer than this."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """A run of frames of a real drive that showed a level, and what was truly there when it began.

    Attributes:
        sequence: name of the drive.
        start_s: from its first frame.
        end_s: of its last frame.
        rule: the rule that raised it.
        own_mps: own speed at its start.
        believed_ttc_s: TTC by the tracker at its start.
        vehicle: the labelled vehicle, as class and identity; empty where no label fits.
        distance_m: its true distance.
        ttc_s: its true TTC; None where it does not close.
        required_mps2: braking truly required without any delay; None where it does not close.
        miss_m: how far beside us it passes, from middle to middle, when all goes on as it does now, our
            turning included; the two touch below 1.8 m.
        oncoming: whether it is turned towards us.
    """

    sequence: str
    start_s: float
    end_s: float
    rule: str
    own_mps: float
    believed_ttc_s: float | None
    vehicle: str = ""
    distance_m: float | None = None
    ttc_s: float | None = None
    required_mps2: float | None = None
    miss_m: float | None = None
    oncoming: bool = False

    @property
    def on_course(self) -> bool:
        """Whether the vehicle is truly on a collision course."""
        return self.miss_m is not None and self.miss_m < TOUCHING_M


def kitti_episodes(
    folder: Path,
    names: Sequence[str],
    make_policy: PolicyMaker,
    box_noise_px: float,
    seed: int,
    level: WarningLevel = WarningLevel.WARNING,
    with_own_motion: bool = True,
    own_speed_known: bool = True,
) -> tuple[tuple[Episode, ...], float]:
    """Run tracker and policy over sequences of KITTI tracking, as `fcw evaluate distance` does.

    Args:
        folder: of KITTI tracking.
        names: of the sequences.
        make_policy: makes the policy of each.
        box_noise_px: sigma of the boxes' sides.
        seed: of all noise.
        level: that counts.
        with_own_motion: whether own motion is measured as by the picture, with its errors; without, the own
            speed is that of the poses, and nothing is known of our turning.
        own_speed_known: whether the own speed is known.

    Returns:
        The episodes that showed the level or a higher one, and how many hours were driven.

    Raises:
        UserError: a file is missing or not as expected.
    """
    episodes: list[Episode] = []
    frames = 0
    for name in names:
        threats = kitti_threats(folder, name, box_noise_px, seed, with_own_motion, own_speed_known)
        moments = list(threats)
        episodes += _episodes(read_sequence(folder, name), moments, make_policy(), level)
        frames += len(moments)
    return tuple(episodes), time_ns(frames) / 3.6e12


class KittiMoment(NamedTuple):
    """One frame of a drive, as it is followed; `own_mps` is what is measured of the own speed."""

    frame: int
    tracks: tuple[Track, ...]
    threats: tuple[Threat, ...]
    own_mps: float | None
    true_own_mps: float


def kitti_threats(
    folder: Path,
    name: str,
    box_noise_px: float,
    seed: int,
    with_own_motion: bool = True,
    own_speed_known: bool = True,
) -> Iterator[KittiMoment]:
    """Follow the labelled vehicles of a sequence; see `kitti_episodes`."""
    sequence, rng = read_sequence(folder, name), np.random.default_rng([seed, *name.encode()])
    calibration = sequence.calibration(rng)
    measured = _measured(sequence, calibration, seed, own_speed_known) if with_own_motion else None
    tracker = Tracker(calibration, tracker_settings(box_noise_px))
    speeds_mps, yaw_rates_radps = (values.tolist() for values in read_own_motion(folder, name))
    for frame, vehicles in enumerate(sequence.frames):
        ego, speed_mps = NOTHING_KNOWN, 0.0
        if frame < len(speeds_mps):
            speed_mps = speeds_mps[frame]
            ego = assumed_ego(speed_mps if own_speed_known else None)
            if measured is not None:
                ego = measured.at(time_ns(frame), speed_mps, yaw_rates_radps[frame])
        detections = detections_of(vehicles, sequence.image_size, box_noise_px, rng)
        tracks = tracker.update(time_ns(frame), detections, ego)
        yield KittiMoment(frame, tracks, threats_of(tracker, tracks, ego), ego.motion.speed_mps, speed_mps)


def _episodes(
    sequence: KittiSequence, moments: Iterable[KittiMoment], policy: WarningPolicy, level: WarningLevel
) -> list[Episode]:
    episodes: list[Episode] = []
    shown = False
    for frame, tracks, threats, own_mps, true_own_mps in moments:
        state = policy.update(time_ns(frame), threats, own_mps)
        time_s = time_ns(frame) / 1e9
        if state.level < level:
            shown = False
        elif shown:
            episodes[-1] = replace(episodes[-1], end_s=time_s)
        else:
            shown = True
            warned = next((track for track in tracks if track.track_id == state.track_id), None)
            episodes.append(_episode(sequence, frame, warned, state, true_own_mps))
    return episodes


def _measured(
    sequence: KittiSequence, calibration: Calibration, seed: int, own_speed_known: bool
) -> MeasuredMotion:
    """Own motion as the picture tells it to one who has this calibration of the camera."""
    focal_px, axis_column_px, horizon_px = (float(sequence.projection[at]) for at in ((0, 0), (0, 2), (1, 2)))
    camera = calibration.camera
    return MeasuredMotion(
        camera.pitch_rad + (camera.horizon_row_px - horizon_px) / camera.focal_y_px,
        # The axis is taken to be in the middle of the picture, where it is not.
        (axis_column_px - camera.principal_column_px) / focal_px,
        np.random.default_rng([seed, 1, *sequence.name.encode()]),
        MotionErrors(speed_known=own_speed_known),
    )


def _episode(
    sequence: KittiSequence, frame: int, track: Track | None, state: WarningState, own_mps: float
) -> Episode:
    time_s = time_ns(frame) / 1e9
    episode = Episode(
        sequence=sequence.name,
        start_s=time_s,
        end_s=time_s,
        rule=state.rule,
        own_mps=own_mps,
        believed_ttc_s=state.ttc_s,
    )
    vehicle = None if track is None else _vehicle_of(track, sequence.frames[frame])
    if vehicle is None:
        return episode
    closing_mps, sideways_mps = _true_speeds(sequence, vehicle.track_id, frame)
    ttc_s = vehicle.rear_m / closing_mps if closing_mps > 0 else None
    return replace(
        episode,
        vehicle=f"{vehicle.kind} {vehicle.track_id}",
        distance_m=vehicle.rear_m,
        ttc_s=ttc_s,
        required_mps2=required_deceleration_mps2(vehicle.rear_m, closing_mps),
        miss_m=None if ttc_s is None else abs(vehicle.lateral_m + sideways_mps * ttc_s),
        oncoming=abs(vehicle.heading_rad) > math.pi / 2,
    )


def _vehicle_of(track: Track, vehicles: Sequence[KittiVehicle]) -> KittiVehicle | None:
    def off_px(vehicle: KittiVehicle) -> float:
        return (abs(vehicle.box.x - track.box.x) + abs(vehicle.box.right - track.box.right)) / 2

    best = min(vehicles, key=off_px, default=None)
    return best if best is not None and off_px(best) <= SAME_EDGES_PX else None


def _true_speeds(sequence: KittiSequence, track_id: int, frame: int) -> tuple[float, float]:
    """Closing speed, and speed to the left, of a vehicle as seen from ours; 0 where it is labelled once."""
    samples = [
        (time_ns(index) / 1e9, vehicle.rear_m, vehicle.lateral_m)
        for index, vehicles in enumerate(sequence.frames)
        for vehicle in vehicles
        if vehicle.track_id == track_id
        and abs(time_ns(index) - time_ns(frame)) <= TRUE_SPEED_HALF_WINDOW_S * 1e9
    ]
    if len(samples) < 2:
        return 0.0, 0.0
    times_s, rears_m, laterals_m = np.array(samples).T
    return -float(np.polyfit(times_s, rears_m, 1)[0]), float(np.polyfit(times_s, laterals_m, 1)[0])


FOLLOWING_RATE_HZ = 10.0
"""Pictures a second when following, as on KITTI: the fewer there are, the less their noise averages out."""


@dataclass(frozen=True, slots=True)
class Following:
    """A steady drive behind somebody.

    Attributes:
        own_mps: speed of both.
        gap_m: from bumper to bumper.
    """

    own_mps: float
    gap_m: float


FOLLOWINGS = (
    Following(5.0, 6.0),
    Following(14.0, 14.0),
    Following(14.0, 30.0),
    Following(25.0, 25.0),
    Following(33.0, 60.0),
)
"""A queue, a town at one second and at two, a road at one second, and a motorway."""


@dataclass(frozen=True, slots=True)
class FollowingResult:
    """What was shown while following.

    Attributes:
        following: how.
        hours: how long.
        warnings: how often `warning` was raised.
        cautions: how often `caution` was raised.
    """

    following: Following
    hours: float
    warnings: int
    cautions: int


def run_following(
    make_policy: PolicyMaker,
    view: BoxLevel,
    hours: float,
    seed: int,
    on_hour: Callable[[float], None] = lambda hours: None,
) -> tuple[FollowingResult, ...]:
    """Follow at each of `FOLLOWINGS` for its share of the hours, every hour with a calibration of its own."""
    share_h = hours / len(FOLLOWINGS)
    results = []
    for number, following in enumerate(FOLLOWINGS):
        warnings = cautions = 0
        for part in range(math.ceil(share_h)):
            part_h = min(1.0, share_h - part)
            rng = np.random.default_rng([seed, number, part])
            count = round(part_h * 3600 * view.frame_rate_hz)
            pairs = ((frame / view.frame_rate_hz, following.gap_m) for frame in range(count))
            width_m = float(rng.uniform(*CAR_WIDTH_M))
            before = WarningLevel.NONE
            for _, state in warning_states(
                pairs, following.own_mps, width_m, make_policy(), view.tracker(rng), view, rng
            ):
                warnings += before < WarningLevel.WARNING <= state.level
                cautions += before < WarningLevel.CAUTION == state.level
                before = state.level
            on_hour(part_h)
        results.append(FollowingResult(following, share_h, warnings, cautions))
    return tuple(results)
