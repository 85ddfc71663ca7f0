"""Own motion by the picture against true poses: errors of speed and yaw rate, the mount, and the time."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import FloatArray
from fcw.errors import UserError
from fcw.evaluation.motion.poses import SLOWEST_MPS, TrueMotion, true_motion
from fcw.frame import Source
from fcw.motion.estimator import MotionEstimator
from fcw.motion.settings import MotionSettings
from fcw.motion.state import Mount, OwnMotion
from fcw.threads import one_opencv_thread

MOUNT_AT_S = 30.0
"""The mount is judged after so long, or at the end of a shorter drive."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionEvaluation:
    """What own motion by the picture is worth on a drive.

    Attributes:
        frames: pictures.
        known_part: of them with a speed.
        speed_median: median relative error of the speed where the true one is above 2 m/s.
        speed_p90: nine of ten errors are smaller.
        speed_bias: median of the signed errors.
        speed_coverage: part of the true speeds inside the 1-sigma interval.
        yaw_rate_median_radps: median error of the yaw rate.
        camera_pitch_rad: of the camera below the direction of travel, as believed at the end.
        camera_yaw_rad: of the camera to the left of it.
        camera_roll_rad: of the camera to the right about its axis.
        pitch_after_30_s_rad: as believed after 30 s.
        yaw_after_30_s_rad: likewise.
        true_pitch_rad: by the poses, in the mean of the drive.
        true_yaw_rad: likewise; bends push it to and fro.
        ms_per_frame: mean time of the thread that it took, from the second second on.
    """

    frames: int
    known_part: float
    speed_median: float
    speed_p90: float
    speed_bias: float
    speed_coverage: float
    yaw_rate_median_radps: float
    camera_pitch_rad: float
    camera_yaw_rad: float
    camera_roll_rad: float
    pitch_after_30_s_rad: float
    yaw_after_30_s_rad: float
    true_pitch_rad: float
    true_yaw_rad: float
    ms_per_frame: float


def evaluate_motion(
    source: Source,
    calibration: Calibration,
    poses: FloatArray,
    on_frame: Callable[[], None] = lambda: None,
    settings: MotionSettings | None = None,
) -> MotionEvaluation:
    """Run own motion alone over a drive, other vehicles unmasked, and compare it with its poses.

    Args:
        source: the pictures.
        calibration: for their size.
        poses: (N, 3, 4), one for each picture; more are allowed at the end.
        on_frame: called after each picture.
        settings: of own motion.

    Raises:
        UserError: there are fewer poses than pictures, or fewer than two pictures.
    """
    estimator = MotionEstimator(calibration, settings)
    states: list[OwnMotion] = []
    times_ns: list[int] = []
    taken_ms: list[float] = []
    with one_opencv_thread():
        for frame in source.frames():
            start = time.thread_time()
            states.append(estimator.update(frame.time_ns, frame.image))
            taken_ms.append((time.thread_time() - start) * 1e3)
            times_ns.append(frame.time_ns)
            on_frame()
    count = len(states)
    if count < 2 or count > len(poses):
        raise UserError(
            f"{source.name}: {count} pictures and {len(poses)} poses; expected a pose for each, at least two"
        )
    times_s = np.array(times_ns) / 1e9
    truth = true_motion(poses[:count], times_s)
    after = min(int(np.searchsorted(times_s, times_s[0] + MOUNT_AT_S)), count - 1)
    later = np.array(taken_ms)[times_s > times_s[0] + 1.0]
    return _compared(states, truth, after, float(later.mean()) if len(later) else math.nan)


def _compared(
    states: list[OwnMotion], truth: TrueMotion, after: int, ms_per_frame: float
) -> MotionEvaluation:
    def column(name: str) -> FloatArray:
        values = (getattr(state, name) for state in states)
        return np.array([math.nan if value is None else value for value in values])

    speeds_mps, sigmas_mps = column("speed_mps"), column("speed_sigma_mps")
    known = np.isfinite(speeds_mps)
    judged = known & (truth.speeds_mps > SLOWEST_MPS)
    relative = speeds_mps[judged] / truth.speeds_mps[judged] - 1
    turning = np.abs(column("yaw_rate_radps") - truth.yaw_rates_radps)[known]
    last, then = (state.mount or Mount(pitch_rad=math.nan) for state in (states[-1], states[after]))
    return MotionEvaluation(
        frames=len(states),
        known_part=float(known.mean()),
        speed_median=_quantile(np.abs(relative), 0.5),
        speed_p90=_quantile(np.abs(relative), 0.9),
        speed_bias=_quantile(relative, 0.5),
        speed_coverage=float(np.mean(np.abs(speeds_mps - truth.speeds_mps)[judged] <= sigmas_mps[judged]))
        if judged.any()
        else math.nan,
        yaw_rate_median_radps=_quantile(turning, 0.5),
        camera_pitch_rad=last.pitch_rad,
        camera_yaw_rad=last.yaw_rad,
        camera_roll_rad=last.roll_rad,
        pitch_after_30_s_rad=then.pitch_rad,
        yaw_after_30_s_rad=then.yaw_rad,
        true_pitch_rad=truth.pitch_rad,
        true_yaw_rad=truth.yaw_rad,
        ms_per_frame=ms_per_frame,
    )


def _quantile(values: FloatArray, part: float) -> float:
    return float(np.quantile(values, part)) if len(values) else math.nan
