"""The fields of a calibration file, taken one by one and checked; all raise UserError with file and field."""

import math
from typing import Any

import numpy as np

from fcw.bounded.pictures import LONGEST_SIDE_PX
from fcw.camera.calibration import (
    Gaussian,
    GroundPoint,
    GroundRectangle,
    Matrix3,
    NumberPlate,
    Places,
    Priors,
    Vector3,
)
from fcw.camera.lens.model import COEFFICIENT_COUNTS, DISTORTION_MODELS, Lens
from fcw.camera.points import MOST_M
from fcw.camera.straight import MOST_TURN_RAD, Orientation
from fcw.errors import UserError
from fcw.frame import ImageSize

PRIOR_FIELDS = ("field_of_view_rad", "principal_row_px", "horizon_row_px")
RECTANGLE_CORNERS, PLATE_PLACES = 4, 3
LARGEST, LEAST_SIGMA = 1e12, 1e-9
"""Of any number, and of any standard deviation: beyond these sums of squares lose their digits."""
LEAST_FOCAL_PX, MOST_FOCAL_PX = 1.0, 1e6
"""A pixel of the smallest pictures, and a telescope of a degree on the largest."""


class Fields:
    """One mapping of the file, its fields taken one by one, so that what is left over is a mistake."""

    def __init__(self, file_name: str, prefix: str, values: dict[str, Any]) -> None:
        self._file_name = file_name
        self._prefix = prefix
        self._values = dict(values)

    def wrong(self, field: str, value: object, expected: str) -> UserError:
        """The error of a value that is not as expected."""
        return UserError(
            f"{self._file_name}: {self._prefix}{field} is {repr(value)[:80]}, expected {expected}"
        )

    def take(self, field: str) -> Any:  # noqa: ANN401 - whatever YAML holds
        """The value of a field, which is then done with; an error where it is missing."""
        if field not in self._values:
            raise UserError(
                f"{self._file_name}: {self._prefix}{field} is missing; "
                "add it or calibrate again with `fcw calibrate`"
            )
        return self._values.pop(field)

    def finish(self) -> None:
        """An error where a field is left over."""
        for field, value in self._values.items():
            raise self.wrong(str(field), value, "no field of that name; remove it")

    def section(self, field: str) -> "Fields":
        """A mapping within."""
        return self._section(field, self.take(field))

    def _section(self, field: str, value: object) -> "Fields":
        if not isinstance(value, dict):
            raise self.wrong(field, value, "a mapping of fields")
        return Fields(self._file_name, f"{self._prefix}{field}.", value)

    def sections(self, field: str) -> list["Fields"]:
        """A list of mappings."""
        value = self.take(field)
        if not isinstance(value, list):
            raise self.wrong(field, value, "a list")
        return [self._section(f"{field}[{index}]", item) for index, item in enumerate(value)]

    def checked(self, field: str, value: object) -> float:
        """A value as a finite number, no larger than any that counts."""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise self.wrong(field, value, "a finite number")
        if abs(value) > LARGEST:
            raise self.wrong(field, value, f"a number between {-LARGEST:g} and {LARGEST:g}")
        return float(value)

    def number(
        self,
        field: str,
        *,
        positive: bool = False,
        at_least: float = -math.inf,
        at_most: float = math.inf,
        above: float = -math.inf,
        below: float = math.inf,
    ) -> float:
        """A finite number within limits."""
        number = self.checked(field, self.take(field))
        if positive and number <= 0:
            raise self.wrong(field, number, "a number above 0")
        if number < at_least:
            raise self.wrong(field, number, f"a number of at least {at_least:g}")
        if number > at_most:
            raise self.wrong(field, number, f"a number of at most {at_most:g}")
        if not above < number < below:
            raise self.wrong(field, number, f"a number between {above:.6g} and {below:.6g}")
        return number

    def focal_length(self, field: str) -> float:
        """A focal length in pixels."""
        return self.number(field, positive=True, at_least=LEAST_FOCAL_PX, at_most=MOST_FOCAL_PX)

    def optional_number(self, field: str) -> float | None:
        """A finite number; None for null."""
        value = self.take(field)
        return None if value is None else self.checked(field, value)

    def count(self, field: str) -> int:
        """A whole number of pixels of a picture's side."""
        value = self.take(field)
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= LONGEST_SIDE_PX:
            raise self.wrong(field, value, f"a whole number of at least 1, at most {LONGEST_SIDE_PX}")
        return value

    def numbers(self, field: str, count: int) -> tuple[float, ...]:
        """So many finite numbers."""
        value = self.take(field)
        if not isinstance(value, list) or len(value) != count:
            raise self.wrong(field, value, f"a list of {count} numbers")
        return tuple(self.checked(f"{field}[{index}]", item) for index, item in enumerate(value))

    def gaussian(self, field: str) -> Gaussian | None:
        """A value with its sigma; None for null."""
        value = self.take(field)
        if value is None:
            return None
        section = self._section(field, value)
        number = section.number("value")
        gaussian = Gaussian(number, section.number("sigma", positive=True, at_least=LEAST_SIGMA))
        section.finish()
        return gaussian

    def priors(self, field: str) -> Priors:
        """What is known of the lens and the horizon."""
        section = self.section(field)
        priors = Priors(*(section.gaussian(name) for name in PRIOR_FIELDS))
        section.finish()
        return priors

    def orientation(self, field: str) -> Orientation:
        """Yaw and roll with their sigmas."""
        section = self.section(field)
        limit = MOST_TURN_RAD
        orientation = Orientation(
            section.number("yaw_rad", above=-limit, below=limit),
            section.number("roll_rad", above=-limit, below=limit),
            section.number("yaw_sigma_rad", at_least=0.0, at_most=math.pi),
            section.number("roll_sigma_rad", at_least=0.0, at_most=math.pi),
        )
        section.finish()
        return orientation

    def lens(self, field: str, image_size: ImageSize) -> Lens | None:
        """Intrinsics and distortion of pictures of a size; None for null."""
        value = self.take(field)
        if value is None:
            return None
        section = self._section(field, value)
        model = section.take("model")
        if model not in DISTORTION_MODELS:
            raise section.wrong("model", model, f"one of {', '.join(DISTORTION_MODELS)}")
        coefficients = section.take("coefficients")
        if not isinstance(coefficients, list) or len(coefficients) not in COEFFICIENT_COUNTS[model]:
            counts = " or ".join(map(str, COEFFICIENT_COUNTS[model]))
            raise section.wrong("coefficients", coefficients, f"a list of {counts} numbers")
        lens = Lens(
            model,
            section.focal_length("focal_x_px"),
            section.focal_length("focal_y_px"),
            section.number("column_px"),
            section.number("row_px"),
            tuple(section.checked(f"coefficients[{k}]", c) for k, c in enumerate(coefficients)),
            image_size,
        )
        section.finish()
        return lens

    def support_distances(self, field: str, pole_m: float) -> Vector3:
        """Three ascending distances in front of the camera."""
        near, middle, far = self.numbers(field, 3)
        if not 0 < near < middle < far or near + pole_m <= 0:
            raise self.wrong(field, [near, middle, far], "three ascending distances in front of the camera")
        return near, middle, far

    def covariance(self, field: str) -> Matrix3:
        """Three rows of three numbers, symmetric and of no negative variance."""
        value = self.take(field)
        if not isinstance(value, list) or len(value) != 3:
            raise self.wrong(field, value, "three rows of three numbers")
        rows = []
        for index, row in enumerate(value):
            if not isinstance(row, list) or len(row) != 3:
                raise self.wrong(f"{field}[{index}]", row, "three numbers")
            rows.append(tuple(self.checked(f"{field}[{index}][{k}]", item) for k, item in enumerate(row)))
        matrix = np.array(rows)
        tolerance = 1e-9 * max(1.0, float(np.abs(matrix).max()))
        if (
            not np.allclose(matrix, matrix.T, rtol=0, atol=tolerance)
            or np.linalg.eigvalsh(matrix)[0] < -tolerance
        ):
            raise self.wrong(field, value, "a symmetric matrix without negative eigenvalues")
        return rows[0], rows[1], rows[2]

    def points(self, field: str) -> tuple[GroundPoint, ...]:
        """Points of the road."""
        found = []
        for section in self.sections(field):
            distance_m = section.number("distance_m", positive=True, at_most=MOST_M)
            row_px, column_px = section.number("row_px"), section.optional_number("column_px")
            section.finish()
            found.append(GroundPoint(distance_m, row_px, column_px))
        return tuple(found)

    def rectangles(self, field: str) -> tuple[GroundRectangle, ...]:
        """Rectangles on the road."""
        return tuple(section.rectangle() for section in self.sections(field))

    def rectangle(self) -> GroundRectangle:
        """This section as a rectangle."""
        corners_px = self.places("corners_px", RECTANGLE_CORNERS)
        along = self.take("along")
        if not isinstance(along, bool):
            raise self.wrong("along", along, "true or false")
        sides = (self.gaussian("first_side_m"), self.gaussian("second_side_m"))
        self.finish()
        return GroundRectangle(corners_px, *sides, along)

    def plates(self, field: str) -> tuple[NumberPlate, ...]:
        """Number plates of vehicles ahead."""
        found = []
        for section in self.sections(field):
            places_px, width_m = section.places("places_px", PLATE_PLACES), section.gaussian("width_m")
            if width_m is None:
                raise section.wrong("width_m", None, "value and sigma")
            section.finish()
            found.append(NumberPlate(places_px, width_m))
        return tuple(found)

    def places(self, field: str, count: int) -> Places:
        """So many columns and rows."""
        value = self.take(field)
        if not isinstance(value, list) or len(value) != count:
            raise self.wrong(field, value, f"{count} places, column and row each")
        found = []
        for index, place in enumerate(value):
            if not isinstance(place, list) or len(place) != 2:
                raise self.wrong(f"{field}[{index}]", place, "column and row")
            column_px, row_px = (self.checked(f"{field}[{index}]", number) for number in place)
            found.append((column_px, row_px))
        return tuple(found)
