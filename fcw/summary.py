"""What a drive came to: counts, and its warnings as spans of time (`summary.json`)."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from fcw.logs.records import FrameResult
from fcw.warning.types import WarningLevel

NS_PER_S = 1_000_000_000


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
class DriveSummary:
    """Gathers the summary of a drive while it runs: call `add` with every result."""

    source: str
    versions: Mapping[str, str]
    frames: int = 0
    frames_with_lead: int = 0
    warnings: list[WarningSpan] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    _first_ns: int = 0
    _last_ns: int = 0
    _open_level: WarningLevel = WarningLevel.NONE
    _noted: bool = False

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
            "notes": self.notes,
            "versions": dict(self.versions),
        }
