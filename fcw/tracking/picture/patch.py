"""A patch of a picture, small and grey, and where it is in a later one.

Every patch is brought to about the same small size, so that a vehicle costs the same whether it is far away
or fills the picture, and its light is normalised, so that a shadow over all of it changes nothing. Its
corners are followed by pyramidal Lucas-Kanade (Bouguet 2000) forward and back; those that do not come back
are lost (Kalal, Mikolajczyk & Matas 2010, "Forward-backward error: automatic detection of tracking
failures").
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.tracking.picture.growth import Growth, Points, fit_growth

Picture = NDArray[np.uint8]
Region = tuple[int, int, int, int]
"""Left, top, right and bottom in a patch's pixels."""

PATCH_WIDTH, PATCH_HEIGHT = 72, 60
"""Of a patch, in its own pixels."""
BOX_WIDTH, BOX_HEIGHT = 48.0, 40.0
"""A vehicle's box is at most so large in it; the rest is room for the windows of points and for motion."""
FINEST_ZOOM = 1.0
"""Small vehicles are not enlarged: there is nothing more to see."""
POINT_COUNT = 28
POINT_APART_PX = 4.0
CORNER_QUALITY = 0.02
"""A corner is at least this strong, as a part of the strongest."""
INSET = 0.04
"""Points are so far inside the box, as a part of its width and height: its edge may be background."""
FINE_ZOOM = 2.5
"""Beyond it a pixel is the mean of four samples: bilinear ones alone would leave out parts of the picture."""
WINDOW_PX = 9
NARROWEST_PX = 5
"""A part of a patch that is narrower is not compared."""
SEARCH_PX = 16
"""A patch is searched so far around where it was expected."""
LEAST_MATCH = 0.7
"""Correlation from which it counts as found there."""
LEVELS = 2
RETURN_PX = 0.7
"""A point that does not come back this near, followed forward and back, is lost."""
AGREE_PX = 1.2
"""A point off the common motion by more is background, a reflection or an error."""
CRITERIA = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 0.03)
MIDDLE_GREY, CONTRAST = 128.0, 48.0
"""Mean and standard deviation of a normalised patch."""
LEAST_CONTRAST = 2.0
"""A patch with a smaller standard deviation has no looks: night, glare, the sky."""


class Pose(NamedTuple):
    """Where a patch lies in a picture: its pixel (u, v) is the picture's (x + zoom u, y + zoom v)."""

    x: float
    y: float
    zoom: float

    def moved(self, before: Box, after: Box) -> "Pose":
        """Carried along by a box, by its bottom middle and its width."""
        growth = after.w / before.w
        return Pose(
            after.center_x + (self.x - before.center_x) * growth,
            after.bottom + (self.y - before.bottom) * growth,
            self.zoom * growth,
        )

    def carried(self, box: Box, to: "Pose") -> Box:
        """A box that lay in the picture as this pose does, where the other one is."""
        growth = to.zoom / self.zoom
        return Box(
            to.x + (box.x - self.x) * growth, to.y + (box.y - self.y) * growth, box.w * growth, box.h * growth
        )


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """What is remembered of a vehicle's looks.

    Attributes:
        grey: (PATCH_HEIGHT, PATCH_WIDTH) normalised.
        pose: where it was taken.
        inside: its part that shows the vehicle.
        points: (N, 1, 2) float32, corners in it, at least one; of a small vehicle there may be too few to
            tell its growth.
    """

    grey: Picture
    pose: Pose
    inside: Region
    points: NDArray[np.float32]


def take_patch(image: Picture, box: Box) -> Patch | None:
    """The looks of what is in the box; None where there is too little to see.

    Args:
        image: (height, width, 3) BGR.
        box: may go beyond the picture; what of it is inside fills the patch.
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
        pose: where it is now.
        growth: against the pose where it was expected, in the patch's pixels.
        share: part of the points still in the picture that agree on it.
    """

    pose: Pose
    growth: Growth
    share: float


def find_patch(image: Picture, patch: Patch, expected: Pose) -> Found | None:
    """Where a patch is in a later picture, near where it is expected; None where it is not seen.

    Args:
        image: (height, width, 3) BGR.
        patch: its looks.
        expected: about where; it may be off by a quarter of the patch.
    """
    height, width = image.shape[:2]
    grey = _sample(image, expected, patch.inside)
    if grey is None:
        return None
    there, seen = _flow(patch.grey, grey, patch.points)
    back, returned = _flow(grey, patch.grey, there)
    before, after = _complex(patch.points), _complex(there)
    margin_px = WINDOW_PX / 4
    in_picture = (
        (after.real > margin_px - expected.x / expected.zoom)
        & (after.real < (width - 1 - expected.x) / expected.zoom - margin_px)
        & (after.imag > margin_px - expected.y / expected.zoom)
        & (after.imag < (height - 1 - expected.y) / expected.zoom - margin_px)
    )
    returns = np.abs(_complex(back) - before) <= RETURN_PX
    good = in_picture & returns & seen & returned
    growth = fit_growth(before[good], after[good], AGREE_PX)
    if growth is None:
        return None
    pose = Pose(
        expected.x + expected.zoom * growth.shift.real,
        expected.y + expected.zoom * growth.shift.imag,
        expected.zoom * growth.scale,
    )
    return Found(pose, growth, growth.agree / max(int(in_picture.sum()), 1))


def search_patch(image: Picture, patch: Patch, expected: Pose) -> Pose | None:
    """Where a patch has jumped to, as large as expected; None where nothing there looks like it.

    A bump moves all that is in the picture by more than corners can be followed.
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
    """Normalised correlation of a patch with the picture at a pose, over what is in the picture: -1 to 1.

    None where too little of it is in the picture to tell.
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
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Where points of one patch are in the other, (N, 1, 2), and which of them are found."""
    moved, status, _ = cv2.calcOpticalFlowPyrLK(
        before,
        after,
        points,
        np.empty_like(points),
        winSize=(WINDOW_PX, WINDOW_PX),
        maxLevel=LEVELS,
        criteria=CRITERIA,
    )
    return np.asarray(moved, np.float32), np.asarray(status, bool)[:, 0]


def _complex(points: NDArray[np.float32]) -> Points:
    """(N, 1, 2) as (N,) numbers x + iy."""
    return points.astype(np.float64).view(np.complex128)[:, 0, 0]


def _in_picture(image: Picture, box: Box) -> Box:
    """What of a box is in the picture, its outermost parts aside."""
    height, width = image.shape[:2]
    inset_x, inset_y = INSET * box.w, INSET * box.h
    left, top = max(box.x + inset_x, 0.0), max(box.y + inset_y, 0.0)
    right, bottom = min(box.right - inset_x, width - 1.0), min(box.bottom - inset_y, height - 1.0)
    return Box(left, top, right - left, bottom - top)


def _inside(seen: Box, pose: Pose) -> Region:
    """The part of a patch that shows a box; nothing where that has no width or height."""
    return (
        max(int(np.ceil((seen.x - pose.x) / pose.zoom)), 0),
        max(int(np.ceil((seen.y - pose.y) / pose.zoom)), 0),
        min(int((seen.right - pose.x) / pose.zoom) + 1, PATCH_WIDTH),
        min(int((seen.bottom - pose.y) / pose.zoom) + 1, PATCH_HEIGHT),
    )


def _sample(
    image: Picture, pose: Pose, inside: Region, size: tuple[int, int] = (PATCH_WIDTH, PATCH_HEIGHT)
) -> Picture | None:
    """The picture at a pose, grey, with mean and contrast of its inside normalised; None without contrast."""
    width, height = size
    fine = 2 if pose.zoom > FINE_ZOOM else 1
    step, offset = pose.zoom / fine, (pose.zoom / 4 if fine == 2 else 0.0)
    grey = cv2.cvtColor(
        cv2.warpAffine(
            image,
            np.array([[step, 0.0, pose.x - offset], [0.0, step, pose.y - offset]]),
            (width * fine, height * fine),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        ),
        cv2.COLOR_BGR2GRAY,
    )
    if fine == 2:
        grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    left, top, right, bottom = inside
    mean, deviation = cv2.meanStdDev(grey[top:bottom, left:right])
    if deviation[0, 0] < LEAST_CONTRAST:
        return None
    gain = CONTRAST / float(deviation[0, 0])
    grey = cv2.addWeighted(grey, gain, grey, 0.0, MIDDLE_GREY - gain * float(mean[0, 0]))
    return np.asarray(grey, np.uint8)
