"""A GPX track, as phones and dash cameras write it (GPX 1.0 and 1.1, topografix.com/GPX), and its speed."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

from fcw.bounded.files import MalformedError, read_bytes
from fcw.bounded.formats import MOST_XML_BYTES, xml_root
from fcw.errors import UserError

EARTH_RADIUS_M = 6_371_000.0
EXPECTED = "expected a GPX track, <trkpt lat lon> with <time>"


@dataclass(frozen=True, slots=True)
class GpxTrack:
    """The points of a track, in the order of time.

    Attributes:
        start_s: time of the first point, in seconds since 1970, UTC.
        times_s: of the points, from the first one, or from whatever `later` counts.
        places: latitude and longitude of each, in degrees.
        speeds_mps: the receiver's own; None where a point has none.
    """

    start_s: float
    times_s: tuple[float, ...]
    places: tuple[tuple[float, float], ...]
    speeds_mps: tuple[float | None, ...]

    def later(self, seconds: float) -> "GpxTrack":
        """The same places, so many seconds later; or earlier, if it is below 0."""
        return replace(self, times_s=tuple(time_s + seconds for time_s in self.times_s))

    def place_at(self, time_s: float) -> tuple[float, float] | None:
        """Latitude and longitude in degrees, on the straight line between two points.

        Args:
            time_s: on the clock of `times_s`; None comes of one before the first point or after the last.
        """
        if not self.times_s[0] <= time_s <= self.times_s[-1]:
            return None
        after = min(max(bisect_right(self.times_s, time_s), 1), len(self.times_s) - 1)
        (north, east), (north_after, east_after) = self.places[after - 1], self.places[after]
        start_s, end_s = self.times_s[after - 1], self.times_s[after]
        part = (time_s - start_s) / (end_s - start_s)
        turn = (east_after - east + 180.0) % 360.0 - 180.0  # the shorter way around the earth
        east = (east + part * turn + 180.0) % 360.0 - 180.0
        return north + part * (north_after - north), east


def read_gpx(path: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Times and speeds of the points of a track.

    The speed is the receiver's own where every point has one, from Doppler shifts and better than
    positions; else the way between the neighbours of a point over the time between them.

    Returns:
        Seconds from the first point, ascending, and metres per second.

    Raises:
        UserError: the file cannot be read, has fewer than two points, or a point is not as expected.
    """
    track = parse_gpx(gpx_bytes(path), f"ego speed {path}")
    given = tuple(speed for speed in track.speeds_mps if speed is not None)
    whole = len(given) == len(track.times_s)
    return track.times_s, given if whole else _from_places(track.times_s, track.places)


def gpx_bytes(path: Path) -> bytes:
    """A GPX file as it is.

    Raises:
        UserError: it cannot be read.
    """
    try:
        return read_bytes(path, MOST_XML_BYTES)
    except FileNotFoundError:
        raise UserError(
            f"ego speed {path}: no such file; give metres per second or the path of a CSV or GPX file"
        ) from None
    except (OSError, MalformedError) as error:
        raise UserError(f"ego speed {path}: cannot be read ({error}); {EXPECTED}") from error


def parse_gpx(data: bytes, name: str) -> GpxTrack:
    """The track in a GPX file.

    Args:
        data: the file.
        name: of it, for messages.

    Raises:
        UserError: it has fewer than two points, or a point is not as expected.
    """
    try:
        root = xml_root(data)
    except MalformedError as error:
        raise UserError(f"{name}: cannot be read ({error}); {EXPECTED}") from error
    points = [element for element in root.iter() if _name(element) == "trkpt"]
    if len(points) < 2:
        raise UserError(f"{name}: {len(points)} track points; {EXPECTED}, at least two")
    times_s: list[float] = []
    places: list[tuple[float, float]] = []
    speeds: list[str | None] = []
    for number, point in enumerate(points, 1):
        texts = {_name(element): (element.text or "").strip() for element in point.iter()}
        try:
            time_s = _seconds(texts["time"])
            place = _degrees(point, "lat", 90.0), _degrees(point, "lon", 180.0)
        except (KeyError, ValueError, OverflowError) as error:
            raise UserError(f"{name}, track point {number}: {error!s}; {EXPECTED}") from None
        if times_s and time_s <= times_s[-1]:
            raise UserError(
                f"{name}, track point {number}: its time is not later than that of the point before; "
                "sort the points by time, and remove duplicates"
            )
        times_s.append(time_s)
        places.append(place)
        speeds.append(texts.get("speed"))
    try:
        given = tuple(None if speed is None else float(speed) for speed in speeds)
    except ValueError as error:
        raise UserError(f"{name}: {error}; expected metres per second in <speed>") from None
    return GpxTrack(times_s[0], tuple(time_s - times_s[0] for time_s in times_s), tuple(places), given)


def _from_places(times_s: tuple[float, ...], places: Sequence[tuple[float, float]]) -> tuple[float, ...]:
    ways_m = [_distance_m(a, b) for a, b in pairwise(places)]
    last = len(places) - 1
    speeds = []
    for index in range(len(places)):
        first, end = max(index - 1, 0), min(index + 1, last)
        speeds.append(sum(ways_m[first:end]) / (times_s[end] - times_s[first]))
    return tuple(speeds)


def _distance_m(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Great-circle distance of two latitudes and longitudes in degrees, by the haversine formula."""
    (lat_a, lon_a), (lat_b, lon_b) = (tuple(map(math.radians, place)) for place in (a, b))
    square = (
        math.sin((lat_b - lat_a) / 2) ** 2
        + math.cos(lat_a) * math.cos(lat_b) * math.sin((lon_b - lon_a) / 2) ** 2
    )
    return 2 * EARTH_RADIUS_M * math.asin(math.sqrt(min(square, 1.0)))


def _degrees(point: ElementTree.Element, name: str, most: float) -> float:
    degrees = float(point.attrib[name])
    if not abs(degrees) <= 2 * most:  # longitudes beyond 180 are counted on
        raise ValueError(f"{name} is {point.attrib[name]!r}, expected degrees")
    return degrees


def _seconds(text: str) -> float:
    moment = datetime.fromisoformat(text)
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def _name(element: ElementTree.Element) -> str:
    """The tag without its name space."""
    return element.tag.rpartition("}")[2]
