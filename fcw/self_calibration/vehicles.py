"""The vehicles of a clip as rulers; each counts once, however often it is seen."""

from collections.abc import Callable, Sequence

import numpy as np

from fcw.box import Box
from fcw.camera.calibration import Gaussian
from fcw.camera.joint.evidence import CAR_HEIGHT_M, TALL_WIDTH_M, VEHICLE_WIDTH_M, Ruler
from fcw.detection.boxes.overlap import intersection_over_union
from fcw.detection.detector import Detector
from fcw.frame import ImageSize, Source
from fcw.self_calibration.parts import WHOLE_CLIP_S, pictures_of

DETECTED_EVERY_S = 0.5
RULER_COUNT = 40
AHEAD_PARTS = (0.2, 0.8)
"""Range of a box's middle, as parts of the picture's width; vehicles farther aside show their sides."""
SMALLEST_RULER_PX = 24.0
FLATTEST_REAR = 0.7
"""Height over width of the flattest rears; a flatter box contains the side, or only the side."""
BOTTOM_SIGMA_PART = 0.02
"""Standard deviation of a box's lower edge, as a part of its height."""
SAME_OVERLAP = 0.2
"""Boxes half a second apart with this overlap belong to one vehicle."""
SAME_PLACE_OVERLAP = 0.7
"""Boxes at any time with this overlap count once."""


BONNET_PART = 0.03
"""Boxes that end this near the bottom, as a part of the picture's height, are cut off or the own bonnet."""


class VehicleRulers:
    """Collects the vehicles of a clip as rulers, picture by picture.

    A vehicle that stays in view is one ruler, from the first time that it is seen whole. The same holds for a
    box that comes back at the same place, such as a lead that was missed for a moment, or the own bonnet.

    Args:
        size: size of the pictures.
    """

    def __init__(self, size: ImageSize) -> None:
        self._size = size
        self._before: tuple[Box, ...] = ()
        self._counted: list[Box] = []
        self._rulers: list[Ruler] = []

    def look(self, boxes: Sequence[Box]) -> list[Ruler]:
        """Take the boxes found in a picture, and return the new rulers."""
        new: list[Ruler] = []
        for box in boxes:
            known = _any_overlaps(box, self._before, SAME_OVERLAP)
            known = known or _any_overlaps(box, self._counted, SAME_PLACE_OVERLAP)
            ruler = None if known else ruler_of(box, self._size)
            if ruler is not None:
                self._counted.append(box)
                new.append(ruler)
        self._before = tuple(boxes)
        self._rulers += new
        return new

    def spread(self) -> tuple[Ruler, ...]:
        """Some of the rulers, evenly over all sizes, because near and far ones show different things."""
        ordered = sorted(self._rulers, key=lambda ruler: ruler.width_px)
        if len(ordered) <= RULER_COUNT:
            return tuple(ordered)
        places = np.linspace(0, len(ordered) - 1, RULER_COUNT).round().astype(int)
        return tuple(ordered[place] for place in places)


def vehicles_of(
    source: Source,
    detector: Detector,
    piece_s: tuple[float, float] = WHOLE_CLIP_S,
    going_on: Callable[[], bool] = lambda: True,
) -> tuple[tuple[Ruler, ...], int]:
    """Vehicles of a clip, and how many pictures were looked at.

    Args:
        source: straight pictures.
        detector: that needs no calibration: it looks everywhere.
        piece_s: from when to when the clip is looked through.
        going_on: whether somebody still wants to know.
    """
    vehicles = VehicleRulers(source.image_size)
    detected_ns, frames = None, 0
    for _, frame in pictures_of(source, piece_s):
        if not going_on():
            break
        if detected_ns is not None and (frame.time_ns - detected_ns) / 1e9 < DETECTED_EVERY_S:
            continue
        detected_ns, frames = frame.time_ns, frames + 1
        vehicles.look([detection.box for detection in detector.detect(frame.image)])
    return vehicles.spread(), frames


def ruler_of(box: Box, size: ImageSize) -> Ruler | None:
    """A box as a ruler; None if it is cut off, small or far aside.

    For a vehicle that shows its side, the width is computed from the height.
    """
    left, right = (part * size.width for part in AHEAD_PARTS)
    whole = box.x > 1 and box.right < size.width - 2 and box.bottom < (1 - BONNET_PART) * size.height
    if not whole or not left < box.center_x < right or box.w < SMALLEST_RULER_PX:
        return None
    shows_side = box.h < FLATTEST_REAR * box.w
    width_m = TALL_WIDTH_M if box.h > box.w else VEHICLE_WIDTH_M
    if shows_side:
        width_m = Gaussian(*(metres * box.w / box.h for metres in (CAR_HEIGHT_M.value, CAR_HEIGHT_M.sigma)))
    return Ruler(box.center_x, box.bottom, box.w, width_m, max(1.0, BOTTOM_SIGMA_PART * box.h), shows_side)


def _any_overlaps(box: Box, others: Sequence[Box], least_iou: float) -> bool:
    if not others:
        return False
    (row,), rows = (
        np.array([(box.x, box.y, box.w, box.h)]),
        np.array([(b.x, b.y, b.w, b.h) for b in others]),
    )
    return bool(intersection_over_union(row[None], rows).max() > least_iou)
