"""The distance prior as a filter: which boxes of any detector can be vehicles on the road.

The geometry is that of `fcw.detection.windows.plan`, with widths instead of sizes: a vehicle of W metres is W
/ h times as wide as the number of rows from the horizon to its bottom edge, for some pitch within the
tolerance.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize

CUT_MARGIN = 0.01
"""An edge this near to the picture's border, as a fraction of the picture's height, may be the border instead
of the vehicle's edge: three pixels for a net with an input of 320 px.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlausibleVehicles:
    """Limits of what can be a vehicle.

    Attributes:
        narrowest_m: least width. A motorcycle with its mirrors is 0.7 m wide.
        widest_m: largest width. A car seen from its side is 4.7 m wide; the widest lorries are 2.6 m from
            behind.
        lowest_m: least height. The roofs of sports cars are 1.1 m high, and some of their boxes end below.
        nearest_m: nearest distance from the camera, most of which is behind our own bumper.
        farthest_m: farthest distance, as of the detector with the distance prior; farther away, boxes tell no
            distance.
        pitch_tolerance_rad: see `fcw.detection.acf.AcfSettings`.
    """

    narrowest_m: float = 0.6
    widest_m: float = 5.0
    lowest_m: float = 1.0
    nearest_m: float = 2.0
    farthest_m: float = 80.0
    pitch_tolerance_rad: float = math.radians(1.0)


ROAD_VEHICLES = PlausibleVehicles()


def plausible(
    boxes: NDArray[np.float64],
    camera: GroundPlaneCamera,
    size: ImageSize,
    vehicles: PlausibleVehicles = ROAD_VEHICLES,
) -> NDArray[np.bool_]:
    """Which boxes can be vehicles on the road.

    A box that is cut by the picture's border may be wider, and nearer, than it looks. A box that is cut at
    the bottom and lies wholly below the horizon is our own bonnet if even the nearest vehicle would be
    higher, or if it is cut on both sides, too.

    Args:
        boxes: (N, 4) x, y, w, h.
        camera: the calibrated camera.
        size: size of the picture.
        vehicles: limits of what can be a vehicle.
    """
    tolerance_rad = vehicles.pitch_tolerance_rad
    up, down = (replace(camera, pitch_rad=camera.pitch_rad + sign * tolerance_rad) for sign in (1, -1))
    bottoms, widths_in_heights = boxes[:, 1] + boxes[:, 3], boxes[:, 2] * camera.height_m
    first = np.maximum(
        up.horizon_row_px + widths_in_heights / vehicles.widest_m, up.row_at(vehicles.farthest_m)
    )
    last = down.horizon_row_px + widths_in_heights / vehicles.narrowest_m
    far_edges, limits = boxes[:, :2] + boxes[:, 2:], np.array([size.width, size.height]) - 0.5
    margin_px = CUT_MARGIN * size.height
    cut_left, cut_right = boxes[:, 0] < margin_px, far_edges[:, 0] > limits[0] - margin_px
    last = np.minimum(np.where(cut_left | cut_right, np.inf, last), down.row_at(vehicles.nearest_m))
    cut_below = bottoms > limits[1] - margin_px
    # Height over the camera's height is the box's rows over the rows from its bottom edge to the horizon.
    nearest_rows_px = down.row_at(vehicles.nearest_m) - down.horizon_row_px
    highest_m = camera.height_m * (1 - (boxes[:, 1] - down.horizon_row_px) / nearest_rows_px)
    bonnet = cut_below & ((highest_m < vehicles.lowest_m) | (cut_left & cut_right))
    bonnet &= boxes[:, 1] > down.horizon_row_px  # the camera looks over the bonnet
    possible = ((bottoms >= first) | cut_below) & ((bottoms <= last) | (cut_below & (last >= limits[1])))
    return possible & ~bonnet
