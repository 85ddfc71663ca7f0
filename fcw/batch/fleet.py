"""A page about all drives of a batch: their worst moments, and how the drives compare."""

import base64
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from html import escape
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fcw.batch.ledger import DRIVES_NAME, Record, State
from fcw.batch.moments import moment_name, read_moment
from fcw.bounded.files import read_text
from fcw.bounded.formats import json_value
from fcw.charts.chart import Chart, Series
from fcw.logs.events import DriveEvent, seen_s
from fcw.logs.names import SUMMARY_NAME
from fcw.logs.records import DriveHeader
from fcw.logs.series import DriveSeries

FLEET_NAME = "fleet.html"
MOST_MOMENTS = 24
"""Number of worst moments of all drives on the page."""
HEADWAY_EDGES_S = np.linspace(0.0, 5.0, 51)
TTC_EDGES_S = np.linspace(0.0, 6.0, 31)
LEAST_RANGE = 0.5
"""Least range of an axis in its unit, for fleets in which nothing differs."""
MOST_NUMBERS = 10
"""Largest number of drive numbers along an axis."""
MOST_CAMERAS = 4
"""Largest number of cameras with their own colours."""
DAY_S = 86_400
DAY_NS = DAY_S * 10**9
_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #1c2430; max-width: 1180px; margin: 2rem auto }
body { padding: 0 1rem }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(480px, 100%), 1fr)); gap: 1rem }
.moments { display: grid; grid-template-columns: repeat(auto-fill, minmax(180px, 1fr)); gap: .8rem }
figure { margin: 0 }
figure img, figure i { width: 100%; aspect-ratio: 16/9; display: block; background: #dde3ea }
figcaption { font-size: 13px; overflow-wrap: anywhere }
li { overflow-wrap: anywhere }
ol { columns: 240px; padding-left: 3rem }
"""


@dataclass(slots=True)
class Fleet:
    """Collects what the page shows; call `add` with each finished drive, in the order of the page.

    Attributes:
        names: names of the drives.
        cameras: camera of each drive.
        begun_ns: start of each drive in UTC, since 1970; None if its source does not state it.
        warnings_per_hour: warnings of each drive per hour in which something could be seen; NaN if there was
            no such time.
        mount_off_deg: how much lower than calibrated the camera looked at the end of each drive; NaN if
            unknown.
        headway_frames: number of frames at each headway to the lead.
        lead_frames: number of frames with a headway.
        least_ttc_s: least TTC of each event that had one.
        moments: drive and event.
        notes: drive and a note about it for the user.
        unfinished: states of the drives that are not finished.
    """

    names: list[str] = field(default_factory=list)
    cameras: list[str] = field(default_factory=list)
    begun_ns: list[int | None] = field(default_factory=list)
    warnings_per_hour: list[float] = field(default_factory=list)
    mount_off_deg: list[float] = field(default_factory=list)
    headway_frames: NDArray[np.int64] = field(
        default_factory=lambda: np.zeros(len(HEADWAY_EDGES_S) - 1, np.int64)
    )
    lead_frames: int = 0
    least_ttc_s: list[float] = field(default_factory=list)
    moments: list[tuple[str, DriveEvent]] = field(default_factory=list)
    notes: list[tuple[str, str]] = field(default_factory=list)
    unfinished: list[State] = field(default_factory=list)

    def add(
        self,
        record: Record,
        series: DriveSeries,
        events: Sequence[DriveEvent],
        header: DriveHeader,
        out: Path,
    ) -> None:
        """Take a drive.

        Args:
            record: its result.
            series: its signals.
            events: its events.
            header: header of its log.
            out: folder of the batch.
        """
        self.names.append(record.name)
        self.notes += [(record.name, note) for note in record.notes]
        self.cameras.append(record.camera)
        self.begun_ns.append(header.begun_utc_ns(int(series.time_ns[0])))
        pitch_rad = header.calibration.camera.pitch_rad
        hours = seen_s(record.duration_s, events) / 3600
        self.warnings_per_hour.append(record.warnings / hours if hours else np.nan)
        self.mount_off_deg.append(_mount_off_deg(out / record.name / SUMMARY_NAME, pitch_rad))
        self.headway_frames += np.histogram(series.headway_s, HEADWAY_EDGES_S)[0]
        self.lead_frames += int(np.count_nonzero(np.isfinite(series.headway_s)))
        self.least_ttc_s += [event.min_ttc_s for event in events if event.min_ttc_s is not None]
        self.moments += [(record.name, event) for event in events if event.severity > 0]
        self.moments.sort(key=lambda moment: -moment[1].severity)
        del self.moments[MOST_MOMENTS:]

    def charts(self) -> list[Chart]:
        """The fleet in four charts."""
        share = self.headway_frames / max(self.lead_frames, 1)
        counts = np.histogram(self.least_ttc_s, TTC_EDGES_S)[0]
        return [
            self._by_drive("Warnings per hour", "warnings per hour", self.warnings_per_hour),
            self._by_drive(
                "Camera pitch at the end of the drive", "degrees below the calibration", self.mount_off_deg
            ),
            _histogram(
                "Headway to the lead", "headway, s", "share of frames with a lead", HEADWAY_EDGES_S, share
            ),
            _histogram("Minimum time to collision", "TTC, s", "events", TTC_EDGES_S, counts, 5.0),
        ]

    def html(self, out: Path) -> str:
        """The page as one file with all its pictures.

        Args:
            out: folder of the batch.
        """
        charts = "".join(chart.svg() for chart in self.charts()) if self.names else ""
        moments = "".join(_moment_html(out, name, event) for name, event in self.moments)
        notes = "".join(f"<li>{escape(name)}: {escape(note)}</li>" for name, note in self.notes)
        drives = "".join(
            f"<li>{escape(name)}{f' ({escape(camera)})' if camera else ''}</li>"
            for name, camera in zip(self.names, self.cameras, strict=True)
        )
        return (
            '<!doctype html><html lang="en"><meta charset="utf-8"><title>Fleet</title>'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<style>{_STYLE}</style><h1>{len(self.names)} drive{'s' * (len(self.names) != 1)}</h1>"
            f"{self._unfinished_html()}"
            f'<h2>Worst moments</h2><div class="moments">{moments or "None."}</div>'
            f'<h2>Fleet charts</h2><div class="charts">{charts}</div>'
            f"<h2>Drives by number</h2><ol>{drives or '<li>None.</li>'}</ol>"
            f"<h2>Notes on the drives</h2><ul>{notes or '<li>None.</li>'}</ul></html>\n"
        )

    def _unfinished_html(self) -> str:
        """How many drives are not on the page, and where the reasons are."""
        count = len(self.unfinished)
        if not count:
            return ""
        states = ", ".join(f"{number} {state.value}" for state, number in Counter(self.unfinished).items())
        return (
            f"<p><b>{count} more drive{'s are' if count != 1 else ' is'} not done</b> ({states}). The "
            f"reasons are in <code>{DRIVES_NAME}</code> beside this page, and in "
            "<code>fcw review</code> of this folder, under <i>drives not done</i>.</p>"
        )

    def _by_drive(self, title: str, y_label: str, values: Sequence[float]) -> Chart:
        """One dot for each drive over the days, or over its number if a drive has no date."""
        known = [value for value in values if np.isfinite(value)]
        low, high = min([0.0, *known]), max([0.0, *known])
        margin = max((high - low) * 0.05, LEAST_RANGE / 2)
        y_range = (low - margin if low < 0 else 0.0, high + margin)
        begun_ns = [one for one in self.begun_ns if one is not None]
        ticks: Sequence[float] = ()
        if len(begun_ns) == len(values):
            first = datetime.fromtimestamp(min(begun_ns) // 10**9, UTC).replace(hour=0, minute=0, second=0)
            xs = [one / DAY_NS - first.timestamp() / DAY_S for one in begun_ns]
            label, x_range = f"days since {first:%Y-%m-%d}, UTC", (0.0, float(np.ceil(max(xs))) or 1.0)
        else:
            xs = [float(number) for number in range(1, len(values) + 1)]
            label, x_range = "drive number, in order of name", (0.0, len(values) + 1.0)
            ticks = range(1, len(values) + 1, -(-len(values) // MOST_NUMBERS))
        cameras = sorted(set(self.cameras))
        if len(cameras) > MOST_CAMERAS:
            cameras = [""]
        series = []
        for camera in cameras:
            shown = [number for number, of in enumerate(self.cameras) if camera in ("", of)]
            points = [(xs[number], values[number]) for number in shown]
            names = [f"{number + 1}. {self.names[number]}: {values[number]:.2f}" for number in shown]
            legend = camera if len(cameras) > 1 else ""
            series.append(Series(legend, points, dot_px=4, point_names=names))
        return Chart(title, label, y_label, x_range, y_range, series, x_ticks=ticks)


def _moment_html(out: Path, name: str, event: DriveEvent) -> str:
    jpeg = read_moment(out / name, moment_name(event))
    picture = (
        f'<img alt="" src="data:image/jpeg;base64,{base64.b64encode(jpeg).decode()}">' if jpeg else "<i></i>"
    )
    ttc = "" if event.min_ttc_s is None else f", TTC {event.min_ttc_s:.1f} s"
    near = "" if event.min_distance_m is None else f", {event.min_distance_m:.1f} m"
    words = f"{escape(name)} at {event.peak_s:.1f} s: {event.kind}{ttc}{near}"
    return f"<figure>{picture}<figcaption>{words}</figcaption></figure>"


def _mount_off_deg(summary: Path, pitch_rad: float) -> float:
    try:
        mount = json_value(read_text(summary))["own_motion"]["mount"]
        return float(np.degrees(mount["pitch_rad"] - pitch_rad)) if mount else np.nan
    except (OSError, ValueError, KeyError, TypeError):
        return np.nan


def _histogram(
    title: str,
    x_label: str,
    y_label: str,
    edges: NDArray[np.float64],
    heights: NDArray[np.generic],
    least_top: float = 0.0,
) -> Chart:
    """A histogram; the vertical axis reaches at least to `least_top`."""
    steps = [
        (float(x), float(height))
        for height, *sides in zip(heights, edges[:-1], edges[1:], strict=True)
        for x in sides
    ]
    top = max(least_top, *(float(height) for height in heights)) * 1.05 or 1.0
    x_range = float(edges[0]), float(edges[-1])
    return Chart(title, x_label, y_label, x_range, (0.0, top), [Series("", steps, line=True)])
