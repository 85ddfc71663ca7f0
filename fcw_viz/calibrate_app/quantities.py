"""What can be typed on the page: numbers with or without a unit, and between which limits they make sense."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from fcw.camera.points import FARTHEST_POINT_M
from fcw.errors import UserError
from fcw.units import FEET_PER_METRE

_FOOT_M = 1 / FEET_PER_METRE
_LENGTH_UNITS: dict[str, float] = {
    **dict.fromkeys(("m", "metre", "metres", "meter", "meters"), 1.0),
    **dict.fromkeys(("cm", "centimetre", "centimetres", "centimeter", "centimeters"), 0.01),
    **dict.fromkeys(("mm", "millimetre", "millimetres", "millimeter", "millimeters"), 0.001),
    **dict.fromkeys(("ft", "ft.", "foot", "feet", "'", "′"), _FOOT_M),
    **dict.fromkeys(("in", "in.", "inch", "inches", '"', "″"), _FOOT_M / 12),
    **dict.fromkeys(("yd", "yard", "yards"), 3 * _FOOT_M),
}
_ANGLE_UNITS: dict[str, float] = dict.fromkeys(("°", "deg", "degree", "degrees"), math.radians(1))
_SPEED_UNITS: dict[str, float] = {
    **dict.fromkeys(("km/h", "kmh", "kph"), 1 / 3.6),
    **dict.fromkeys(("m/s", "mps"), 1.0),
    **dict.fromkeys(("mph", "mi/h"), 1609.344 / 3600),
}
_PART_UNITS: dict[str, float] = {"%": 0.01}
_PIXEL_UNITS: dict[str, float] = dict.fromkeys(("px", "pixel", "pixels"), 1.0)
_NUMBER = re.compile(r"([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:e[+-]?\d+)?)\s*(.*)", re.IGNORECASE)
_FEET_AND_INCHES = re.compile(r"(\d+)\s*(?:ft|feet|foot|'|′)\s*(\d+(?:[.,]\d+)?)\s*(?:in|inches|\"|″)?")


@dataclass(frozen=True, slots=True)
class Quantity:
    """Something that is typed.

    Attributes:
        meaning: what it is, with its article.
        examples: how it may be typed.
        units: what each unit that may be typed is in those of the value (metres, radians, pixels).
        lowest: smallest value that is taken.
        highest: largest one.
    """

    meaning: str
    examples: str
    units: Mapping[str, float]
    lowest: float
    highest: float

    def read(self, text: str, unit: float = 1.0) -> float | None:
        """The value of a text; None for an empty one.

        Args:
            text: a number with a point or a comma, and a unit if one likes.
            unit: what a number without a unit counts in.

        Raises:
            UserError: it is no number of this kind; the text says what was expected.
        """
        text = text.strip()
        if not text:
            return None
        value = self._value(text, unit)
        if value is None:
            raise UserError(f"{text!r} is not {self.meaning}: type {self.examples}, or leave it empty")
        if not self.lowest <= value <= self.highest:
            low, high = (_limit_text(limit / unit) for limit in (self.lowest, self.highest))
            raise UserError(
                f"{text!r} is not {self.meaning}: expected {low} to {high}{self._unit_name(unit)}"
            )
        return value

    def _value(self, text: str, unit: float) -> float | None:
        if self.units is _LENGTH_UNITS and (both := _FEET_AND_INCHES.fullmatch(text)):
            return (int(both[1]) + float(both[2].replace(",", ".")) / 12) * _FOOT_M
        found = _NUMBER.fullmatch(text)
        if found is None:
            return None
        number = float(found[1].replace(",", "."))
        size = self.units.get(found[2].strip().lower()) if found[2] else unit
        return number * size if size is not None and math.isfinite(number) else None

    def _unit_name(self, unit: float) -> str:
        """The shortest name of a unit, as it follows a number."""
        names = [name for name, size in self.units.items() if math.isclose(size, unit)]
        return "" if not names else names[0] if names[0] == "°" else f" {names[0]}"


def _limit_text(limit: float) -> str:
    return f"{limit:.3g}" if abs(limit) < 1000 else f"{limit:.0f}"


DISTANCE = Quantity("a distance along the road", "15, 4.5 m or 50 ft", _LENGTH_UNITS, 0.3, FARTHEST_POINT_M)
HEIGHT = Quantity("a height above the road", "1.3, 130 cm or 4 ft 3 in", _LENGTH_UNITS, 0.001, 10_000.0)
"""The limits are wide: a height in millimetres typed as metres is recognised, and mended by a button."""
OFFSET = Quantity("a length along the car", "1.8, 180 cm or 6 ft", _LENGTH_UNITS, 0.0, 20.0)
LENGTH_ERROR = Quantity("the error of a length", "0.05, 5 cm or 2 in", _LENGTH_UNITS, 0.001, 10.0)
FIELD_OF_VIEW = Quantity("a field of view", "65 or 65°", _ANGLE_UNITS, math.radians(5), math.radians(175))
ANGLE_ERROR = Quantity("the error of an angle", "3 or 3°", _ANGLE_UNITS, math.radians(0.01), math.radians(90))
ROW = Quantity("a row of the picture", "310 or 310.5", _PIXEL_UNITS, -1e5, 1e5)
ROW_ERROR = Quantity("the error of a row", "1 or 0.3 px", _PIXEL_UNITS, 0.001, 1e4)
TURN = Quantity("an angle to the side", "2, -1.5 or 2°", _ANGLE_UNITS, -math.radians(30), math.radians(30))
TILT = Quantity("a tilt to the right", "2, -1.5 or 2°", _ANGLE_UNITS, -math.radians(30), math.radians(30))
"""Below 0 to the left."""
WIDTH = Quantity("a width of a lane", "3.7, 3.5 m or 12 ft", _LENGTH_UNITS, 1.5, 8.0)
SIDE = Quantity("a side of a rectangle", "2.5, 250 cm or 8 ft", _LENGTH_UNITS, 0.3, 100.0)
PLATE_WIDTH = Quantity("a width of a number plate", "0.52, 52 cm or 12 in", _LENGTH_UNITS, 0.1, 1.0)
SPEED = Quantity("a speed", "100, 27 m/s or 60 mph", _SPEED_UNITS, 1.0, 100.0)
SPEED_ERROR = Quantity("the error of a speed", "2 or 1 mph", _SPEED_UNITS, 0.01, 30.0)
TAPE = Quantity("the error of a tape", "1 or 0.5 %", _PART_UNITS, 0.0, 0.3)
