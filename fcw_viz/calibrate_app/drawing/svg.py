"""The picture with the drawing over it, as SVG that holds the picture itself."""

from base64 import b64encode
from html import escape

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.logs.overlay import Rgb
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
        parts += [_stroke(stroke, _css(stroke.color), thickness) for stroke in strokes]
    parts += [_label(label, scale) for label in drawing.labels]
    return (
        # The picture's own pixels: the centre of the top-left one is (0, 0).
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-0.5 -0.5 {width} {height}" role="img" '
        f'style="display: block; width: 100%; height: auto" font-family="Arial, sans-serif" '
        f'font-size="{FONT_CSS_PX * scale:.3f}"><title>The picture with the distances of its rows</title>'
        f"{''.join(parts)}</svg>"
    )


def _fill(fill: Fill, current: bool) -> str:
    color, opacity = fill_style(fill.kind, current)
    corners = " ".join(f"{column:.3f},{row:.3f}" for column, row in fill.corners_px)
    return f'<polygon points="{corners}" fill="{_css(color)}" fill-opacity="{opacity:g}"/>'


def _stroke(stroke: Stroke, color: str, thickness: float) -> str:
    points = " ".join(f"{column:.3f},{row:.3f}" for column, row in stroke.points_px)
    return f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="{thickness:.3f}"/>'


def _label(label: Label, scale: float) -> str:
    area = label.area
    # Two spaces in a row are one in SVG.
    text = escape(label.text).replace("  ", "\u2002")
    return (
        f'<rect x="{area.left_px:.3f}" y="{area.top_px:.3f}" width="{area.right_px - area.left_px:.3f}" '
        f'height="{area.bottom_px - area.top_px:.3f}" fill="white" fill-opacity="0.85"/>'
        f'<text x="{label.left_px + LABEL_MARGIN_CSS_PX * scale / 2:.3f}" '
        f'y="{label.row_px + BASELINE_EM * FONT_CSS_PX * scale:.3f}" fill="black">{text}</text>'
    )


def _css(color: Rgb) -> str:
    return "#{:02x}{:02x}{:02x}".format(*color)
