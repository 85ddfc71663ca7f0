"""A small grey patch of a picture, and how to find it in a later picture.

Every patch is scaled to about the same small size, so that a vehicle costs the same whether it is far away or
fills the picture. Its brightness is normalised, so that a shadow over all of it changes nothing. Its corners
are tracked by pyramidal Lucas-Kanade (Bouguet 2000) forward and back, and those that do not come back are
dropped (Kalal, Mikolajczyk & Matas 2010, "Forward-backward error: automatic detection of tracking failures").
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel, rows_of_bytes
from fcw.tracking.picture.growth import Growth, fit_growth

Picture = NDArray[np.uint8]
_1, _2 = np.uint64(1), np.uint64(2)
"""Unsigned, because numba checks signed indices for being negative."""
Region = tuple[int, int, int, int]
"""Left, top, right and bottom in a patch's pixels."""

PATCH_WIDTH, PATCH_HEIGHT = 72, 60
"""Size of a patch in its own pixels."""
BOX_WIDTH, BOX_HEIGHT = 48.0, 40.0
"""Largest size of a vehicle's box in a patch. The margin leaves room for the points' windows and for
motion."""
FINEST_ZOOM = 1.0
"""Small vehicles are not enlarged, which would show nothing more."""
POINT_COUNT = 28
POINT_APART_PX = 4.0
CORNER_QUALITY = 0.02
"""Least strength of a corner, as a fraction of the strongest."""
INSET = 0.04
"""Points keep this distance from the edges of the box, as a fraction of its size, as the edges may be
background."""
FINE_ZOOM = 2.5
"""Beyond this zoom a pixel is the mean of four samples; single bilinear samples would skip parts of the
picture."""
WINDOW_PX = 9
"""Side of the window around each point in Lucas-Kanade."""
NARROWEST_PX = 5
"""Parts of a patch that are narrower than this are not compared."""
SEARCH_PX = 16
"""How far around its expected place a patch is searched, in its own pixels."""
LEAST_MATCH = 0.7
"""Correlation from which a searched patch counts as found."""
LEVELS = 2
"""Highest pyramid level of Lucas-Kanade."""
RETURN_PX = 0.7
"""A point that is tracked forward and back must return this near to where it began."""
AGREE_PX = 1.2
"""A point that deviates from the common motion by more than this is background, a reflection or an error."""
CRITERIA = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 0.03)
MIDDLE_GREY, CONTRAST = 128.0, 48.0
"""Mean and standard deviation of a normalised patch."""
LEAST_CONTRAST = 2.0
"""A patch with a smaller standard deviation shows nothing: night, glare, the sky."""


class Pose(NamedTuple):
    """Where a patch lies in a picture: its pixel (u, v) is the picture's (x + zoom u, y + zoom v)."""

    x: float
    y: float
    zoom: float

    def moved(self, before: Box, after: Box) -> "Pose":
        """The pose moved and scaled with a box, by its bottom middle and its width."""
        growth = after.w / before.w
        return Pose(
            after.center_x + (self.x - before.center_x) * growth,
            after.bottom + (self.y - before.bottom) * growth,
            self.zoom * growth,
        )

    def carried(self, box: Box, to: "Pose") -> Box:
        """The box that is placed relative to the other pose as `box` is to this one."""
        growth = to.zoom / self.zoom
        return Box(
            to.x + (box.x - self.x) * growth, to.y + (box.y - self.y) * growth, box.w * growth, box.h * growth
        )


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A stored patch of a vehicle.

    Attributes:
        grey: (PATCH_HEIGHT, PATCH_WIDTH) normalised.
        pose: where it was taken.
        inside: the part of it that shows the vehicle.
        points: (N, 1, 2) float32, its corners, at least one. A small vehicle may have too few to measure
            growth.
    """

    grey: Picture
    pose: Pose
    inside: Region
    points: NDArray[np.float32]


def take_patch(image: Picture, box: Box) -> Patch | None:
    """Take a patch of what is in a box; None if there is too little to see.

    Args:
        image: (height, width, 3) BGR.
        box: the box; only its part inside the picture is used.
    """
    seen = _in_picture(image, box)
    zoom = max(seen.w / BOX_WIDTH, seen.h / BOX_HEIGHT, FINEST_ZOOM)
    pose = Pose(
        seen.center_x - zoom * (PATCH_WIDTH - 1) / 2,
        seen.y + seen.h / 2 - zoom * (PATCH_HEIGHT - 1) / 2,
        zoom,
    )
    inside = _inside(seen, pose)
    left, top, right, bottom = inside
    if right - left < WINDOW_PX or bottom - top < WINDOW_PX:
        return None
    grey = _sample(image, pose, inside)
    if grey is None:
        return None
    points = cv2.goodFeaturesToTrack(
        grey[top:bottom, left:right], POINT_COUNT, CORNER_QUALITY, POINT_APART_PX
    )
    if points is None:
        return None
    found = np.asarray(points, np.float32).reshape(-1, 1, 2) + np.array((left, top), np.float32)
    return Patch(grey, pose, inside, found)


class Found(NamedTuple):
    """A patch found again.

    Attributes:
        pose: its new pose.
        growth: shift and growth relative to the expected pose, in the patch's pixels.
        share: fraction of the points still in the picture that agree on `growth`.
    """

    pose: Pose
    growth: Growth
    share: float


def find_patch(image: Picture, patch: Patch, expected: Pose) -> Found | None:
    """Find a patch in a later picture near its expected pose, by its corners; None if it is not seen.

    Args:
        image: (height, width, 3) BGR.
        patch: the patch.
        expected: its expected pose; may be off by a quarter of the patch.
    """
    height, width = image.shape[:2]
    grey = _sample(image, expected, patch.inside)
    if grey is None:
        return None
    there, seen = _flow(patch.grey, grey, patch.points)
    back, returned = _flow(grey, patch.grey, there)
    margin_px = WINDOW_PX / 4
    bounds = (
        margin_px - expected.x / expected.zoom,
        (width - 1 - expected.x) / expected.zoom - margin_px,
        margin_px - expected.y / expected.zoom,
        (height - 1 - expected.y) / expected.zoom - margin_px,
    )
    pairs = np.empty((2, len(patch.points)), np.complex128)
    in_picture, good = _came_back(patch.points, there, back, seen, returned, bounds, pairs)
    growth = fit_growth(pairs[0, :good], pairs[1, :good], AGREE_PX)
    if growth is None:
        return None
    pose = Pose(
        expected.x + expected.zoom * growth.shift.real,
        expected.y + expected.zoom * growth.shift.imag,
        expected.zoom * growth.scale,
    )
    return Found(pose, growth, growth.agree / max(in_picture, 1))


def search_patch(image: Picture, patch: Patch, expected: Pose) -> Pose | None:
    """Find a patch of the expected size by correlation in a larger area; None if nothing there looks like it.

    This is for bumps, which shift the whole picture by more than corners can be tracked.
    """
    left, top, right, bottom = patch.inside
    room, zoom = SEARCH_PX, expected.zoom
    corner = Pose(expected.x + zoom * (left - room), expected.y + zoom * (top - room), zoom)
    width, height = right - left, bottom - top
    around = _sample(
        image, corner, (room, room, room + width, room + height), (width + 2 * room, height + 2 * room)
    )
    if around is None:
        return None
    alike = cv2.matchTemplate(around, patch.grey[top:bottom, left:right], cv2.TM_CCOEFF_NORMED)
    _, best, _, (column, row) = cv2.minMaxLoc(alike)
    if best < LEAST_MATCH:
        return None
    return Pose(expected.x + zoom * (column - room), expected.y + zoom * (row - room), zoom)


def likeness(image: Picture, patch: Patch, pose: Pose) -> float | None:
    """Normalised correlation, -1 to 1, of a patch with the picture at a pose, as far as it is in the picture.

    None if too little of it is in the picture.
    """
    height, width = image.shape[:2]
    left, top, right, bottom = patch.inside
    left = max(left, int(-pose.x / pose.zoom) + 1)
    top = max(top, int(-pose.y / pose.zoom) + 1)
    right = min(right, int((width - 1 - pose.x) / pose.zoom))
    bottom = min(bottom, int((height - 1 - pose.y) / pose.zoom))
    if right - left < NARROWEST_PX or bottom - top < NARROWEST_PX:
        return None
    grey = _sample(image, pose, (left, top, right, bottom))
    if grey is None:
        return 0.0
    place = slice(top, bottom), slice(left, right)
    return float(cv2.matchTemplate(grey[place], patch.grey[place], cv2.TM_CCOEFF_NORMED)[0, 0])


def _flow(
    before: Picture, after: Picture, points: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Positions of one patch's points in another, (N, 1, 2), and which of them were found."""
    moved, status, _ = cv2.calcOpticalFlowPyrLK(
        before,
        after,
        points,
        np.empty_like(points),
        winSize=(WINDOW_PX, WINDOW_PX),
        maxLevel=LEVELS,
        criteria=CRITERIA,
    )
    return np.asarray(moved, np.float32), np.asarray(status, np.uint8)


@kernel()
def _came_back(
    points: NDArray[np.float32],
    there: NDArray[np.float32],
    back: NDArray[np.float32],
    seen: NDArray[np.uint8],
    returned: NDArray[np.uint8],
    bounds: tuple[float, float, float, float],
    pairs: NDArray[np.complex128],
) -> tuple[int, int]:
    """Write the points that were tracked there and back into the rows of `pairs`: before, after.

    Points are (N, 1, 2) each.

    Returns:
        How many points are inside the bounds (left, right, top, bottom), and how many of them came back.
    """
    left, right, top, bottom = bounds
    inside = good = 0
    for i in range(len(points)):
        x, y = np.float64(there[i, 0, 0]), np.float64(there[i, 0, 1])
        if not (left < x < right and top < y < bottom):
            continue
        inside += 1
        off = math.hypot(back[i, 0, 0] - points[i, 0, 0], back[i, 0, 1] - points[i, 0, 1])
        if seen[i, 0] and returned[i, 0] and off <= RETURN_PX:
            pairs[0, good] = points[i, 0, 0] + 1j * points[i, 0, 1]
            pairs[1, good] = x + 1j * y
            good += 1
    return inside, good


def _in_picture(image: Picture, box: Box) -> Box:
    """The part of a box that is in the picture, without a margin of `INSET`."""
    height, width = image.shape[:2]
    inset_x, inset_y = INSET * box.w, INSET * box.h
    left, top = max(box.x + inset_x, 0.0), max(box.y + inset_y, 0.0)
    right, bottom = min(box.right - inset_x, width - 1.0), min(box.bottom - inset_y, height - 1.0)
    return Box(left, top, right - left, bottom - top)


def _inside(seen: Box, pose: Pose) -> Region:
    """The part of a patch that shows a box; empty if that has no width or height."""
    return (
        max(int(np.ceil((seen.x - pose.x) / pose.zoom)), 0),
        max(int(np.ceil((seen.y - pose.y) / pose.zoom)), 0),
        min(int((seen.right - pose.x) / pose.zoom) + 1, PATCH_WIDTH),
        min(int((seen.bottom - pose.y) / pose.zoom) + 1, PATCH_HEIGHT),
    )


def _sample(
    image: Picture, pose: Pose, inside: Region, size: tuple[int, int] = (PATCH_WIDTH, PATCH_HEIGHT)
) -> Picture | None:
    """The picture at a pose in grey, normalised by mean and contrast of `inside`; None without contrast."""
    width, height = size
    grey = np.empty((height, width), np.uint8)
    return (
        grey
        if _sampled(rows_of_bytes(image), pose, inside, np.empty((height, width), np.float32), grey)
        else None
    )


@kernel()
def _sampled(image: Picture, pose: Pose, inside: Region, values: NDArray[np.float32], grey: Picture) -> bool:
    """Fill a patch from a (height, 3 * width) BGR picture; returns False if its inside has no contrast.

    Beyond the picture, its edge pixels are repeated.
    """
    last_row, last_column = image.shape[0] - 1.0, image.shape[1] / 3 - 1.0
    height, width = grey.shape
    samples = 2 if pose.zoom > FINE_ZOOM else 1
    # For each column, the two elements of a row that are interpolated, and the weight of the right one.
    lefts, besides = np.empty(width * samples, np.uint64), np.empty(width * samples, np.uint64)
    rights = np.empty(width * samples, np.float32)
    for i in range(width * samples):
        x = pose.x + pose.zoom * (i if samples == 1 else i / 2 - 0.25)
        x = min(max(x, 0.0), last_column)
        lefts[i], rights[i] = 3 * int(x), x - int(x)
        besides[i] = 3 * int(min(int(x) + 1.0, last_column))
    values[:] = np.float32(0)
    for sample in range(height * samples):
        y = pose.y + pose.zoom * (sample if samples == 1 else sample / 2 - 0.25)
        y = min(max(y, 0.0), last_row)
        above, below, down = np.uint64(y), np.uint64(min(int(y) + 1.0, last_row)), np.float32(y - int(y))
        row = sample // samples
        for i in range(width * samples):
            left, beside, right = lefts[i], besides[i], rights[i]
            here, there = _grey(image, above, left), _grey(image, above, beside)
            here_below, there_below = _grey(image, below, left), _grey(image, below, beside)
            upper, lower = here + right * (there - here), here_below + right * (there_below - here_below)
            values[row, i // samples] += upper + down * (lower - upper)
    left, top, right, bottom = inside
    total = squares = 0.0
    for row in range(top, bottom):
        for column in range(left, right):
            value = np.float64(values[row, column])
            total += value
            squares += value * value
    count, each = (right - left) * (bottom - top), samples * samples
    mean = total / count
    deviation = math.sqrt(max(squares / count - mean * mean, 0.0))
    if deviation < LEAST_CONTRAST * each:
        return False
    gain = CONTRAST / deviation
    for row in range(height):
        for column in range(width):
            value = MIDDLE_GREY + gain * (values[row, column] - mean)
            grey[row, column] = np.uint8(min(max(value, 0.0), 255.0) + 0.5)
    return True


@inner_kernel()
def _grey(image: Picture, row: np.uint64, first: np.uint64) -> np.float32:
    """Luma of a pixel by ITU-R BT.601; `first` is the index of its blue value."""
    blue, green, red = image[row, first], image[row, first + _1], image[row, first + _2]
    return np.float32(0.114) * blue + np.float32(0.587) * green + np.float32(0.299) * red
