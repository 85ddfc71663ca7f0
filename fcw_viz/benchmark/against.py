"""The figures of an earlier run, of another version maybe, beside those of this one.

Milliseconds of two runs say as much of the machine and of what else it did as of the program: what is
compared are ratios to what was measured in the same run.
"""

import math
import statistics
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fcw.bounded.files import MalformedError, read_text
from fcw.bounded.formats import json_value
from fcw.errors import UserError
from fcw_viz.benchmark.figures import Figures
from fcw_viz.benchmark.picture_cases import LUV


@dataclass(frozen=True, slots=True)
class Change:
    """A figure of both runs.

    Attributes:
        name: what it is.
        before: in the earlier run.
        now: in this one.
    """

    name: str
    before: float
    now: float

    @property
    def ratio(self) -> float:
        """Now over before."""
        return self.now / self.before


@dataclass(frozen=True, slots=True, eq=False)
class EarlierFigures:
    """What an earlier `fcw bench` wrote.

    Attributes:
        path: of the file.
        heading: on what, with which version and where it was measured.
        figures: its ratios, and times as ratios, by name.
    """

    path: Path
    heading: str
    figures: Mapping[str, float]

    @classmethod
    def load(cls, path: Path) -> "EarlierFigures":
        """Read what `fcw bench --json` printed, or `bench.json` of a report.

        Raises:
            UserError: it cannot be read, or is something else.
        """
        try:
            earlier = json_value(read_text(path))
            return cls(path, str(earlier["heading"]), _comparable(earlier))
        except OSError as error:
            raise UserError(f"--against {path}: cannot be read ({error.strerror})") from error
        except (MalformedError, KeyError, TypeError, AttributeError, ValueError, ZeroDivisionError) as error:
            raise UserError(
                f"--against {path}: not the figures of a benchmark ({error}); expected what "
                "`fcw bench --json` prints, or bench.json of `fcw bench --report DIR`"
            ) from error

    def changes(self, figures: Figures) -> Iterator[Change]:
        """What both runs measured, in this one's order."""
        for name, now in _comparable(figures.as_json()).items():
            if name in self.figures:
                yield Change(name, self.figures[name], now)

    def as_json(self, figures: Figures) -> dict[str, dict[str, float]]:
        """The same for scripts."""
        return {
            change.name: {"before": change.before, "now": change.now, "ratio": change.ratio}
            for change in self.changes(figures)
        }


def _comparable(figures: Mapping[str, Any]) -> dict[str, float]:
    """The ratios, and the times of single pictures and of stages over the conversion to Luv."""
    luv_ms = statistics.median(figures["ms_per_frame"][LUV])
    found = {name: float(value) for name, value in figures["ratios"].items()}
    for name in figures["windows_per_frame"]:
        found[f"{name} / Luv"] = statistics.median(figures["ms_per_frame"][name]) / luv_ms
    for name, values in figures.get("stages_ms", {}).items():
        found[f"stage {name} / Luv"] = statistics.median(values) / luv_ms
    for name, value in found.items():
        if not (math.isfinite(value) and value >= 0):
            raise ValueError(f"{name}: {value}")
    return {name: value for name, value in found.items() if value > 0}
