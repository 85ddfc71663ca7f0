"""The picture itself as if seen from above: the road's plane put back on the ground by the calibration."""

from base64 import b64encode

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.charts.svg import element, line, picture, words
from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.document.numbers_text import row_distance_text
from fcw_viz.calibrate_app.document.state import Result
from fcw_viz.calibrate_app.drawing.birds_eye import GroundScale
from fcw_viz.calibrate_app.drawing.figures import AMBER, FIGURE_STYLE, TEAL

DETAIL = 2.0
"""Pixels of the warped picture to one of the drawing."""
JPEG_QUALITY = 80
AHEAD_M = 30.0
"""Farther away a picture has too few pixels to judge lines by."""
NEAREST_M = 0.5
OUTSIDE = (128, 128, 128)
LANE_M, LANE_FT = 3.5, 12.0
"""A usual lane, drawn as a bar to hold against the lane lines."""

LABEL_PX, GROUND_OPACITY = 34, 0.55
"""Width of the dark ground that words on the picture stand on."""


def warped_scale(result: Result) -> GroundScale:
    """The scale of `warped_svg`: near enough to judge a lane's width."""
    return GroundScale(220.0, 360.0, AHEAD_M, max(result.calibration.reference_offset_m, 1.0))


def warp_to_ground(
    image_bgr: NDArray[np.uint8], calibration: Calibration, scale: GroundScale, detail: float = DETAIL
) -> NDArray[np.uint8]:
    """The road seen from above.

    Args:
        image_bgr: (height, width, 3).
        calibration: of the picture.
        scale: where each point of the ground goes.
        detail: pixels of the result to one of the scale.

    Returns:
        (height, width, 3) of the scale, `detail` times as large; grey where the picture sees no road.
    """
    columns = (np.arange(round(scale.width_px * detail)) + 0.5) / detail
    rows = (np.arange(round(scale.height_px * detail)) + 0.5) / detail
    lateral_m = (scale.width_px / 2 - columns) / scale.px_per_m
    distance_m = scale.ahead_m - rows / scale.px_per_m
    # Behind the camera's foot nothing is seen, and the projection would turn over.
    seen = distance_m + calibration.reference_offset_m > max(NEAREST_M, NEAREST_M - calibration.camera.pole_m)
    shape = (len(distance_m), len(lateral_m))
    lateral_m = np.asarray(np.broadcast_to(lateral_m, shape), np.float64)
    distance_m = np.asarray(np.broadcast_to(np.where(seen, distance_m, 1.0)[:, None], shape), np.float64)
    map_x = np.where(seen[:, None], calibration.column_at(lateral_m, distance_m), -1e4)
    map_y = calibration.row_at(distance_m)
    way = calibration.straightening
    if way is not None:
        places = way.to_picture(np.column_stack((map_x.ravel(), map_y.ravel())))
        map_x, map_y = (np.nan_to_num(places[:, k], nan=-1e4).reshape(shape) for k in (0, 1))
    return cv2.remap(
        image_bgr,
        map_x.astype(np.float32),
        map_y.astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=OUTSIDE,
    ).astype(np.uint8)


def warped_svg(image_bgr: NDArray[np.uint8], result: Result, scale: GroundScale, imperial: bool) -> str:
    """The warped picture as inline SVG, with the rows of the distances and a lane's width to compare with."""
    warped = warp_to_ground(image_bgr, result.calibration, scale)
    _, data = cv2.imencode(".jpg", warped, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    href = f"data:image/jpeg;base64,{b64encode(data.tobytes()).decode()}"
    parts = [f'<image width="{scale.width_px:g}" height="{scale.height_px:g}" href="{href}"/>']
    for row in result.rows:
        if 0 < row.distance_m <= scale.ahead_m:
            y = scale.place(row.distance_m, 0.0)[1]
            parts.append(element("line", x1=0, y1=y, x2=scale.width_px, y2=y, stroke=TEAL, stroke_width=0.8))
            label = row_distance_text(row.distance_m, imperial)
            size = {"width": LABEL_PX, "height": 12}
            parts.append(element("rect", x=2, y=y - 13, **size, fill="black", fill_opacity=GROUND_OPACITY))
            parts.append(f'<g style="color: white">{words(4, y - 3, label)}</g>')
    parts.append(_lane_bar(scale, imperial))
    title = "The picture seen from above"
    return picture(scale.width_px, scale.height_px, parts, title, style=FIGURE_STYLE)


def _lane_bar(scale: GroundScale, imperial: bool) -> str:
    length_m = LANE_FT / FEET_PER_METRE if imperial else LANE_M
    half_px = length_m * scale.px_per_m / 2
    middle_px, y = scale.width_px / 2, scale.height_px - 8
    bar = element(
        "line", x1=middle_px - half_px, y1=y, x2=middle_px + half_px, y2=y, stroke=AMBER, stroke_width=3
    )
    ends = "".join(line(middle_px + s * half_px, y - 5, middle_px + s * half_px, y + 5, 0.9) for s in (-1, 1))
    ground = element(
        "rect",
        x=middle_px - half_px - 5,
        y=y - 8,
        width=2 * half_px + LABEL_PX + 11,
        height=15,
        fill="black",
        fill_opacity=GROUND_OPACITY,
    )
    label = words(middle_px + half_px + 6, y + 4, row_distance_text(length_m, imperial))
    return f'{ground}<g style="color: {AMBER}">{bar}{ends}</g><g style="color: white">{label}</g>'
