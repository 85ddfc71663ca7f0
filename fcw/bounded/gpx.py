"""Own speed from a GPX track, as phones and dash cameras write it (GPX 1.0 and 1.1, topografix.com/GPX)."""

import math
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

from fcw.bounded.files import MalformedError, read_bytes
from fcw.bounded.formats import MOST_XML_BYTES, xml_root
from fcw.errors import UserError

EARTH_RADIUS_M = 6_371_000.0
EXPECTED = "expected a GPX track, <trkpt lat lon> with <time>"


def read_gpx(path: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Times and speeds of the points of a track.

    The speed is the receiver's own where every point has one, from Doppler shifts and better than
    positions; else the way between the neighbours of a point over the time between them.

    Returns:
        Seconds from the first point, ascending, and metres per second.

    Raises:
        UserError: the file cannot be read, has fewer than two points, or a point is not as expected.
    """
    try:
        root = xml_root(read_bytes(path, MOST_XML_BYTES))
    except FileNotFoundError:
        raise UserError(
            f"ego speed {path}: no such file; give metres per second or the path of a CSV or GPX file"
        ) from None
    except (OSError, MalformedError) as error:
        raise UserError(f"ego speed {path}: cannot be read ({error}); {EXPECTED}") from error
    points = [element for element in root.iter() if _name(element) == "trkpt"]
    if len(points) < 2:
        raise UserError(f"ego speed {path}: {len(points)} track points; {EXPECTED}, at least two")
    times_s: list[float] = []
    places: list[tuple[float, float]] = []
    speeds: list[str | None] = []
    for number, point in enumerate(points, 1):
        texts = {_name(element): (element.text or "").strip() for element in point.iter()}
        try:
            time_s = _seconds(texts["time"])
            place = _degrees(point, "lat", 90.0), _degrees(point, "lon", 180.0)
        except (KeyError, ValueError, OverflowError) as error:
            raise UserError(f"ego speed {path}, track point {number}: {error!s}; {EXPECTED}") from None
        if times_s and time_s <= times_s[-1]:
            raise UserError(
                f"ego speed {path}, track point {number}: its time is not after that of the point before; "
                "sort the points by time, each once"
            )
        times_s.append(time_s)
        places.append(place)
        speeds.append(texts.get("speed"))
    relative_s = tuple(time_s - times_s[0] for time_s in times_s)
    try:
        given = tuple(float(speed) for speed in speeds if speed is not None)
    except ValueError as error:
        raise UserError(f"ego speed {path}: {error}; expected metres per second in <speed>") from None
    return relative_s, given if len(given) == len(points) else _from_places(relative_s, places)


def _from_places(times_s: tuple[float, ...], places: list[tuple[float, float]]) -> tuple[float, ...]:
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
