"""Where moments of a drive stand along the page's time line and plots."""

from dataclasses import dataclass

from fcw.charts.scale import multiples

TICK_STEPS_S = (0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1800.0, 3600.0)
TICK_GAP_PX = 80.0
"""Room for the words of a tick."""


@dataclass(frozen=True, slots=True)
class TimeAxis:
    """A range of time along so many pixels.

    Attributes:
        start_s: at the left edge.
        end_s: at the right edge; later.
        width_px: of the axis.
    """

    start_s: float
    end_s: float
    width_px: float

    @property
    def span_s(self) -> float:
        """Its length in time."""
        return self.end_s - self.start_s

    def x(self, time_s: float) -> float:
        """Where a moment stands."""
        return (time_s - self.start_s) / self.span_s * self.width_px

    def holds(self, time_s: float) -> bool:
        """Whether a moment is on it."""
        return self.start_s <= time_s <= self.end_s

    def ticks_s(self) -> list[float]:
        """Round moments, so far apart that their words fit."""
        wanted_s = self.span_s / max(self.width_px / TICK_GAP_PX, 1.0)
        step_s = next((step for step in TICK_STEPS_S if step >= wanted_s), TICK_STEPS_S[-1])
        while step_s < wanted_s:
            step_s *= 2
        return multiples(step_s, self.start_s, self.end_s)

    @property
    def tick_decimals(self) -> int:
        """Digits after the point by which the words of any two ticks differ."""
        return 1 if any(tick_s != round(tick_s) for tick_s in self.ticks_s()) else 0


def window_around(time_s: float, window_s: float | None, duration_s: float) -> tuple[float, float]:
    """The range of time of the plots around a moment.

    Args:
        time_s: the moment.
        window_s: how long; None for the whole drive.
        duration_s: of the drive.

    Returns:
        Start and end in seconds, inside the drive where that is long enough.
    """
    shortest_s = max(duration_s, 1.0)
    if window_s is None or window_s >= shortest_s:
        return 0.0, shortest_s
    start_s = min(max(time_s - window_s / 2, 0.0), shortest_s - window_s)
    return start_s, start_s + window_s
