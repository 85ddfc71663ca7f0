"""Which detection belongs to which vehicle, and which edges of its box are the vehicle's.

A detector may box only a part of a vehicle, because the rest is hidden, or dark, or was overlooked. The box
still belongs to that vehicle. One of two opposite edges is then where it was expected, and the other one is
only the end of the part.
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
"""Extra cost of a box that is only a part, so that whole boxes are preferred."""
PART_INSIDE = 0.8
"""At least this part of the smaller box must be inside the larger one. The predicted box may be the
smaller."""
PART_HEIGHT_RATIO = 1.3
"""Largest ratio of the heights of a part and the whole."""
PART_BOTTOM = 0.15
"""Largest difference of the lower edges of a part and the whole, as a fraction of the height. Beyond it, the
box is another vehicle's."""
OFF_PART = 0.15
OFF_SIGMAS = 4.0
"""An edge is not where it was expected if it is off by more than this part of the box's extent and by more
than this many sigmas of its noise."""

TOUCHING = 0.1
"""A box touches another one if their edges are closer than this fraction of its width."""
NEARER = 0.05
"""A vehicle is nearer than another if it stands lower by more than this fraction of the other's height."""


class Edges(NamedTuple):
    """Which edges of a box are the vehicle's own, and not the end of what was seen of it."""

    left: bool = True
    top: bool = True
    right: bool = True
    bottom: bool = True

    def both(self, other: "Edges") -> "Edges":
        """The edges that are the vehicle's in both."""
        return Edges(*(here and there for here, there in zip(self, other, strict=True)))

    @property
    def across(self) -> bool:
        """Whether the width of the box is the vehicle's."""
        return self.left and self.right


WHOLE = Edges()


def associate(
    predicted: Sequence[Box],
    found: Sequence[Box],
    size: ImageSize,
    settings: TrackerSettings,
    least_iou: float = 0.0,
) -> list[tuple[int, int]]:
    """Pairs (predicted, found) of least total cost: 1 - IoU plus the difference in log scale.

    Args:
        predicted: predicted boxes of the vehicles; may extend beyond the picture.
        found: detected boxes.
        size: size of the picture.
        settings: settings of the tracker.
        least_iou: least IoU of a pair, in addition to the limits of the settings.
    """
    if not predicted or not found:
        return []
    # Detections end at the picture's edges.
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

    Confirmed vehicles are matched first. Otherwise a second box of a vehicle, which begins a track, could
    take the first box away from it. Faint detections are matched last, to vehicles without another detection
    (both as in ByteTrack, Zhang et al. 2022).

    Args:
        predicted: predicted boxes of the vehicles; may extend beyond the picture.
        confirmed: which of the vehicles are confirmed.
        detections: detections in the picture.
        size: size of the picture.
        settings: settings of the tracker.
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
    """Which edges of a box are those of the vehicle that it was matched to.

    If one of two opposite edges is where it was expected and the other is not, only a part was boxed. If
    neither is, the prediction was wrong, and both count as the vehicle's.
    """
    predicted = in_picture(predicted, size)
    least_px = OFF_SIGMAS * noise.edge_sigma_px(found)
    across_px, down_px = max(least_px, OFF_PART * predicted.w), max(least_px, OFF_PART * predicted.h)
    left, right = abs(found.x - predicted.x) <= across_px, abs(found.right - predicted.right) <= across_px
    top = abs(found.y - predicted.y) <= down_px
    bottom = abs(found.bottom - predicted.bottom) <= down_px * noise.bottom_ratio
    # An edge at the picture's border is always where it was expected, which tells nothing.
    across = (left or right) and measures_width(found, size, noise)
    down = (top or bottom) and measures_row(found, size, noise) and measures_height(found, size, noise)
    # A box that is wider than expected is no part; the expected one was too narrow.
    left |= found.x < predicted.x
    right |= found.right > predicted.right
    return Edges(left or not across, top or not down, right or not across, bottom or not down)


def cut_as_expected(found: Box, predicted: Box, size: ImageSize, noise: BoxNoise) -> Box:
    """The detected box, extended to the picture's border if the vehicle was expected to continue beyond it.

    A detector that sees only a part of a near vehicle may end the box a little inside the picture. Taken as
    the vehicle's own edge, this would make the vehicle narrower, or seem to move it towards our path.
    """
    off_px, border = OFF_SIGMAS * noise.edge_sigma_px(found), size.width - 0.5
    left, right = found.x, found.right
    if predicted.x < -0.5 - off_px and left <= -0.5 + off_px:
        left = -0.5
    if predicted.right > border + off_px and right >= border - off_px:
        right = border
    return Box(left, found.y, right - left, found.h)


def free_edges(box: Box, others: Sequence[Box], camera: GroundPlaneCamera, length_m: float) -> Edges:
    """Which edges of a box are free, in that no nearer vehicle touches them and may hide more of this one.

    If a side is not free, the upper edge is not either, because what is seen of a hidden vehicle may end
    anywhere. A vehicle beside us shows its inner side. The edge of its box there is the far end of that side,
    and hides nothing of a vehicle straight ahead that is nearer than this far end.

    Args:
        box: box of the vehicle.
        others: boxes found in the same picture; may include `box` itself.
        camera: the calibrated camera.
        length_m: length of a vehicle.
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
    """Box of the whole vehicle, completed from the prediction if only a part of it was found."""
    if edges == WHOLE:
        return found
    left, top = found.x if edges.left else predicted.x, found.y if edges.top else predicted.y
    right = found.right if edges.right else predicted.right
    bottom = found.bottom if edges.bottom else predicted.bottom
    return Box(left, top, right - left, bottom - top) if right > left and bottom > top else found


def towards(box: Box, found: Box, part: float, size: ImageSize, noise: BoxNoise) -> Box:
    """The box moved by a part of the way to the one found.

    An edge found at the picture's border only tells that the vehicle continues beyond it. If the box already
    extends beyond the border, its edge stays there.
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
    """The part of a box inside the picture; the left and the right border are treated alike."""
    top, bottom = max(box.y, -0.5), min(box.bottom, size.height - 0.5)
    # Of a box wholly beyond a border, the column of pixels at that border.
    left = min(max(box.x, -0.5), size.width - 1.5)
    right = max(min(box.right, size.width - 0.5), left + 1.0)
    return Box(left, top, right - left, max(bottom - top, 1.0))


def _cost(predicted: Box, found: Box, size: ImageSize, settings: TrackerSettings) -> float:
    # Small boxes are mostly noise, so boxes are widened by the noise before their overlap is judged.
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
