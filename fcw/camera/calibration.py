"""The calibration of one drive's camera: the camera, and how well it is known.

The uncertainty is kept as the covariance of the image rows at three support distances. Three rows fix the
whole projective row map, and they are what a person measures: with three free clicks the covariance is
exactly row_sigma^2 times the identity, however ill-conditioned pitch, focal length and principal row are.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import overload

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.interval import UncertainRowMap, Vector3, distance_interval, row_gradients
from fcw.camera.lens.model import Lens
from fcw.camera.lens.pixel_map import PixelMap
from fcw.camera.straight import LEVEL, Orientation, Straightening, Undone
from fcw.errors import UserError
from fcw.frame import ImageSize

Matrix3 = tuple[Vector3, Vector3, Vector3]
Places = tuple[tuple[float, float], ...]
"""Columns and rows."""

DEFAULT_SUPPORT_M: Vector3 = (5.0, 10.0, 20.0)
"""Support distances where no points suggest others: well apart in row, and in front of any camera."""
ASPECT_TOLERANCE_PX = 1.0
"""Sizes of one camera's pictures are rounded to whole pixels: 480 rows of 16:9 are 853.33 columns wide."""


@dataclass(frozen=True, slots=True)
class GroundPoint:
    """A point of the road somebody clicked.

    Attributes:
        distance_m: along the ground from the calibration's reference.
        row_px: its row in the picture.
        column_px: its column, where known.
    """

    distance_m: float
    row_px: float
    column_px: float | None = None

    def __str__(self) -> str:
        column = "" if self.column_px is None else f":{self.column_px:g}"
        return f"{self.distance_m:g}:{self.row_px:g}{column}"


@dataclass(frozen=True, slots=True)
class Gaussian:
    """A value believed before any click, and its standard deviation."""

    value: float
    sigma: float


@dataclass(frozen=True, slots=True)
class GroundRectangle:
    """A rectangle on the road that somebody clicked: a parking bay, a field of a crossing.

    Attributes:
        corners_px: columns and rows of its four corners, going round it either way from any of them.
        first_side_m: from the first corner to the second one; None where it is not known.
        second_side_m: from the second corner to the third one, likewise.
        along: whether its sides lie along and across the direction of travel.
    """

    corners_px: Places
    first_side_m: Gaussian | None = None
    second_side_m: Gaussian | None = None
    along: bool = False

    @property
    def sides_m(self) -> tuple[Gaussian | None, Gaussian | None]:
        """Both sides."""
        return self.first_side_m, self.second_side_m

    @property
    def has_size(self) -> bool:
        """Whether a side is known, so that it tells how large everything is."""
        return self.sides_m != (None, None)

    @property
    def swapped(self) -> "GroundRectangle":
        """The same corners with the sides exchanged."""
        return replace(self, first_side_m=self.second_side_m, second_side_m=self.first_side_m)


@dataclass(frozen=True, slots=True)
class NumberPlate:
    """A number plate that somebody clicked on a vehicle seen from behind.

    Attributes:
        places_px: columns and rows of its two ends, and of where a rear tyre of that vehicle meets the road.
        width_m: from end to end.
    """

    places_px: Places
    width_m: Gaussian


@dataclass(frozen=True, slots=True)
class Priors:
    """Weak knowledge that took part in a calibration; None where there was none.

    Attributes:
        field_of_view_rad: horizontal field of view of the whole picture.
        principal_row_px: row of the optical axis.
        horizon_row_px: row of the horizon, e.g. where two straight lane lines meet.
    """

    field_of_view_rad: Gaussian | None = None
    principal_row_px: Gaussian | None = None
    horizon_row_px: Gaussian | None = None

    @property
    def count(self) -> int:
        """How many there are."""
        return sum(
            prior is not None
            for prior in (self.field_of_view_rad, self.principal_row_px, self.horizon_row_px)
        )

    def through(self, pixels: PixelMap, size: ImageSize) -> "Priors":
        """What was said of pictures of a size, of those that a map leads to: a part has another view."""
        wider, view = pixels.size.width / (pixels.across * size.width), self.field_of_view_rad
        if view is not None:
            half = wider * math.tan(view.value / 2)
            by_view = wider / (math.cos(view.value / 2) ** 2 * (1 + half**2))
            view = Gaussian(2 * math.atan(half), view.sigma * by_view)

        def row(prior: Gaussian | None) -> Gaussian | None:
            return None if prior is None else Gaussian(pixels.row(prior.value), prior.sigma * pixels.down)

        return Priors(view, row(self.principal_row_px), row(self.horizon_row_px))


@dataclass(frozen=True, slots=True)
class Calibration:
    """A ground-plane camera with its uncertainty, for pictures of one size.

    Every distance it takes or gives is from the reference (the front bumper), which lies
    `reference_offset_m` ahead of the camera. `camera` itself measures from the camera.

    Attributes:
        camera: the solution.
        image_size: the pictures it holds for.
        points: the clicked points.
        row_sigma_px: standard deviation of a clicked row.
        support_distances_m: three distances from the reference, ascending.
        covariance: (3, 3), of the rows at the support distances, in pixels squared.
        reference_offset_m: from the camera forward to the reference, at least 0.
        priors: what else was said and took part.
        residuals_px: clicked row less row of the solution, for each point; three points without priors
            are met exactly, so that their zeros say nothing of the quality.
        assumed: what took part because every lens has it, where nothing was said of this one; none in the
            exact solution of three points.
        tape_error: standard deviation of the points' distances, all together, as a part of them; the
            covariance has it.
        orientation: how the real camera is turned besides its pitch. `camera` and all that is measured with
            it are of the straight picture (`fcw.camera.straight`), the points of the picture itself.
        lens: of the real camera, where its distortion is known.
        rectangles: that were clicked besides the points.
        plates: likewise.
        undone: of the straight pictures of a drive, what the camera's own have besides; None where nobody
            made pictures straight for this calibration.
    """

    camera: GroundPlaneCamera
    image_size: ImageSize
    points: tuple[GroundPoint, ...]
    row_sigma_px: float
    support_distances_m: Vector3
    covariance: Matrix3
    reference_offset_m: float = 0.0
    priors: Priors = Priors()
    residuals_px: tuple[float, ...] = ()
    assumed: Priors = Priors()
    tape_error: float = 0.0
    orientation: Orientation = LEVEL
    lens: Lens | None = None
    rectangles: tuple[GroundRectangle, ...] = ()
    plates: tuple[NumberPlate, ...] = ()
    undone: Undone | None = field(default=None, compare=False)
    _row_map: UncertainRowMap = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        support_m = np.array(self.support_distances_m) + self.reference_offset_m
        row_map = UncertainRowMap.of(
            self.camera, support_m, np.array(self.covariance), clicked=bool(self.points)
        )
        object.__setattr__(self, "_row_map", row_map)

    @classmethod
    def from_camera(
        cls, camera: GroundPlaneCamera, image_size: ImageSize, reference_offset_m: float = 0.0
    ) -> "Calibration":
        """A calibration without uncertainty, from a camera known by other means."""
        zero = (0.0, 0.0, 0.0)
        return cls(camera, image_size, (), 0.0, DEFAULT_SUPPORT_M, (zero, zero, zero), reference_offset_m)

    @property
    def straightening(self) -> Straightening | None:
        """The way to the straight picture; None where the picture is straight as it is."""
        way = Straightening(self.camera, self.orientation, self.lens, self.image_size)
        return None if way.is_identity else way

    def straight_place(self, column_px: float, row_px: float) -> tuple[float, float]:
        """Column and row in the straight picture of a place in the picture."""
        way = self.straightening
        if way is None:
            return column_px, row_px
        column, row = way.to_straight(np.array([[column_px, row_px]]))[0]
        return float(column), float(row)

    @property
    def straight_rows_px(self) -> tuple[float, ...]:
        """Rows of the points in the straight picture; a point without a column lies straight ahead."""
        way = self.straightening
        if way is None or not self.points:
            return tuple(point.row_px for point in self.points)
        ahead_px = self.camera.principal_column_px
        places = [(ahead_px if p.column_px is None else p.column_px, p.row_px) for p in self.points]
        return tuple(way.to_straight(np.array(places))[:, 1].tolist())

    def straight(self) -> "Calibration":
        """The calibration of the straight picture."""
        way, undone = self.straightening, Undone(self.orientation, self.lens)
        if way is None:
            return replace(self, orientation=LEVEL, lens=None, undone=undone)

        def moved(places: Places) -> Places:
            return _pairs(way.to_straight(np.array(places)))

        points = tuple(
            replace(point, row_px=row_px, column_px=None)
            for point, row_px in zip(self.points, self.straight_rows_px, strict=True)
        )
        straight = replace(self, points=points, orientation=LEVEL, lens=None, undone=undone)
        return straight._with_places(moved)

    @property
    def horizon_row_px(self) -> float:
        """Row of the horizon."""
        return self.camera.horizon_row_px

    @property
    def field_of_view_rad(self) -> float:
        """Horizontal field of view of the whole picture."""
        return 2 * math.atan(self.image_size.width / (2 * self.camera.focal_y_px))

    @overload
    def distance_at(self, row_px: float) -> float: ...
    @overload
    def distance_at(self, row_px: FloatArray) -> FloatArray: ...
    def distance_at(self, row_px: float | FloatArray) -> float | FloatArray:
        """Distance of the road seen at a row; inf at and above the horizon."""
        return self.camera.distance_at(row_px) - self.reference_offset_m

    @overload
    def row_at(self, distance_m: float) -> float: ...
    @overload
    def row_at(self, distance_m: FloatArray) -> FloatArray: ...
    def row_at(self, distance_m: float | FloatArray) -> float | FloatArray:
        """Row of the road at a distance."""
        return self.camera.row_at(distance_m + self.reference_offset_m)

    @overload
    def lateral_at(self, column_px: float, row_px: float) -> float: ...
    @overload
    def lateral_at(self, column_px: FloatArray, row_px: FloatArray) -> FloatArray: ...
    def lateral_at(self, column_px: float | FloatArray, row_px: float | FloatArray) -> float | FloatArray:
        """Lateral position of the road at a pixel, positive to the left; nan at and above the horizon."""
        return self.camera.lateral_at(column_px, row_px)  # pyright: ignore[reportArgumentType, reportCallIssue]

    @overload
    def column_at(self, lateral_m: float, distance_m: float) -> float: ...
    @overload
    def column_at(self, lateral_m: FloatArray, distance_m: FloatArray) -> FloatArray: ...
    def column_at(self, lateral_m: float | FloatArray, distance_m: float | FloatArray) -> float | FloatArray:
        """Column of a point of the road, lateral positive to the left."""
        return self.camera.column_at(lateral_m, distance_m + self.reference_offset_m)  # pyright: ignore[reportArgumentType, reportCallIssue]

    def ground_box(self, distance_m: float, lateral_m: float, width_m: float, height_m: float) -> Box:
        """Box of an upright rear; see `GroundPlaneCamera.ground_box`."""
        return self.camera.ground_box(distance_m + self.reference_offset_m, lateral_m, width_m, height_m)

    def distance_interval(self, row_px: float, row_sigma_px: float = 0.0) -> tuple[float, float]:
        """16th and 84th percentile of the distance seen at a row (`fcw.camera.interval` says how).

        Args:
            row_px: the row; as given, or as measured with noise of its own.
            row_sigma_px: standard deviation of that noise, independent of the calibration's.

        Returns:
            (low, high) from the reference; inf where unbounded. What is ahead of it is not behind it too: low
            is not negative, unless the distance at the row is.
        """
        low_m, high_m = distance_interval(self._row_map, row_px, row_sigma_px)
        least_m = min(self.distance_at(row_px), 0.0)
        return max(low_m - self.reference_offset_m, least_m), high_m - self.reference_offset_m

    def row_gradients(self, distances_m: FloatArray) -> FloatArray:
        """(N, 3): derivatives of the rows at N distances by the rows at the three support distances."""
        return row_gradients(self._row_map, distances_m + self.reference_offset_m)

    def for_image_size(self, size: ImageSize) -> "Calibration":
        """This calibration for the same camera's pictures in another size.

        Raises:
            UserError: the aspect ratios differ, so that it cannot be the whole picture scaled.
        """
        if size == self.image_size:
            return self
        scale = size.height / self.image_size.height
        if abs(self.image_size.width * scale - size.width) > ASPECT_TOLERANCE_PX * max(1.0, scale):
            raise UserError(
                f"the calibration is for pictures of {self.image_size}, these are {size}: "
                f"another aspect ratio; calibrate with a picture of {size}"
            )

        return self.through(PixelMap(size, size.width / self.image_size.width, scale))

    def through(self, pixels: PixelMap) -> "Calibration":
        """This calibration for the same camera's pictures that a map leads to."""
        scale = pixels.down
        camera = replace(
            self.camera,
            focal_y_px=self.camera.focal_y_px * scale,
            principal_row_px=pixels.row(self.camera.principal_row_px),
            principal_column_px=pixels.column(self.camera.principal_column_px),
        )
        points = tuple(
            GroundPoint(
                point.distance_m,
                pixels.row(point.row_px),
                None if point.column_px is None else pixels.column(point.column_px),
            )
            for point in self.points
        )
        changed = replace(
            self,
            camera=camera,
            image_size=pixels.size,
            points=points,
            row_sigma_px=self.row_sigma_px * scale,
            covariance=matrix3(np.array(self.covariance) * scale**2),
            priors=self.priors.through(pixels, self.image_size),
            assumed=self.assumed.through(pixels, self.image_size),
            lens=None if self.lens is None else self.lens.through(pixels),
            undone=None if self.undone is None else self.undone.through(pixels),
        )
        return changed._with_places(pixels.places).with_residuals()

    def with_residuals(self) -> "Calibration":
        """With the residuals of the points as they lie in this picture.

        They change with its size by more than the scale: what straightens a large picture may move a small
        one by less than `fcw.camera.straight.SEEN_PX`, and a size that was rounded has columns scaled
        otherwise than rows.
        """
        rows_px = zip(self.points, self.straight_rows_px, strict=True)
        residuals = tuple(row_px - self.row_at(point.distance_m) for point, row_px in rows_px)
        return replace(self, residuals_px=residuals)

    def _with_places(self, moved: Callable[[Places], Places]) -> "Calibration":
        """With the rectangles and plates where they lie in another picture."""
        if not (self.rectangles or self.plates):
            return self
        return replace(
            self,
            rectangles=tuple(replace(r, corners_px=moved(r.corners_px)) for r in self.rectangles),
            plates=tuple(replace(plate, places_px=moved(plate.places_px)) for plate in self.plates),
        )


def _pairs(places: FloatArray) -> Places:
    return tuple((float(column), float(row)) for column, row in places)


def matrix3(values: NDArray[np.float64]) -> Matrix3:
    """A (3, 3) array as nested tuples of floats."""
    rows = [(float(row[0]), float(row[1]), float(row[2])) for row in values]
    return rows[0], rows[1], rows[2]
