"""What `fcw bench` found: times, and the ratios that hold on any machine."""

import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from fcw_viz.benchmark.drive_cases import DECODE, ENCODED, ONE_THREAD, RELAYED, TWO_THREADS
from fcw_viz.benchmark.picture_cases import (
    CHANNELS,
    FULL,
    FULL_NATIVE,
    LUV,
    NET,
    PRIOR,
    PRIOR_NATIVE,
    PRIOR_NEAR,
)


class Ratio(NamedTuple):
    """One time over another, taken in the same round."""

    name: str
    case: str
    to: str


RATIOS = (
    Ratio("distance prior 4-80 m / plain ACF at the same scales", PRIOR, FULL),
    Ratio("the same, both native", PRIOR_NATIVE, FULL_NATIVE),
    Ratio("distance prior 4-41 m / cv2 BGR to Luv", PRIOR_NEAR, LUV),
    Ratio("channels of the whole picture / cv2 BGR to Luv", CHANNELS, LUV),
    Ratio("detector net / cv2 BGR to Luv", NET, LUV),
    Ratio("rate of two threads / one", ONE_THREAD, TWO_THREADS),
    Ratio("rate of the whole job, video relayed / decoding", DECODE, RELAYED),
    Ratio("rate of the whole job, video encoded / decoding", DECODE, ENCODED),
)


@dataclass(frozen=True, slots=True)
class Figures:
    """Milliseconds a frame of each case, a value a round.

    Attributes:
        heading: machine, date, versions and what it was measured on.
        picture_ms: of one thread's time, the median over the round's pictures, by case.
        drive_ms: by the clock, by case.
        stages_ms: of one thread's time, the mean over frames in a row, by stage (`fcw_viz.benchmark.stages`).
        windows_per_frame: by detector case.
    """

    heading: str
    picture_ms: Mapping[str, Sequence[float]]
    drive_ms: Mapping[str, Sequence[float]]
    stages_ms: Mapping[str, Sequence[float]]
    windows_per_frame: Mapping[str, int]

    def ratios(self) -> Iterator[tuple[str, float]]:
        """Each of `RATIOS` that was measured: its median over the rounds."""
        times = {**self.picture_ms, **self.drive_ms}
        for name, case, to in RATIOS:
            if case in times and to in times:
                yield name, _median_ratio(times[case], times[to])

    def picture_rows(self) -> Iterator[tuple[str, ...]]:
        """Case, median, minimum, to the conversion to Luv, to plain ACF, windows; as text."""
        for case, values in self.picture_ms.items():
            windows = self.windows_per_frame.get(case)
            yield (
                case,
                f"{statistics.median(values):.2f}",
                f"{min(values):.2f}",
                f"{_median_ratio(values, self.picture_ms[LUV]):.2f}",
                f"{_median_ratio(values, self.picture_ms[FULL]):.2f}",
                "" if windows is None else f"{windows:,}",
            )

    def drive_rows(self) -> Iterator[tuple[str, ...]]:
        """Case, median, minimum, frames a second; as text."""
        for case, values in self.drive_ms.items():
            median_ms = statistics.median(values)
            yield case, f"{median_ms:.2f}", f"{min(values):.2f}", f"{1e3 / median_ms:.0f}"

    def stage_rows(self) -> Iterator[tuple[str, ...]]:
        """Stage, median, part of the whole; as text."""
        medians = {stage: statistics.median(values) for stage, values in self.stages_ms.items()}
        for stage, median_ms in medians.items():
            yield stage, f"{median_ms:.2f}", f"{median_ms / sum(medians.values()):.0%}"
        yield "all", f"{sum(medians.values()):.2f}", ""

    def as_json(self) -> dict[str, Any]:
        """The same figures for scripts."""
        return {
            "heading": self.heading,
            "ms_per_frame": {**self.picture_ms, **self.drive_ms},
            "stages_ms": dict(self.stages_ms),
            "windows_per_frame": dict(self.windows_per_frame),
            "ratios": dict(self.ratios()),
        }


def _median_ratio(values: Sequence[float], others: Sequence[float]) -> float:
    return statistics.median(a / b for a, b in zip(values, others, strict=True))
