"""Which parts of a picture the glance sees, and at which resolution: all of it, and bands along the horizon.

A vehicle that looks small is far away, and so near the horizon (section 3.2 of the paper): a rear of S metres
that appears s px large has its bottom edge s h / S rows below the horizon. So the finer a band, the fewer
rows it needs, and the first two bands cost about the same. A third one, for wide lenses, only covers what may
be in our way.
"""

import math
from dataclasses import dataclass

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.net.windows import level_sizes
from fcw.errors import UserError
from fcw.frame import ImageSize

SHOWN = ImageSize(224, 128)
"""Size at which the net sees a whole picture of aspect ratio 7:4. Others keep about their aspect ratio and as
many pixels."""
SIDES_PX = 32
"""Sides of the net's input are multiples of this, as the net halves them five times."""
FINER = {2: 77.0, 4: 40.0, 8: 32.0}
"""Resolution of each band relative to the whole picture's, and sqrt(w h), in the band's pixels, of the
largest vehicles that the band is for. At half that resolution the net finds them as well, if less surely."""
USUAL_FINER = 2, 4
"""The bands that are always used."""
FAR_M, LEAST_SHOWN_PX = 60.0, 16.0
"""The third band is used if a small car at `FAR_M` may have fewer px than this in the second one, where the
glance hardly finds it. That is the case through a lens of more than 66 degrees, or one that may well be as
wide. Unknown lenses are often far wider than assumed."""
LEAST_FOCAL_PART = 0.5
"""Lower bound of a poorly known focal length, as a fraction of it: a lens with a stated field of view of 66
degrees then counts as one of 105."""
ASIDE_M = 20.0
"""Half width of the third band, in metres at `FAR_M` to either side of straight ahead, for the widest lens
that is allowed for. It covers our path in any bend with a radius of 90 m or more."""
SIZES_M = 1.4, 3.2
"""sqrt(w h) of a small car and of a lorry."""
TALLEST = 1.15
"""Height of a lorry over its sqrt(w h)."""
NEAREST_M, FARTHEST_M = 3.0, 80.0
"""A part of the road between these distances from the camera must be in the picture."""


@dataclass(frozen=True, slots=True)
class Band:
    """A part of a picture, and how it is shown to the net.

    Attributes:
        level: how many times the picture is halved before the part is cut out and reduced to its final size.
        first_column: the part's first column in that level.
        end_column: one past its last column.
        first_row: its first row in that level.
        end_row: one past its last row.
        shown: size at which the net sees the part.
        picture: size of the whole picture.
    """

    level: int
    first_column: int
    end_column: int
    first_row: int
    end_row: int
    shown: ImageSize
    picture: ImageSize

    @property
    def scale(self) -> tuple[float, float]:
        """Pixels of the picture per pixel shown, across and down."""
        columns, rows = self.end_column - self.first_column, self.end_row - self.first_row
        return (
            columns * self.picture.width / self._cut_from.width / self.shown.width,
            rows * self.picture.height / self._cut_from.height / self.shown.height,
        )

    @property
    def corner_px(self) -> tuple[float, float]:
        """Distance of the part's corner from the picture's left and upper edge, in pixels of the picture."""
        return (
            self.first_column * self.picture.width / self._cut_from.width,
            self.first_row * self.picture.height / self._cut_from.height,
        )

    @property
    def is_cut(self) -> tuple[tuple[bool, bool], tuple[bool, bool]]:
        """Whether the picture continues to the left and above, and to the right and below."""
        return (
            (self.first_column > 0, self.first_row > 0),
            (self.end_column < self._cut_from.width, self.end_row < self._cut_from.height),
        )

    @property
    def _cut_from(self) -> ImageSize:
        return level_sizes(self.picture)[self.level]


def whole(size: ImageSize) -> Band:
    """All of a picture."""
    scale = math.sqrt(SHOWN.width * SHOWN.height / (size.width * size.height))
    width, height = (max(2, round(side * scale / SIDES_PX)) * SIDES_PX for side in (size.width, size.height))
    shown = ImageSize(width, height)
    level = _level_for(size, shown)
    cut_from = level_sizes(size)[level]
    return Band(level, 0, cut_from.width, 0, cut_from.height, shown, size)


def bands_of(
    size: ImageSize,
    camera: GroundPlaneCamera,
    tolerance_rad: float,
    largest_scale: float,
    focal_sigma_px: float = 0.0,
) -> tuple[Band, ...]:
    """The whole picture, and bands for the vehicles that it shows too small.

    Args:
        size: size of the pictures.
        camera: the camera.
        tolerance_rad: largest error of its pitch, up or down.
        largest_scale: bands that would enlarge the picture by more than this are left out.
        focal_sigma_px: standard deviation of the camera's focal length.

    Raises:
        UserError: the calibration puts the road outside the picture.
    """
    spare_px = _spare_px(camera, tolerance_rad)
    if camera.row_at(NEAREST_M) + spare_px < 0 or camera.row_at(FARTHEST_M) - spare_px >= size.height:
        raise UserError(
            f"the calibration has its horizon in row {camera.horizon_row_px:.0f} of pictures of {size}: no "
            f"vehicle {NEAREST_M:g} to {FARTHEST_M:g} m away can be in them; calibrate again with points on "
            "the road ahead"
        )
    everything = whole(size)
    least_focal_px = max(LEAST_FOCAL_PART * camera.focal_y_px, camera.focal_y_px - focal_sigma_px)
    small_px = SIZES_M[0] * least_focal_px / FAR_M * max(USUAL_FINER) / everything.scale[0]
    wanted = USUAL_FINER if small_px >= LEAST_SHOWN_PX else FINER
    finer = (finer for finer in wanted if finer / everything.scale[1] <= largest_scale)
    aside_px = least_focal_px * ASIDE_M / FAR_M
    return everything, *(_band(everything, camera, tolerance_rad, each, aside_px) for each in finer)


def _band(
    everything: Band, camera: GroundPlaneCamera, tolerance_rad: float, finer: int, aside_px: float
) -> Band:
    size = everything.picture
    across, down = (each / finer for each in everything.scale)
    largest_px = FINER[finer] * down
    small_m, large_m = SIZES_M
    spare_px = _spare_px(camera, tolerance_rad)
    top = camera.horizon_row_px + largest_px * min(camera.height_m / large_m - TALLEST, 0.0) - spare_px
    bottom = camera.horizon_row_px + largest_px * camera.height_m / small_m + spare_px
    left, right = 0.0, size.width - 1.0
    if finer not in USUAL_FINER:
        left, right = camera.principal_column_px - aside_px, camera.principal_column_px + aside_px
    all_shown = ImageSize(finer * everything.shown.width, finer * everything.shown.height)
    level = _level_for(size, all_shown)
    cut_from = level_sizes(size)[level]
    first_column, end_column, width = _cut(left, right, across, all_shown.width, size.width, cut_from.width)
    first_row, end_row, height = _cut(top, bottom, down, all_shown.height, size.height, cut_from.height)
    return Band(level, first_column, end_column, first_row, end_row, ImageSize(width, height), size)


def _cut(
    first_px: float, last_px: float, step_px: float, all_shown: int, side: int, level_side: int
) -> tuple[int, int, int]:
    """The first row or column of a level, one past the last, and the number that are shown.

    Args:
        first_px: first row or column of the picture that is needed.
        last_px: last one that is needed.
        step_px: pixels of the picture per pixel shown.
        all_shown: number that would be shown of the whole picture.
        side: number of rows or columns in the picture.
        level_side: number in the level.
    """
    shown = min(math.ceil((last_px - first_px) / step_px / SIDES_PX) * SIDES_PX, all_shown)
    part = level_side / side
    count = min(round(shown * step_px * part), level_side)
    first = round(((first_px + last_px) / 2 + 0.5) * part - count / 2)
    first = min(max(first, 0), level_side - count)
    return first, first + count, shown


def _spare_px(camera: GroundPlaneCamera, tolerance_rad: float) -> float:
    """Largest error of the horizon, in rows."""
    return camera.focal_y_px * math.tan(tolerance_rad)


def _level_for(size: ImageSize, shown: ImageSize) -> int:
    """The smallest level that is at least as large as what is shown; 0 if none is."""
    enough = [
        number
        for number, level in enumerate(level_sizes(size))
        if level.width >= shown.width and level.height >= shown.height
    ]
    return enough[-1] if enough else 0
