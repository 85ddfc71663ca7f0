"""The own speed over a drive: one number, a GPX track, or a CSV file, which may also hold the yaw rate."""

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from numbers import Real
from pathlib import Path
from statistics import median

from fcw.bounded.files import MalformedError, read_text
from fcw.bounded.formats import csv_rows
from fcw.bounded.gpx import read_gpx
from fcw.errors import UserError
from fcw.units import DECIMAL_COMMA, KMH_PER_MPS

TIME_COLUMN = "time_s"
SPEED_COLUMN = "speed_mps"
YAW_COLUMN = "yaw_rate_radps"
EXPECTED = f"expected a CSV with the header {TIME_COLUMN},{SPEED_COLUMN}"
HIGHEST_SPEED_MPS = 70.0
"""252 km/h: even fast cars are limited to 250.

A larger number is most likely in km/h. 80 km/h is an everyday speed; 80 m/s would be 288 km/h.
"""
FASTEST_YAW_RADPS = 3.0
"""172 degrees per second. Even a spinning car turns more slowly, so a larger number is in another unit."""
TIME_ERROR_S = 1e-3
"""Tolerance for time steps that are meant to be equal."""
SHORTEST_GAP_S, LONGEST_STEP_S = 1.0, 10.0
"""Samples more than twice their usual step apart have a gap between them; these bound that limit.

Receivers give a sample every second or every five seconds, and may lose one. Interpolating linearly over 1 s
is off by at most 0.8 m/s if the car brakes with 6 m/s^2 meanwhile. In 10 s any car can stop.
"""


@dataclass(frozen=True, slots=True)
class EgoSpeed:
    """Own speed: constant, or interpolated between samples that are not too far apart.

    Attributes:
        times_s: sample times on the source's clock, ascending; empty for a constant speed.
        speeds_mps: speed at each time, or the one constant speed.
        yaw_rates_radps: yaw rate at each time, positive to the left; empty when unknown.
        from_first_frame: whether the times count from the drive's first frame instead of on the source's
            clock. True for a GPX track, whose receiver does not know that clock.
        longest_step_s: the speed is unknown between samples that are farther apart than this.

    Raises:
        UserError: the times do not rise, a value is implausible, or the lists differ in length.
    """

    times_s: tuple[float, ...]
    speeds_mps: tuple[float, ...]
    yaw_rates_radps: tuple[float, ...] = ()
    from_first_frame: bool = False
    longest_step_s: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if fault := self._fault():
            raise UserError(f"EgoSpeed: {fault}")
        steps_s = [after - before for before, after in pairwise(self.times_s)]
        usual_s = median(steps_s) if steps_s else 0.0
        longest_s = min(max(2 * usual_s, SHORTEST_GAP_S), LONGEST_STEP_S)
        object.__setattr__(self, "longest_step_s", longest_s + TIME_ERROR_S)

    def _fault(self) -> str:
        """What is wrong with the samples; empty if nothing is."""
        times_s, count = self.times_s, len(self.times_s)
        numbers = (*times_s, *self.speeds_mps, *self.yaw_rates_radps)
        for number in numbers:
            if not _is_finite(number):
                return f"{number!s:.80}, expected a number"
        if len(self.speeds_mps) != (count or 1) or len(self.yaw_rates_radps) not in (0, count):
            return (
                f"{count} times, {len(self.speeds_mps)} speeds and {len(self.yaw_rates_radps)} yaw rates, "
                "expected as many speeds as times, or one speed and no time, and as many yaw rates or none"
            )
        for before, after in pairwise(times_s):
            if after <= before:
                return f"time {after:g} s is not after {before:g} s; sort the samples by time"
        for speed_mps in self.speeds_mps:
            if fault := speed_fault(speed_mps):
                return f"speed {speed_mps:g}, {fault}"
        for yaw_rate_radps in self.yaw_rates_radps:
            if fault := _yaw_fault(yaw_rate_radps):
                return f"yaw rate {yaw_rate_radps:g}, {fault}"
        return ""

    @classmethod
    def parse(cls, text: str) -> "EgoSpeed":
        """Make one from what a user typed: metres per second, or the path of a CSV or GPX file.

        Raises:
            UserError: see `constant`, `read_csv` and `read_gpx`.
        """
        try:
            speed_mps = float(text)
        except ValueError:
            if DECIMAL_COMMA.fullmatch(text):
                raise UserError(
                    f"ego speed {text}: expected metres per second with a point: {text.replace(',', '.')}"
                ) from None
            path = Path(text)
            return cls.read_gpx(path) if path.suffix.lower() == ".gpx" else cls.read_csv(path)
        return cls.constant(speed_mps)

    @classmethod
    def constant(cls, speed_mps: float) -> "EgoSpeed":
        """Make one of the same speed all the time.

        Raises:
            UserError: it is no plausible speed in metres per second.
        """
        if fault := speed_fault(speed_mps):
            raise UserError(f"ego speed {speed_mps:g}: {fault}")
        return cls((), (speed_mps,))

    @classmethod
    def read_gpx(cls, path: Path) -> "EgoSpeed":
        """Read a GPX track that begins with the drive: its first point is taken at the first frame.

        Raises:
            UserError: the file is no GPX track, or holds an implausible speed.
        """
        times_s, speeds_mps = read_gpx(path)
        for number, speed_mps in enumerate(speeds_mps, 1):
            if fault := speed_fault(speed_mps, "remove the point"):
                raise UserError(f"ego speed {path}, track point {number}: {speed_mps:g} m/s, {fault}")
        return cls(times_s, speeds_mps, from_first_frame=True)

    @classmethod
    def read_csv(cls, path: Path) -> "EgoSpeed":
        """Read a CSV file with the columns `time_s` (seconds on the source's clock) and `speed_mps`.

        An optional column `yaw_rate_radps`, positive to the left (ISO 8855), is read too.

        Raises:
            UserError: the file cannot be read, lacks a column, or has an invalid line.
        """
        try:
            text = read_text(path)
        except FileNotFoundError:
            raise UserError(
                f"ego speed {path}: no such file; give metres per second or the path of a CSV or GPX file"
            ) from None
        except (OSError, MalformedError) as error:
            raise UserError(f"ego speed {path}: cannot be read ({error}); {EXPECTED}") from error
        rows = _rows(path, text)
        header = [name.strip() for name in next(rows, (0, []))[1]]
        for name in (TIME_COLUMN, SPEED_COLUMN):
            if name not in header:
                raise UserError(f"ego speed {path}: no column {name} in the first line; {EXPECTED}")
        time_index, speed_index = header.index(TIME_COLUMN), header.index(SPEED_COLUMN)
        yaw_index = header.index(YAW_COLUMN) if YAW_COLUMN in header else None
        times_s: list[float] = []
        speeds_mps: list[float] = []
        yaw_rates_radps: list[float] = []
        for line_number, row in rows:
            line = f"ego speed {path}, line {line_number}"
            time_s = _number(row, time_index, TIME_COLUMN, line)
            speed_mps = _number(row, speed_index, SPEED_COLUMN, line)
            if fault := speed_fault(speed_mps):
                raise UserError(f"{line}: {SPEED_COLUMN} is {speed_mps:g}, {fault}")
            if times_s and time_s <= times_s[-1]:
                raise UserError(
                    f"{line}: {TIME_COLUMN} {time_s:g} is not after {times_s[-1]:g} of the line before; "
                    "sort the lines by time"
                )
            if yaw_index is not None:
                yaw_rate_radps = _number(row, yaw_index, YAW_COLUMN, line)
                if fault := _yaw_fault(yaw_rate_radps):
                    raise UserError(f"{line}: {YAW_COLUMN} is {yaw_rate_radps:g}, {fault}")
                yaw_rates_radps.append(yaw_rate_radps)
            times_s.append(time_s)
            speeds_mps.append(speed_mps)
        if not times_s:
            raise UserError(f"ego speed {path}: no line below the header; {EXPECTED}")
        return cls(tuple(times_s), tuple(speeds_mps), tuple(yaw_rates_radps))

    def at(self, time_ns: int) -> float | None:
        """Speed in m/s, linearly interpolated; None in gaps and outside the span of the samples."""
        return self.speeds_mps[0] if not self.times_s else self._between(self.speeds_mps, time_ns)

    def yaw_rate_at(self, time_ns: int) -> float | None:
        """Yaw rate in rad/s, positive to the left; None where `at` is None and if it is unknown."""
        return self._between(self.yaw_rates_radps, time_ns) if self.yaw_rates_radps else None

    def gaps_s(self, start_s: float, end_s: float) -> tuple[float, ...]:
        """Lengths of the gaps between samples that overlap a time span; only the overlapping parts count."""
        parts = (
            min(after, end_s) - max(before, start_s)
            for before, after in pairwise(self.times_s)
            if after - before > self.longest_step_s
        )
        return tuple(part_s for part_s in parts if part_s > 0)

    def _between(self, values: tuple[float, ...], time_ns: int) -> float | None:
        time_s = time_ns / 1e9
        if not self.times_s[0] <= time_s <= self.times_s[-1]:
            return None
        after = bisect_right(self.times_s, time_s)
        if after == len(self.times_s):
            return values[-1]
        t0, t1 = self.times_s[after - 1 : after + 1]
        if t1 - t0 > self.longest_step_s and time_s != t0:
            return None
        v0, v1 = values[after - 1 : after + 1]
        return v0 + (v1 - v0) * (time_s - t0) / (t1 - t0)


def speed_fault(speed_mps: float, mend: str = "") -> str:
    """Why a number cannot be a car's speed in metres per second; empty if it can.

    Args:
        speed_mps: the number.
        mend: advice for a number that is not simply in km/h.
    """
    if 0 <= speed_mps <= HIGHEST_SPEED_MPS:
        return ""
    meant_mps = speed_mps / KMH_PER_MPS
    if speed_mps > HIGHEST_SPEED_MPS and meant_mps <= HIGHEST_SPEED_MPS:
        question = f"did you mean {meant_mps:.1f} m/s ({speed_mps:g} km/h)?"
        mend = f"{question} Else {mend}" if mend else question
    expected = f"expected metres per second between 0 and {HIGHEST_SPEED_MPS:g}"
    return f"{expected}; {mend}" if mend else expected


def _yaw_fault(yaw_rate_radps: float) -> str:
    """Why a number cannot be a car's yaw rate; empty if it can."""
    if abs(yaw_rate_radps) <= FASTEST_YAW_RADPS:
        return ""
    return (
        f"expected radians per second between -{FASTEST_YAW_RADPS:g} and {FASTEST_YAW_RADPS:g}, positive to "
        "the left"
    )


def _is_finite(value: object) -> bool:
    return isinstance(value, Real) and math.isfinite(value)


def _rows(path: Path, text: str) -> Iterator[tuple[int, list[str]]]:
    try:
        yield from csv_rows(text)
    except MalformedError as error:
        raise UserError(f"ego speed {path}, {error}; {EXPECTED}") from error


def _number(row: list[str], index: int, name: str, line: str) -> float:
    text = row[index].strip() if index < len(row) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UserError(f"{line}: {name} is {text!r}, expected a number")
    return value
