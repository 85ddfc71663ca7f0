"""When and where a drive was, as the page says it."""

import math
import xml.etree.ElementTree as ET
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from review_drives import CAUTION_S, DURATION_S, PERIOD_NS, header, result

from fcw.bounded.gpx import EARTH_RADIUS_M
from fcw.logs.mcap.writer import McapSink
from fcw_viz.review_app.drive import Drive, utc_text
from fcw_viz.review_app.panels.map import map_html, metres

SVG = "{http://www.w3.org/2000/svg}"
START = datetime(2026, 11, 20, 23, 59, 50, tzinfo=UTC)
NORTH_MPS = 20.0


def gpx(seconds: int) -> bytes:
    """A way straight to the north."""
    points = "".join(
        f'<trkpt lat="{48 + math.degrees(NORTH_MPS * k / EARTH_RADIUS_M):.8f}" lon="11">'
        f"<time>2026-11-20T08:{k // 60:02d}:{k % 60:02d}Z</time></trkpt>"
        for k in range(seconds)
    )
    return f"<gpx><trk><trkseg>{points}</trkseg></trk></gpx>".encode()


def drive(path: Path, track: bytes = b"", utc: bool = True, frames: int = round(DURATION_S * 25)) -> Drive:
    zero_ns = round(START.timestamp()) * 10**9 if utc else None
    sink = McapSink(path / "drive.mcap")
    sink.open(replace(header(), zero_utc_ns=zero_ns, gpx=track))
    for index in range(frames):
        sink.write(result(index), ())
    sink.close()
    return Drive.open("made", path / "drive.mcap")


def test_a_drive_says_when_it_was(tmp_path: Path):
    made = drive(tmp_path, frames=5)
    assert made.zero_utc_ns is not None
    # The made drive begins five seconds after its clock's zero.
    assert utc_text(made.zero_utc_ns, True) == "2026-11-20 23:59:55 UTC"
    assert utc_text(made.zero_utc_ns + 5 * 10**9, False) == "00:00:00 UTC"


def test_a_clock_that_counts_from_1970_says_it_too(tmp_path: Path):
    made = drive(tmp_path, utc=False, frames=5)
    assert made.zero_utc_ns is None
    stamped = replace(made.series, time_ns=round(START.timestamp()) * 10**9 + np.arange(5) * PERIOD_NS)
    recorded = replace(made, series=stamped)
    assert recorded.zero_utc_ns is not None
    assert utc_text(recorded.zero_utc_ns, True) == "2026-11-20 23:59:50 UTC"


@pytest.fixture(scope="module")
def tracked(tmp_path_factory: pytest.TempPathFactory) -> Drive:
    return drive(tmp_path_factory.mktemp("tracked"), gpx(40))


@pytest.mark.parametrize("time_s", [0.0, 10.5, 20.0])
def test_the_map_shows_where_one_is_and_where_events_were(tracked: Drive, time_s: float):
    html = map_html(tracked, time_s)
    svg = ET.fromstring(html[html.index("<svg") : html.index("</svg>") + len("</svg>")])
    circles = {circle.get("r"): circle for circle in svg.iter(f"{SVG}circle")}
    here, caution = float(circles["6"].get("cy", "")), svg.find(f"{SVG}g[@data-fcw='event:0']/{SVG}circle")
    assert caution is not None
    way = next(line for line in svg.iter(f"{SVG}polyline") if line.get("stroke-width") == "2.4")
    ends = [float(point.split(",")[1]) for point in way.get("points", "").split()]
    # North is up, and a way at one speed is as long as its time.
    bottom, top = ends[0], ends[-1]
    assert top < bottom
    assert here == pytest.approx(bottom + (top - bottom) * time_s / math.floor(tracked.duration_s), abs=0.3)
    expected = bottom + (top - bottom) * CAUTION_S / math.floor(tracked.duration_s)
    assert float(caution.get("cy", "")) == pytest.approx(expected, abs=0.3)


def test_a_track_that_ends_before_the_drive_says_so(tmp_path: Path):
    assert "the track ends before this moment" in map_html(drive(tmp_path, gpx(10)), 12.0)


def test_without_a_track_or_with_a_broken_one_there_is_no_map(tmp_path: Path):
    assert map_html(drive(tmp_path, frames=5), 0.0) == ""
    assert map_html(drive(tmp_path, b"<gpx>", frames=5), 0.0) == ""


def test_metres_on_the_ground():
    east_m, north_m = metres([(48.0, 179.9995), (48.001, -179.9995)])[1]
    assert north_m == pytest.approx(EARTH_RADIUS_M * math.radians(0.001))
    assert east_m == pytest.approx(EARTH_RADIUS_M * math.radians(0.001) * math.cos(math.radians(48.0005)))
