"""Which parts of a picture a glance is shown, and how finely: all of it, and bands along the horizon.

What looks small is far away, and so stands near the horizon (section 3.2 of the paper): a rear of S metres
that looks s px large has its bottom edge s h / S rows below it. So the finer a band shows the picture, the
fewer of its rows it needs, and all bands cost about the same.
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
FAR_M, LEAST_SHOWN_PX = 61.0, 16.0
"""The third band is there where the second one shows a small car so far away with fewer px, which the glance
hardly finds: through a lens of 66 degrees, as is taken for one that nobody knows, or a wider one."""
SIZES_M = 1.4, 3.2
"""sqrt(w h) of a small car and of a lorry."""
TALLEST = 1.15
"""Height of a lorry, in sizes."""
NEAREST_M, FARTHEST_M = 3.0, 80.0
"""Distances from the camera of which some must be in the picture."""


@dataclass(frozen=True, slots=True)
class Band:
    """Rows of a picture, in all their width.

    Attributes:
        level: how many times the picture is halved before its rows are cut and made smaller still.
        first_row: the first of that level's rows.
        end_row: one past the last.
        shown: as how large they are shown.
        picture: size of the whole picture.
    """

    level: int
    first_row: int
    end_row: int
    shown: ImageSize
    picture: ImageSize

    @property
    def scale(self) -> tuple[float, float]:
        """Px of the picture for one that is shown, across and down."""
        rows = level_sizes(self.picture)[self.level].height
        down = (self.end_row - self.first_row) * self.picture.height / rows / self.shown.height
        return self.picture.width / self.shown.width, down

    @property
    def top_px(self) -> float:
        """How far the first row's upper edge is below the picture's."""
        return self.first_row * self.picture.height / level_sizes(self.picture)[self.level].height

    @property
    def is_cut(self) -> tuple[bool, bool]:
        """Whether the picture goes on above, and below."""
        return self.first_row > 0, self.end_row < level_sizes(self.picture)[self.level].height


def whole(size: ImageSize) -> Band:
    """All of a picture."""
    scale = math.sqrt(SHOWN.width * SHOWN.height / (size.width * size.height))
    width, height = (max(2, round(side * scale / SIDES_PX)) * SIDES_PX for side in (size.width, size.height))
    shown = ImageSize(width, height)
    level = _level_for(size, shown)
    return Band(level, 0, level_sizes(size)[level].height, shown, size)


def bands_of(
    size: ImageSize, camera: GroundPlaneCamera, tolerance_rad: float, largest_scale: float
) -> tuple[Band, ...]:
    """The whole picture, and the bands in which vehicles are that it shows too small.

    Args:
        size: of the pictures.
        camera: that takes them.
        tolerance_rad: by how much its pitch may be off, up and down.
        largest_scale: bands that would enlarge the picture more are left out.

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
    small_px = SIZES_M[0] * camera.focal_y_px / FAR_M * max(USUAL_FINER) / everything.scale[0]
    wanted = USUAL_FINER if small_px >= LEAST_SHOWN_PX else FINER
    finer = (finer for finer in wanted if finer / everything.scale[1] <= largest_scale)
    return everything, *(_band(everything, camera, tolerance_rad, each) for each in finer)


def _band(everything: Band, camera: GroundPlaneCamera, tolerance_rad: float, finer: int) -> Band:
    size, down = everything.picture, everything.scale[1] / finer
    largest_px = FINER[finer] * down
    small_m, large_m = SIZES_M
    spare_px = _spare_px(camera, tolerance_rad)
    first = camera.horizon_row_px + largest_px * min(camera.height_m / large_m - TALLEST, 0.0) - spare_px
    last = camera.horizon_row_px + largest_px * camera.height_m / small_m + spare_px
    shown_rows = math.ceil((last - first) / down / SIDES_PX) * SIDES_PX
    shown = ImageSize(finer * everything.shown.width, min(shown_rows, finer * everything.shown.height))
    level = _level_for(size, ImageSize(shown.width, finer * everything.shown.height))
    level_height = level_sizes(size)[level].height
    part = level_height / size.height
    rows = min(round(shown.height * down * part), level_height)
    start = round(((first + last) / 2 + 0.5) * part - rows / 2)
    start = min(max(start, 0), level_height - rows)
    return Band(level, start, start + rows, shown, size)


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
