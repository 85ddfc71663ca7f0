"""Which parts of a picture a glance is shown, and how finely: all of it, and bands along the horizon.

What looks small is far away, and so stands near the horizon (section 3.2 of the paper): a rear of S metres
that looks s px large has its bottom edge s h / S rows below it. So the finer a band shows the picture, the
fewer of its rows it needs, and the first two bands cost about the same. A third one, for wide lenses, shows
no more than may be in our way.
"""

import math
from dataclasses import dataclass

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.net.windows import level_sizes
from fcw.errors import UserError
from fcw.frame import ImageSize

SHOWN = ImageSize(224, 128)
"""How large a picture of 7 to 4 is shown as a whole; others in nearly their shape, with about as many px."""
SIDES_PX = 32
"""A multiple of which shown sides are: the net halves them five times."""
FINER = {2: 77.0, 4: 40.0, 8: 32.0}
"""How many times as finely as the whole picture bands are shown; and sqrt(w h) of the largest vehicles that
they are there for, as they show them. What shows them half as large finds them as well, if less surely."""
USUAL_FINER = 2, 4
"""What every picture is shown by."""
FAR_M, LEAST_SHOWN_PX = 60.0, 16.0
"""The third band is there where the second one may show a small car so far away with fewer px, which the
glance hardly finds: through a lens of more than 66 degrees, or one that may well be as wide. Lenses that
nobody knows are often far wider than they are taken to be."""
LEAST_FOCAL_PART = 0.5
"""A focal length of which hardly anything is known is taken to be at least this part of itself: a lens that
is said to have 66 degrees has 105 then."""
ASIDE_M = 20.0
"""How far aside of straight ahead, as calibrated, it shows what is `FAR_M` away if the lens is as wide as it
may be: our way in any bend whose radius is 90 m or more."""
SIZES_M = 1.4, 3.2
"""sqrt(w h) of a small car and of a lorry."""
TALLEST = 1.15
"""Height of a lorry, in sizes."""
NEAREST_M, FARTHEST_M = 3.0, 80.0
"""Distances from the camera of which some must be in the picture."""


@dataclass(frozen=True, slots=True)
class Band:
    """A part of a picture.

    Attributes:
        level: how many times the picture is halved before the part is cut out and made smaller still.
        first_column: the first of that level's columns.
        end_column: one past the last.
        first_row: the first of its rows.
        end_row: one past the last.
        shown: as how large the part is shown.
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
        """Px of the picture for one that is shown, across and down."""
        columns, rows = self.end_column - self.first_column, self.end_row - self.first_row
        return (
            columns * self.picture.width / self._cut_from.width / self.shown.width,
            rows * self.picture.height / self._cut_from.height / self.shown.height,
        )

    @property
    def corner_px(self) -> tuple[float, float]:
        """How far right of the picture's left edge the part begins, and how far below its upper one."""
        return (
            self.first_column * self.picture.width / self._cut_from.width,
            self.first_row * self.picture.height / self._cut_from.height,
        )

    @property
    def is_cut(self) -> tuple[tuple[bool, bool], tuple[bool, bool]]:
        """Whether the picture goes on to the left and above, and to the right and below."""
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
    """The whole picture, and the bands in which vehicles are that it shows too small.

    Args:
        size: of the pictures.
        camera: that takes them.
        tolerance_rad: by how much its pitch may be off, up and down.
        largest_scale: bands that would enlarge the picture more are left out.
        focal_sigma_px: standard deviation of the camera's focal length.

    Raises:
        UserError: by the calibration the road is not in the picture.
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
    """The first of a level's rows or columns, one past the last, and as how many they are shown.

    Args:
        first_px: of the picture, that is wanted.
        last_px: the last one.
        step_px: px of the picture for one that is shown.
        all_shown: as how many the whole picture would be.
        side: how many the picture has.
        level_side: how many the level has.
    """
    shown = min(math.ceil((last_px - first_px) / step_px / SIDES_PX) * SIDES_PX, all_shown)
    part = level_side / side
    count = min(round(shown * step_px * part), level_side)
    first = round(((first_px + last_px) / 2 + 0.5) * part - count / 2)
    first = min(max(first, 0), level_side - count)
    return first, first + count, shown


def _spare_px(camera: GroundPlaneCamera, tolerance_rad: float) -> float:
    """By how much the horizon may be off."""
    return camera.focal_y_px * math.tan(tolerance_rad)


def _level_for(size: ImageSize, shown: ImageSize) -> int:
    """The last level that is as large as what is shown of it, or larger; 0 where none is."""
    enough = [
        number
        for number, level in enumerate(level_sizes(size))
        if level.width >= shown.width and level.height >= shown.height
    ]
    return enough[-1] if enough else 0
