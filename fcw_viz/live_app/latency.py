"""The age of what is shown."""

import math
from collections import deque
from dataclasses import dataclass

REMEMBERED = 60
"""Number of the latest pictures that count; two seconds with most cameras."""


@dataclass(frozen=True, slots=True)
class LatencyFigures:
    """Latencies over the last pictures, in seconds; NaN if nothing is known yet.

    Attributes:
        result_s: median time from a picture to its result.
        result_worst_s: longest of these times.
        drawn_s: median time from a picture to its drawing in the browser.
        drawn_worst_s: longest of these times.
    """

    result_s: float
    result_worst_s: float
    drawn_s: float
    drawn_worst_s: float

    def words(self) -> str:
        """The latencies in words."""
        return f"result {_words(self.result_s, self.result_worst_s)}, on the screen " + _words(
            self.drawn_s, self.drawn_worst_s
        )


class LatencyMeter:
    """Measures the latencies of one tab; only one picture at a time is on its way to the browser."""

    def __init__(self) -> None:
        self._results_s: deque[float] = deque(maxlen=REMEMBERED)
        self._drawn_s: deque[float] = deque(maxlen=REMEMBERED)
        self._on_the_way_s: float | None = None

    def sent(self, captured_s: float, found_s: float) -> None:
        """Note that a picture goes to the browser; if one is still on its way, that is drawn next.

        Args:
            captured_s: when it came to the program.
            found_s: when its result was ready.
        """
        self._results_s.append(found_s - captured_s)
        if self._on_the_way_s is None:
            self._on_the_way_s = captured_s

    def drawn(self, drawn_s: float) -> None:
        """Note when the browser has drawn the picture, on the clock of the captures."""
        if self._on_the_way_s is not None:
            self._drawn_s.append(drawn_s - self._on_the_way_s)
            self._on_the_way_s = None

    @property
    def figures(self) -> LatencyFigures:
        """The latencies over the last pictures."""
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
