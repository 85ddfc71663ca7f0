"""What a box tells about the distance of its vehicle, and how well: its lower edge and its width.

The lower edge stands on the road and measures distance through the calibration. The width measures distance
up to the unknown width of the vehicle, and so how the distance changes (Dagan et al. 2004, "Forward collision
warning with a single camera").
"""

import math
from dataclasses import dataclass

from fcw.box import Box
from fcw.frame import ImageSize

CUT_MARGIN_PX = 2.0
CUT_MARGIN_SIGMAS = 2.0
"""An edge of a box this near the picture's border may be the border instead of the vehicle's edge."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxNoise:
    """How far the edges of a detector's boxes are off.

    Attributes:
        edge_floor_px: 1-sigma of an edge of the smallest boxes, due to the grid of the detector's windows.
        edge_fraction: 1-sigma of an edge as a fraction of the box's height. The detector's windows are a
            twelfth of a vehicle apart, and so are neighbouring scales: uniform errors of 2.5 % each. Together
            with the floor, 1.3 px at a height of 20 px and 2.6 px at 60 px.
        bottom_ratio: sigma of the lower edge over that of the others.
        free_height: whether the height of a box is measured, as by our detector's regressor. If the aspect
            ratio of windows follows from their row, the height tells no more than the width.
        shows_side: whether a box includes the visible side of a vehicle beside our path. On the simulated
            drive, our detector's boxes are 1.21 times as wide as the rears there, and 1.12 times straight
            ahead. On the two sets of labels they are 0.98 and 1.01 times as wide as boxes drawn by hand
            (medians of 86 and 60 hits), so that no more is subtracted.
        at_tyres: whether a box ends where the tyres meet the road, ahead of the rear. People draw boxes like
            this, and detectors learn it. KITTI's boxes are projected from 3D boxes, and end at the rear.
        width_bias_sigma: 1-sigma of the log factor by which the detector draws all boxes of a drive too wide.
            It does not average out, but the lower edges of near vehicles reveal it. Our detector's boxes were
            0.98, 1.01 and, on the simulated drive, 1.12 times as wide as drawn by hand or as true: 0.07 about
            one.
        correlation_s: correlation time of the errors of one vehicle's boxes.
    """

    edge_floor_px: float = 1.0
    edge_fraction: float = 0.04
    bottom_ratio: float = 1.0
    correlation_s: float = 0.1
    free_height: bool = True
    shows_side: bool = True
    at_tyres: bool = True
    width_bias_sigma: float = 0.07

    def edge_sigma_px(self, box: Box) -> float:
        """1-sigma of the row or column of an edge of a box other than the lower one."""
        return math.hypot(self.edge_floor_px, self.edge_fraction * box.h)

    def bottom_sigma_px(self, box: Box) -> float:
        """1-sigma of the row of the lower edge."""
        return self.bottom_ratio * self.edge_sigma_px(box)

    def log_width_sigma(self, box: Box) -> float:
        """1-sigma of the logarithm of a box's width, whose two edges err independently."""
        return math.sqrt(2) * self.edge_sigma_px(box) / box.w

    def white(self, dt_s: float) -> float:
        """Factor on a box's variance so that white noise at intervals `dt_s` averages out as slowly."""
        return max(1.0, 2 * self.correlation_s / dt_s)


def measures_row(box: Box, image_size: ImageSize, noise: BoxNoise) -> bool:
    """Whether the lower edge of the box is on the road, and not the picture's border."""
    margin_px = max(CUT_MARGIN_PX, CUT_MARGIN_SIGMAS * noise.bottom_sigma_px(box))
    return box.bottom < image_size.height - 0.5 - margin_px


def measures_width(box: Box, image_size: ImageSize, noise: BoxNoise) -> bool:
    """Whether both sides of the box are the vehicle's own, not the picture's border."""
    margin_px = max(CUT_MARGIN_PX, CUT_MARGIN_SIGMAS * noise.edge_sigma_px(box))
    return box.x > -0.5 + margin_px and box.right < image_size.width - 0.5 - margin_px


def inner_edge_px(box: Box, image_size: ImageSize, noise: BoxNoise) -> float | None:
    """Column of the vehicle's visible side if the picture's border cuts the other one; else None."""
    margin_px = max(CUT_MARGIN_PX, CUT_MARGIN_SIGMAS * noise.edge_sigma_px(box))
    left_cut = box.x <= -0.5 + margin_px
    right_cut = box.right >= image_size.width - 0.5 - margin_px
    if left_cut == right_cut:
        return None
    return box.right if left_cut else box.x


def measures_height(box: Box, image_size: ImageSize, noise: BoxNoise) -> bool:
    """Whether the upper edge of the box is the vehicle's own, and its height is measured (`free_height`)."""
    margin_px = max(CUT_MARGIN_PX, CUT_MARGIN_SIGMAS * noise.edge_sigma_px(box))
    return noise.free_height and box.y > -0.5 + margin_px
