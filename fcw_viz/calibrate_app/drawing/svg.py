"""The picture with the drawing over it, as SVG that holds the picture itself."""

from base64 import b64encode

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.charts.svg import css_color, element, words
from fcw_viz.calibrate_app.drawing.drawing import Drawing, fill_style
from fcw_viz.calibrate_app.drawing.pen import Fill, Stroke
from fcw_viz.page.picture.label_layout import FONT_CSS_PX, LABEL_MARGIN_CSS_PX, Label

JPEG_QUALITY = 88
OUTLINE = "#0c0e12"
THICKNESS_CSS_PX = {False: 1.3, True: 2.6}
"""Of a line, by whether it is strong."""
OUTLINE_CSS_PX = 0.9
BASELINE_EM = 0.35
"""From the middle height of words down to their base line."""


def picture_overlay_svg(
    image_bgr: NDArray[np.uint8], drawing: Drawing, pixels_per_screen_pixel: float
) -> str:
    """An SVG element that fills the width it is given.

    Args:
        image_bgr: (height, width, 3), the picture.
        drawing: laid out for the same scale.
        pixels_per_screen_pixel: picture pixels that a CSS pixel will cover.
    """
    height, width = image_bgr.shape[:2]
    scale = pixels_per_screen_pixel
    _, data = cv2.imencode(".jpg", image_bgr, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    picture = (
        f'<image x="-0.5" y="-0.5" width="{width}" height="{height}" '
        f'href="data:image/jpeg;base64,{b64encode(data.tobytes()).decode()}"/>'
    )
    parts = [picture, *(_fill(fill, drawing.current) for fill in drawing.fills)]
    for strong in (False, True):
        strokes = [stroke for stroke in drawing.strokes if stroke.strong is strong]
        thickness = THICKNESS_CSS_PX[strong] * scale
        outline = thickness + 2 * OUTLINE_CSS_PX * scale
        parts += [_stroke(stroke, OUTLINE, outline) for stroke in strokes]
        parts += [_stroke(stroke, css_color(stroke.color), thickness) for stroke in strokes]
    parts += [_label(label, scale) for label in drawing.labels]
    return (
        # The picture's own pixels: the centre of the top-left one is (0, 0).
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-0.5 -0.5 {width} {height}" role="img" '
        f'style="display: block; width: 100%; height: auto; color: black" font-family="Arial, sans-serif" '
        f'font-size="{FONT_CSS_PX * scale:.3f}"><title>The picture with the distances of its rows</title>'
        f"{''.join(parts)}</svg>"
    )


def _fill(fill: Fill, current: bool) -> str:
    color, opacity = fill_style(fill.kind, current)
    return element("polygon", points=fill.corners_px, fill=css_color(color), fill_opacity=opacity)


def _stroke(stroke: Stroke, color: str, thickness: float) -> str:
    points = stroke.points_px
    return element("polyline", points=points, fill="none", stroke=color, stroke_width=thickness)


def _label(label: Label, scale: float) -> str:
    area = label.area
    size = {"width": area.right_px - area.left_px, "height": area.bottom_px - area.top_px}
    left_px = label.left_px + LABEL_MARGIN_CSS_PX * scale / 2
    base_px = label.row_px + BASELINE_EM * FONT_CSS_PX * scale
    ground = element("rect", x=area.left_px, y=area.top_px, **size, fill="white", fill_opacity=0.85)
    return ground + words(left_px, base_px, label.text)
