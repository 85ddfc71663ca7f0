"""Which box that was found is which vehicle's, and which of its edges it shows.

A detector may box a part of a vehicle: the rest is hidden, or dark, or was not taken for it. The box is still
that vehicle's, and one of two opposite edges is where it was expected; the other one is the end of the part.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fcw.box import Box, iou
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.kernels.assignment import assign
from fcw.tracking.ranging import BoxNoise, measures_height, measures_row, measures_width
from fcw.tracking.settings import TrackerSettings

NEVER = 1e6
"""Cost of a pair that must not be associated."""
PART_COST = 1.0
"""Whole boxes go before parts."""
PART_INSIDE = 0.8
"""How much of a part is inside the whole, at least, or of the whole inside what was thought to be it."""
PART_HEIGHT_RATIO = 1.3
PART_BOTTOM = 0.15
"""It stands where the whole does, up to this part of its height: else it is another vehicle."""
OFF_PART = 0.15
OFF_SIGMAS = 4.0
"""An edge is not where it was expected that is off by more than both: this part of the box's extent, and so
many sigmas of its noise."""

TOUCHING = 0.1
NEARER = 0.05
"""A box touches another one whose edge is closer than this part of its width. Of two vehicles the one that
stands lower by more than this part of the other one's height is the nearer one."""


class Edges(NamedTuple):
    """Which edges of a box are the vehicle's own."""

    left: bool = True
    top: bool = True
    right: bool = True
    bottom: bool = True

    def both(self, other: "Edges") -> "Edges":
        """The edges that both have."""
        return Edges(*(here and there for here, there in zip(self, other, strict=True)))

    @property
    def across(self) -> bool:
        """Whether the width is the vehicle's."""
        return self.left and self.right


WHOLE = Edges()


def associate(
    predicted: Sequence[Box],
    found: Sequence[Box],
    size: ImageSize,
    settings: TrackerSettings,
    least_iou: float = 0.0,
) -> list[tuple[int, int]]:
    """Pairs (predicted, found) of least total cost: overlap lost, plus the difference in scale.

    Args:
        predicted: of the vehicles that are followed, in or beyond the picture.
        found: in the picture.
        size: of the picture.
        settings: of the tracker.
        least_iou: least IoU of a pair, besides the limits of the settings.
    """
    if not predicted or not found:
        return []
    # What of a vehicle is beyond the picture's edges is not found.
    inside = [in_picture(box, size) for box in predicted]
    cost = np.array([[_cost(box, other, size, settings) for other in found] for box in inside])
    return [
        (row, column)
        for row, column in assign(cost)
        if cost[row, column] < NEVER and iou(inside[row], found[column]) >= least_iou
    ]


def match_detections(
    predicted: Sequence[Box],
    confirmed: Sequence[bool],
    detections: Sequence[Detection],
    size: ImageSize,
    settings: TrackerSettings,
) -> list[tuple[int, int]]:
    """Pairs (vehicle, detection), in the order of the vehicles.

    Boxes go to vehicles that are believed before those that are not yet: a second box of a vehicle begins
    a track that would take its first one from it. Faint boxes go to vehicles that are not found
    otherwise, or to none (both as in ByteTrack, Zhang et al. 2022).

    Args:
        predicted: of the vehicles that are followed, in or beyond the picture.
        confirmed: which of them are believed.
        detections: in the picture.
        size: of the picture.
        settings: of the tracker.
    """
    pairs = list[tuple[int, int]]()
    vehicles = range(len(predicted))
    believed = [vehicle for vehicle in vehicles if confirmed[vehicle]]
    new = [vehicle for vehicle in vehicles if not confirmed[vehicle]]
    for wanted, faint, least_iou in (
        (believed, False, 0.0),
        (new, False, 0.0),
        (vehicles, True, settings.faint_iou),
    ):
        taken, used = {vehicle for vehicle, _ in pairs}, {index for _, index in pairs}
        free = [vehicle for vehicle in wanted if vehicle not in taken]
        found = [
            index
            for index, detection in enumerate(detections)
            if detection.faint == faint and index not in used
        ]
        matched = associate(
            [predicted[vehicle] for vehicle in free],
            [detections[index].box for index in found],
            size,
            settings,
            least_iou,
        )
        pairs += [(free[row], found[column]) for row, column in matched]
    return sorted(pairs)


def own_edges(found: Box, predicted: Box, size: ImageSize, noise: BoxNoise) -> Edges:
    """Which edges of a box are those of the vehicle that it was associated with.

    Where one of two opposite edges is where it was expected and the other one is not, a part was boxed. Where
    neither is, the vehicle is elsewhere than was thought.
    """
    predicted = in_picture(predicted, size)
    least_px = OFF_SIGMAS * noise.edge_sigma_px(found)
    across_px, down_px = max(least_px, OFF_PART * predicted.w), max(least_px, OFF_PART * predicted.h)
    left, right = abs(found.x - predicted.x) <= across_px, abs(found.right - predicted.right) <= across_px
    top = abs(found.y - predicted.y) <= down_px
    bottom = abs(found.bottom - predicted.bottom) <= down_px * noise.bottom_ratio
    # The picture's border is where it was expected, and says nothing.
    across = (left or right) and measures_width(found, size, noise)
    down = (top or bottom) and measures_row(found, size, noise) and measures_height(found, size, noise)
    # What is wider than was expected is no part of it: it was expected too narrow.
    left |= found.x < predicted.x
    right |= found.right > predicted.right
    return Edges(left or not across, top or not down, right or not across, bottom or not down)


def cut_as_expected(found: Box, predicted: Box, size: ImageSize, noise: BoxNoise) -> Box:
    """The box found, extended to the picture's border where the vehicle was expected to go beyond it.

    A detector that sees part of a near vehicle may end its box a little inside the picture. Taken for the
    vehicle's own edge, that would make it narrower, or have it move towards our path.
    """
    off_px, border = OFF_SIGMAS * noise.edge_sigma_px(found), size.width - 0.5
    left, right = found.x, found.right
    if predicted.x < -0.5 - off_px and left <= -0.5 + off_px:
        left = -0.5
    if predicted.right > border + off_px and right >= border - off_px:
        right = border
    return Box(left, found.y, right - left, found.h)


def free_edges(box: Box, others: Sequence[Box], camera: GroundPlaneCamera, length_m: float) -> Edges:
    """Which edges of a box are free of nearer vehicles, behind which more of this one may come out.

    Where a side is not, the height is not either: what is seen of a hidden vehicle begins anywhere. Of a
    vehicle beside us we see the inner side: its edge there is that side's far end, and of a vehicle straight
    ahead it hides nothing that is nearer.

    Args:
        box: of the vehicle.
        others: that were found in the same picture; the box itself may be among them.
        camera: as calibrated.
        length_m: of vehicles.
    """
    left = right = True
    apart_px, lower_px = TOUCHING * box.w, box.bottom + NEARER * box.h
    axis_px, distance_m = camera.principal_column_px, camera.distance_at(box.bottom)
    ahead = box.x < axis_px < box.right
    for other in others:
        if other.bottom <= lower_px or other.y >= box.bottom:
            continue
        beside = ahead and camera.distance_at(other.bottom) + length_m > distance_m
        if not (beside and other.right < axis_px):
            left = left and not other.x < box.x - apart_px < other.right
        if not (beside and other.x > axis_px):
            right = right and not other.x < box.right + apart_px < other.right
    return Edges(left, left and right, right)


def completed(found: Box, predicted: Box, edges: Edges) -> Box:
    """The box of the whole vehicle of which a part was found."""
    if edges == WHOLE:
        return found
    left, top = found.x if edges.left else predicted.x, found.y if edges.top else predicted.y
    right = found.right if edges.right else predicted.right
    bottom = found.bottom if edges.bottom else predicted.bottom
    return Box(left, top, right - left, bottom - top) if right > left and bottom > top else found


def towards(box: Box, found: Box, part: float, size: ImageSize, noise: BoxNoise) -> Box:
    """The box moved by a part of the way to the one found.

    An edge found at the picture's border says only that the vehicle goes on beyond it: where its own is
    believed there, it stays.
    """
    left, top, right, bottom = (
        was + part * (now - was)
        for was, now in zip(
            (box.x, box.y, box.right, box.bottom), (found.x, found.y, found.right, found.bottom), strict=True
        )
    )
    if not measures_row(found, size, noise):
        bottom = max(bottom, box.bottom)
    if not measures_width(found, size, noise):
        if found.center_x < size.width / 2:
            left = min(left, box.x)
        else:
            right = max(right, box.right)
    return Box(left, top, right - left, bottom - top)


def in_picture(box: Box, size: ImageSize) -> Box:
    """The part of a box in the picture: as much of one beyond its left edge as of one beyond its right."""
    top, bottom = max(box.y, -0.5), min(box.bottom, size.height - 0.5)
    # Of one that is beyond an edge, the column of pixels at that edge.
    left = min(max(box.x, -0.5), size.width - 1.5)
    right = max(min(box.right, size.width - 0.5), left + 1.0)
    return Box(left, top, right - left, max(bottom - top, 1.0))


def _cost(predicted: Box, found: Box, size: ImageSize, settings: TrackerSettings) -> float:
    # Small boxes are mostly noise: each is widened by it before their overlap is judged.
    pad = settings.padding_sigmas * settings.box_noise.edge_sigma_px(found)
    width = min(predicted.right, found.right) - max(predicted.x, found.x) + 2 * pad
    height = min(predicted.bottom, found.bottom) - max(predicted.y, found.y) + 2 * pad
    if width <= 0 or height <= 0:
        return NEVER
    shared = width * height
    areas = [(box.w + 2 * pad) * (box.h + 2 * pad) for box in (predicted, found)]
    overlap = shared / (sum(areas) - shared)
    log_scale = abs(math.log(found.w / predicted.w))
    limit = math.log(settings.maximum_scale_ratio)
    limit += settings.padding_sigmas * settings.box_noise.log_width_sigma(found)
    cost = 1 - overlap + log_scale
    if overlap >= settings.minimum_iou and log_scale <= limit:
        return cost
    is_part = (
        measures_width(predicted, size, settings.box_noise)
        and shared >= PART_INSIDE * min(areas)
        and 1 / PART_HEIGHT_RATIO <= found.h / predicted.h <= PART_HEIGHT_RATIO
        and abs(found.bottom - predicted.bottom) <= PART_BOTTOM * predicted.h
    )
    return PART_COST + cost if is_part else NEVER
