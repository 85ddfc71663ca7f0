"""What a drive came to: counts, and its warnings as spans of time (`summary.json`)."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from fcw.logs.events import find_events
from fcw.logs.records import FrameResult
from fcw.logs.series import SeriesBuilder
from fcw.warning.types import WarningLevel

NS_PER_S = 1_000_000_000
LEVEL_NAMES = {level.name.lower() for level in WarningLevel if level > WarningLevel.NONE}


@dataclass(slots=True)
class WarningSpan:
    """A warning of a drive: an event of `fcw.logs.events`, near misses aside; times from the first frame.

    Attributes:
        level: the highest of it: `advisory`, `caution` or `warning`.
        start_s: time of its first frame.
        end_s: time of its last frame.
        min_ttc_s: smallest TTC of that vehicle within it; None when it never closed.
        min_distance_m: its smallest distance within it; None when it was never measured.
        track_id: the vehicle.
    """

    level: str
    start_s: float
    end_s: float
    min_ttc_s: float | None
    min_distance_m: float | None
    track_id: int | None


@dataclass(slots=True)
class DriveSummary:
    """Gathers the summary of a drive while it runs: call `add` with every result."""

    source: str
    versions: Mapping[str, str]
    frames: int = 0
    frames_with_lead: int = 0
    notes: list[str] = field(default_factory=list)
    _first_ns: int = 0
    _last_ns: int = 0
    _series: SeriesBuilder = field(default_factory=SeriesBuilder)
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
        self._series.add(result, ())

    @property
    def warnings(self) -> list[WarningSpan]:
        """What was warned of, in the order of the starts."""
        return [
            WarningSpan(
                event.kind, event.start_s, event.end_s, event.min_ttc_s, event.min_distance_m, event.track_id
            )
            for event in find_events(self._series.build())
            if event.kind in LEVEL_NAMES
        ]

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
