"""What a drive came to: counts, and its warnings as spans of time (`summary.json`)."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from fcw.logs.records import FrameResult
from fcw.motion.state import Mount, SpeedSource
from fcw.warning.types import WarningLevel

NS_PER_S = 1_000_000_000
SCALE_ABOVE_MPS = 3.0
"""Slower, speeds of both kinds are mostly their errors."""
SCALE_AFTER_M = 100.0
"""The scale is judged after so much way."""
SCALE_SAID = 0.04
"""A ratio farther from one is said: people's speedometers and GPS, and ours, are as good as 3 %."""


@dataclass(slots=True)
class WarningSpan:
    """An unbroken run of frames that showed one level for one vehicle; times from the first frame.

    Attributes:
        level: `advisory`, `caution` or `warning`.
        start_s: time of its first frame.
        end_s: time of its last frame.
        min_ttc_s: smallest TTC of that vehicle within the span; None when it never closed.
        min_distance_m: its smallest distance within the span; None when it was never measured.
        track_id: the vehicle.
    """

    level: str
    start_s: float
    end_s: float
    min_ttc_s: float | None
    min_distance_m: float | None
    track_id: int | None


def _smaller(a: float | None, b: float | None) -> float | None:
    values = [value for value in (a, b) if value is not None and math.isfinite(value)]
    return min(values, default=None)


@dataclass(slots=True)
class OwnMotionSummary:
    """How far we went, how well that is known, and what is believed of the mount at the end."""

    frames: int = 0
    known: int = 0
    distance_m: float = 0.0
    mount: Mount | None = None
    _last_ns: int | None = None
    _by_picture_m: float = 0.0
    _given_m: float = 0.0

    def add(self, result: FrameResult) -> None:
        """Take in the next frame's result."""
        self.frames += 1
        dt_s = 0.0 if self._last_ns is None else (result.time_ns - self._last_ns) / NS_PER_S
        self._last_ns = result.time_ns
        speed_mps, motion = result.ego_speed_mps, result.own_motion
        if speed_mps is not None:
            self.known += 1
            self.distance_m += speed_mps * dt_s
        if motion is None:
            return
        self.mount = motion.mount
        by_picture_mps = motion.picture_speed_mps
        if (
            motion.speed_source is SpeedSource.GIVEN
            and speed_mps is not None
            and by_picture_mps is not None
            and speed_mps > SCALE_ABOVE_MPS
        ):
            self._by_picture_m += by_picture_mps * dt_s
            self._given_m += speed_mps * dt_s

    @property
    def scale_ratio(self) -> float | None:
        """Way by the picture over that by the given speed; None where one of them is short, or unknown.

        The picture measures in units of the camera's height: its scale is that of all distances.
        """
        return self._by_picture_m / self._given_m if self._given_m >= SCALE_AFTER_M else None

    @property
    def notes(self) -> tuple[str, ...]:
        """What a person should know of it."""
        ratio = self.scale_ratio
        if ratio is None or abs(ratio - 1) < SCALE_SAID:
            return ()
        word = "short" if ratio < 1 else "long"
        return (
            f"by the speed that was given your distances are {abs(ratio - 1):.0%} {word}: the camera is "
            f"{abs(1 / ratio - 1):.0%} {'higher' if ratio < 1 else 'lower'} than the calibration says, "
            "or the calibration is wrong",
        )

    def as_json(self, calibrated_pitch_rad: float) -> dict[str, Any]:
        """The object of `summary.json`."""
        mount = None if self.mount is None else asdict(self.mount)
        if mount is not None:
            mount["calibrated_pitch_rad"] = calibrated_pitch_rad
        return {
            "distance_m": self.distance_m,
            "speed_known_part": self.known / self.frames if self.frames else 0.0,
            "mount": mount,
            "scale_ratio": self.scale_ratio,
        }


@dataclass(slots=True)
class DriveSummary:
    """Gathers the summary of a drive while it runs: call `add` with every result."""

    source: str
    versions: Mapping[str, str]
    calibrated_pitch_rad: float = 0.0
    frames: int = 0
    frames_with_lead: int = 0
    warnings: list[WarningSpan] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    _first_ns: int = 0
    _last_ns: int = 0
    _open_level: WarningLevel = WarningLevel.NONE
    _noted: bool = False
    _own: OwnMotionSummary = field(default_factory=OwnMotionSummary)

    def add(self, result: FrameResult) -> None:
        """Take in the next frame's result."""
        if self.frames == 0:
            self._first_ns = result.time_ns
        self._last_ns = result.time_ns
        self.frames += 1
        self.frames_with_lead += result.lead_id is not None
        if result.notes and not self._noted:
            time_s = (result.time_ns - self._first_ns) / NS_PER_S
            self.notes += [f"from {time_s:.0f} s: {note}" for note in result.notes]
        self._noted = bool(result.notes)
        self._own.add(result)
        self._add_warning(result)

    def _add_warning(self, result: FrameResult) -> None:
        state, time_s = result.warning, (result.time_ns - self._first_ns) / NS_PER_S
        if state.level is not WarningLevel.NONE:
            continues = state.level is self._open_level and self.warnings[-1].track_id == state.track_id
            if not continues:
                self.warnings.append(
                    WarningSpan(state.level.name.lower(), time_s, time_s, None, None, state.track_id)
                )
            span = self.warnings[-1]
            track = next((track for track in result.tracks if track.track_id == state.track_id), None)
            span.end_s = time_s
            span.min_ttc_s = _smaller(span.min_ttc_s, state.ttc_s)
            span.min_distance_m = _smaller(span.min_distance_m, track.distance_m if track else None)
        self._open_level = state.level

    @property
    def all_notes(self) -> tuple[str, ...]:
        """What a person should know of the drive."""
        return (*self.notes, *self._own.notes)

    @property
    def duration_s(self) -> float:
        """From the first frame to the last, on the source's clock."""
        return (self._last_ns - self._first_ns) / NS_PER_S

    def as_json(self, elapsed_s: float) -> dict[str, Any]:
        """The summary's JSON object; `elapsed_s` is how long the job took."""
        return {
            "source": self.source,
            "frames": self.frames,
            "duration_s": self.duration_s,
            "frames_per_second": self.frames / elapsed_s if elapsed_s > 0 else 0.0,
            "frames_with_lead": self.frames_with_lead,
            "warnings": [asdict(span) for span in self.warnings],
            "notes": [*self.notes, *self._own.notes],
            "own_motion": self._own.as_json(self.calibrated_pitch_rad),
            "versions": dict(self.versions),
        }
