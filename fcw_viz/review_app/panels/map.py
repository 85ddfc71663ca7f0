"""The way of a drive as a small map, north up: of its track alone, with nothing from elsewhere."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.gpx import EARTH_RADIUS_M, GpxTrack
from fcw.charts.scale import round_values
from fcw.charts.svg import element, line, picture, words
from fcw.units import FEET_PER_METRE
from fcw_viz.page.channel import says
from fcw_viz.page.style import text_block
from fcw_viz.review_app.drive import Drive, time_text
from fcw_viz.review_app.time.timeline import kind_color

WIDTH_PX, HEIGHT_PX, MARGIN_PX = 322.0, 118.0, 14.0
MOST_POINTS = 400
LEAST_M = 40.0
"""A drive that hardly moved is not drawn larger than this."""
SCALE_SHARE = 0.3
"""Of the map's width, at the most, for the bar that tells its scale."""

Floats = NDArray[np.float64]


def map_html(drive: Drive, time_s: float) -> str:
    """The map; a click on an event is `event:<its number>`. Nothing for a drive without a track.

    Args:
        drive: the drive.
        time_s: the moment that is shown.
    """
    track = drive.track
    if track is None:
        return ""
    room = f"<style>:root {{ --fcw-map: {HEIGHT_PX + 14:.0f}px; }}</style>"
    return room + text_block(f'<div class="fcw-map">{map_svg(track, drive, time_s)}</div>')


def map_svg(track: GpxTrack, drive: Drive, time_s: float) -> str:
    """The map as SVG, see `map_html`."""
    times_s = np.array(track.times_s)
    points_m = metres(track.places)
    during = (times_s >= 0) & (times_s <= drive.duration_s)
    shown_m = points_m[during] if during.sum() > 1 else points_m
    middle_m = (shown_m.min(axis=0) + shown_m.max(axis=0)) / 2
    span_m = np.maximum(shown_m.max(axis=0) - shown_m.min(axis=0), LEAST_M)
    scale = min((WIDTH_PX - 2 * MARGIN_PX) / span_m[0], (HEIGHT_PX - 2 * MARGIN_PX) / span_m[1])

    def places(points: Floats) -> list[tuple[float, float]]:
        east, north = ((points - middle_m) * scale).T
        return list(zip((WIDTH_PX / 2 + east).tolist(), (HEIGHT_PX / 2 - north).tolist(), strict=True))

    def at(moment_s: float) -> tuple[float, float] | None:
        if not times_s[0] <= moment_s <= times_s[-1]:
            return None
        point = [np.interp(moment_s, times_s, points_m[:, axis]) for axis in (0, 1)]
        return places(np.array([point]))[0]

    every = max(1, len(points_m) // MOST_POINTS)
    way = {"fill": "none", "stroke_linejoin": "round", "stroke": "currentColor"}
    kept = np.unique(np.r_[np.flatnonzero(during)[::every], np.flatnonzero(during)[-1:]])
    parts = [
        element("polyline", points=places(points_m[::every]), **way, stroke_width=1.2, stroke_opacity=0.25),
        element("polyline", points=places(points_m[kept]), **way, stroke_width=2.4, stroke_opacity=0.7),
    ]
    for number, event in enumerate(drive.events):
        place = at(event.peak_s)
        if place is not None:
            title = element("title", f"{event.kind} at {time_text(event.start_s)}")
            dot = element(
                "circle", title, cx=place[0], cy=place[1], r=4, fill=kind_color(event.kind), stroke="white"
            )
            parts.append(f'<g class="fcw-mark" {says(f"event:{number}")}>{dot}</g>')
    here = at(time_s)
    if here is None:
        parts.append(words(WIDTH_PX / 2, 12, "the track ends before this moment", "middle", 0.7))
    else:
        cx, cy = here
        parts.append(
            element("circle", cx=cx, cy=cy, r=6, fill="none", stroke="rgb(34, 139, 230)", stroke_width=3)
        )
    parts += _scale_bar(scale, drive.header.imperial)
    parts += [words(WIDTH_PX - 10, 13, "N", "middle", 0.7), line(WIDTH_PX - 10, 16, WIDTH_PX - 10, 28, 0.6)]
    return picture(WIDTH_PX, HEIGHT_PX, parts, "Route of the drive, north up")


def metres(places: Sequence[tuple[float, float]]) -> Floats:
    """(N, 2) metres to the east and to the north of the first place: flat, right to 1e-4 within some 10 km.

    Args:
        places: latitudes and longitudes in degrees.
    """
    degrees = np.array(places)
    turned = np.radians(degrees - degrees[0])
    turned[:, 1] = (turned[:, 1] + math.pi) % (2 * math.pi) - math.pi  # over the date line
    latitude = np.radians((degrees[:, 0] + degrees[0, 0]) / 2)
    return EARTH_RADIUS_M * np.stack([turned[:, 1] * np.cos(latitude), turned[:, 0]], axis=1)


def _scale_bar(scale: float, imperial: bool) -> list[str]:
    """A bar of a round length, in the lower left corner.

    Args:
        scale: pixels of a metre.
        imperial: units.
    """
    per_unit = scale / FEET_PER_METRE if imperial else scale
    length = round_values(0.0, SCALE_SHARE * WIDTH_PX / per_unit, 2)[-1]
    width = length * per_unit
    y = HEIGHT_PX - 6
    text = f"{length:g} ft" if imperial else f"{length / 1000:g} km" if length >= 1000 else f"{length:g} m"
    ends = [line(x, y - 4, x, y, 0.7) for x in (6, 6 + width)]
    return [line(6, y, 6 + width, y, 0.7), *ends, words(10 + width, y, text, opacity=0.7, size=10)]
