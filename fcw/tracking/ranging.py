"""What a detection's box says about range, and how well: its lower edge and its width.

The lower edge stands on the road and measures distance through the calibration. The width measures
distance up to the vehicle's own width, and so how the distance changes (Dagan et al. 2004, "Forward
collision warning with a single camera").
"""

import math
from dataclasses import dataclass

from fcw.box import Box
from fcw.frame import ImageSize

CUT_MARGIN_PX = 2.0
CUT_MARGIN_SIGMAS = 2.0
"""An edge this near the picture's border may be the border and not the vehicle's edge."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxNoise:
    """How far the edges of a detector's boxes are off.

    Attributes:
        edge_floor_px: 1-sigma of an edge of the smallest boxes: the grid of windows is no finer.
        edge_fraction: 1-sigma of an edge as a fraction of the box's height: the detector's windows are a
            twelfth of a vehicle apart and neighbouring scales differ by as much, uniform errors of 2.5 %
            each. Together 1.3 px at a height of 20 px and 2.6 px at 60 px.
        bottom_ratio: sigma of the lower edge over that of the others.
        free_height: whether the height of a box is measured, as the own detector's regressor does; of windows
            with an aspect ratio that follows from their row it would say nothing that the width does not.
        shows_side: whether a box takes in the visible side of a vehicle beside our path: the own detector's
            are 1.21 times as wide as the rears there on the simulated drive, 1.12 times straight ahead. On
            the two sets of labels they are 0.98 and 1.01 times as wide as the boxes drawn by hand (medians of
            86 and 60 hits), so that no more is taken off.
        at_tyres: whether a box ends where tyres meet the road, ahead of the rear, as people draw boxes and
            detectors learn to; KITTI's are those of boxes around the vehicles, and end at the rear.
        width_bias_sigma: 1-sigma of the logarithm by which the detector draws the boxes of all vehicles of a
            drive too wide; it cannot be averaged away, but near vehicles' rows teach it. The own detector's
            were 0.98, 1.01 and, on the simulated drive, 1.12 times as wide as drawn by hand or as true: 0.07
            about one.
        correlation_s: time over which the errors of one vehicle's boxes stay alike.
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
        """1-sigma of the row or column of one edge of a box, the lower one aside."""
        return math.hypot(self.edge_floor_px, self.edge_fraction * box.h)

    def bottom_sigma_px(self, box: Box) -> float:
        """1-sigma of the row of the lower edge."""
        return self.bottom_ratio * self.edge_sigma_px(box)

    def log_width_sigma(self, box: Box) -> float:
        """1-sigma of the logarithm of a box's width, whose two edges err independently."""
        return math.sqrt(2) * self.edge_sigma_px(box) / box.w

    def white(self, dt_s: float) -> float:
        """Factor on the variance of white noise at intervals dt that averages down as slowly as this does."""
        return max(1.0, 2 * self.correlation_s / dt_s)


def measures_row(box: Box, image_size: ImageSize, noise: BoxNoise) -> bool:
    """Whether the lower edge of the box is the road and not the picture's border."""
    margin_px = max(CUT_MARGIN_PX, CUT_MARGIN_SIGMAS * noise.bottom_sigma_px(box))
    return box.bottom < image_size.height - 0.5 - margin_px


def measures_width(box: Box, image_size: ImageSize, noise: BoxNoise) -> bool:
    """Whether both sides of the box are the vehicle's own, not the picture's border."""
    margin_px = max(CUT_MARGIN_PX, CUT_MARGIN_SIGMAS * noise.edge_sigma_px(box))
    return box.x > -0.5 + margin_px and box.right < image_size.width - 0.5 - margin_px


def inner_edge_px(box: Box, image_size: ImageSize, noise: BoxNoise) -> float | None:
    """Column of the vehicle's own side where the picture's border cuts the other one; else None."""
    margin_px = max(CUT_MARGIN_PX, CUT_MARGIN_SIGMAS * noise.edge_sigma_px(box))
    left_cut = box.x <= -0.5 + margin_px
    right_cut = box.right >= image_size.width - 0.5 - margin_px
    if left_cut == right_cut:
        return None
    return box.right if left_cut else box.x


def measures_height(box: Box, image_size: ImageSize, noise: BoxNoise) -> bool:
    """Whether the upper edge of the box is the vehicle's own, and free."""
    margin_px = max(CUT_MARGIN_PX, CUT_MARGIN_SIGMAS * noise.edge_sigma_px(box))
    return noise.free_height and box.y > -0.5 + margin_px
