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
"""Support distances if there are no points: well apart in rows, and in front of any camera."""
ASPECT_TOLERANCE_PX = 1.0
"""Tolerance for equal aspect ratios, as image sizes are rounded to whole pixels: 480 rows of 16:9 are 853.33
columns wide."""


@dataclass(frozen=True, slots=True)
class GroundPoint:
    """A clicked point on the road.

    Attributes:
        distance_m: distance along the ground from the calibration's reference point.
        row_px: its row in the picture.
        column_px: its column in the picture; None when unknown.
    """

    distance_m: float
    row_px: float
    column_px: float | None = None

    def __str__(self) -> str:
        column = "" if self.column_px is None else f":{self.column_px:g}"
        return f"{self.distance_m:g}:{self.row_px:g}{column}"


@dataclass(frozen=True, slots=True)
class Gaussian:
    """A value and its standard deviation."""

    value: float
    sigma: float


@dataclass(frozen=True, slots=True)
class GroundRectangle:
    """A clicked rectangle on the road: a parking bay, or a field of a pedestrian crossing.

    Attributes:
        corners_px: columns and rows of its four corners, in order around it, in either direction.
        first_side_m: length from the first corner to the second; None when unknown.
        second_side_m: length from the second corner to the third; None when unknown.
        along: whether its sides are parallel and perpendicular to the direction of travel.
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
        """Whether a side is known, so that the rectangle determines the scale."""
        return self.sides_m != (None, None)

    @property
    def swapped(self) -> "GroundRectangle":
        """The same corners with the two lengths exchanged."""
        return replace(self, first_side_m=self.second_side_m, second_side_m=self.first_side_m)


@dataclass(frozen=True, slots=True)
class NumberPlate:
    """A clicked number plate of a vehicle seen from behind.

    Attributes:
        places_px: columns and rows of its two ends, and of the point where a rear tyre meets the road.
        width_m: width of the plate.
    """

    places_px: Places
    width_m: Gaussian


@dataclass(frozen=True, slots=True)
class Priors:
    """Prior knowledge used in a calibration; None for what was not given.

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
        """Number of priors that are given."""
        return sum(
            prior is not None
            for prior in (self.field_of_view_rad, self.principal_row_px, self.horizon_row_px)
        )

    def through(self, pixels: PixelMap, size: ImageSize) -> "Priors":
        """The priors for pictures that a map leads to. A part of a picture has another field of view."""
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

    All distances are from the reference point (the front bumper, say), which is `reference_offset_m` ahead of
    the camera, except those of `camera` itself, which are from the camera.

    Attributes:
        camera: the solution.
        image_size: size of the pictures that it is for.
        points: the clicked points.
        row_sigma_px: standard deviation of a clicked row.
        support_distances_m: three distances from the reference point, ascending.
        covariance: (3, 3) covariance of the rows at the support distances, in pixels squared.
        reference_offset_m: distance from the camera forward to the reference point, at least 0.
        priors: prior knowledge that the user gave.
        residuals_px: clicked row minus row of the solution, for each point. Three points without priors are
            met exactly, so that their zeros tell nothing about the quality.
        assumed: prior knowledge about any lens, used if nothing was given; none in the exact solution of
            three points.
        tape_error: common relative standard deviation of the points' distances, included in the covariance.
        orientation: yaw and roll of the real camera. `camera`, and everything measured with it, belongs to
            the straightened picture (`fcw.camera.straight`); the points belong to the picture itself.
        lens: the real camera's lens, if its distortion is known.
        rectangles: clicked rectangles.
        plates: clicked number plates.
        undone: for a calibration of straightened pictures, the orientation and lens that were removed; None
            if no pictures were straightened for it.
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
        """The map to the straightened picture; None if the picture is straight as it is."""
        way = Straightening(self.camera, self.orientation, self.lens, self.image_size)
        return None if way.is_identity else way

    def straight_place(self, column_px: float, row_px: float) -> tuple[float, float]:
        """Column and row in the straightened picture of a point in the picture."""
        way = self.straightening
        if way is None:
            return column_px, row_px
        column, row = way.to_straight(np.array([[column_px, row_px]]))[0]
        return float(column), float(row)

    @property
    def straight_rows_px(self) -> tuple[float, ...]:
        """Rows of the points in the straightened picture; one without a column is taken straight ahead."""
        way = self.straightening
        if way is None or not self.points:
            return tuple(point.row_px for point in self.points)
        ahead_px = self.camera.principal_column_px
        places = [(ahead_px if p.column_px is None else p.column_px, p.row_px) for p in self.points]
        return tuple(way.to_straight(np.array(places))[:, 1].tolist())

    def straight(self) -> "Calibration":
        """The calibration of the straightened picture."""
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
        """16th and 84th percentile of the distance at a row (see `fcw.camera.interval`).

        Args:
            row_px: the row.
            row_sigma_px: standard deviation of the row's own noise, independent of the calibration's.

        Returns:
            (low, high) from the reference point; inf if unbounded. `low` is negative only if the distance at
            the row is.
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
        """This calibration for the pictures of the same camera after a map (scaled or cropped, say)."""
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
        """This calibration with its residuals computed anew for its picture size.

        They do not simply scale with the size. What straightens a large picture may move a small one by less
        than `fcw.camera.straight.SEEN_PX`, and if a size was rounded, columns and rows have different scales.
        """
        rows_px = zip(self.points, self.straight_rows_px, strict=True)
        residuals = tuple(row_px - self.row_at(point.distance_m) for point, row_px in rows_px)
        return replace(self, residuals_px=residuals)

    def _with_places(self, moved: Callable[[Places], Places]) -> "Calibration":
        """This calibration with its rectangles and plates moved to another picture."""
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
