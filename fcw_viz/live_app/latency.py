"""How old what is shown is."""

import math
from collections import deque
from dataclasses import dataclass

REMEMBERED = 60
"""Pictures, two seconds of most cameras."""


@dataclass(frozen=True, slots=True)
class LatencyFigures:
    """Over the last pictures, in seconds; NaN where nothing is known yet.

    Attributes:
        result_s: median from a picture to its result.
        result_worst_s: longest of them.
        drawn_s: median from a picture to its being drawn by the browser.
        drawn_worst_s: longest of them.
    """

    result_s: float
    result_worst_s: float
    drawn_s: float
    drawn_worst_s: float

    def words(self) -> str:
        """For a person."""
        return f"result {_words(self.result_s, self.result_worst_s)}, on the screen " + _words(
            self.drawn_s, self.drawn_worst_s
        )


class LatencyMeter:
    """Latencies of one tab: one picture at a time is on its way to the browser."""

    def __init__(self) -> None:
        self._results_s: deque[float] = deque(maxlen=REMEMBERED)
        self._drawn_s: deque[float] = deque(maxlen=REMEMBERED)
        self._on_the_way_s: float | None = None

    def sent(self, captured_s: float, found_s: float) -> None:
        """A picture goes to the browser; one that is still on its way is the one that is drawn next.

        Args:
            captured_s: when it came to the program.
            found_s: when its result was there.
        """
        self._results_s.append(found_s - captured_s)
        if self._on_the_way_s is None:
            self._on_the_way_s = captured_s

    def drawn(self, drawn_s: float) -> None:
        """The browser has drawn it at that time, on the clock of the captures."""
        if self._on_the_way_s is not None:
            self._drawn_s.append(drawn_s - self._on_the_way_s)
            self._on_the_way_s = None

    @property
    def figures(self) -> LatencyFigures:
        """Over the last pictures."""
        return LatencyFigures(
            _median(self._results_s), _worst(self._results_s), _median(self._drawn_s), _worst(self._drawn_s)
        )


def _median(values: deque[float]) -> float:
    return sorted(values)[len(values) // 2] if values else math.nan


def _worst(values: deque[float]) -> float:
    return max(values, default=math.nan)


def _words(median_s: float, worst_s: float) -> str:
    if not math.isfinite(median_s):
        return "–"
    return f"{median_s * 1000:.0f} ms (at most {worst_s * 1000:.0f})"
