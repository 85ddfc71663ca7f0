"""A round magnifier that stands beside a pixel of the picture and shows it with a cross-hair."""

import math

import cv2
import numpy as np
import viser
from numpy.typing import NDArray

from fcw_viz.page.picture.handle import HANDLE_LAYER
from fcw_viz.page.picture.label_layout import Window
from fcw_viz.page.picture.plane import FACING_WXYZ, PicturePlane

MAGNIFICATION = 8
"""CSS pixels that an image pixel covers in it."""

# Lengths in CSS pixels.
_DIAMETER = 169
_BESIDE = 155  # from the pixel to the middle of the glass: what is above and below the pixel stays in sight
_MARGIN = 8
_CROSS_GAP = 10  # around the pixel itself
_LAYER = HANDLE_LAYER + 4
_ENOUGH = 0.75  # a picture zoomed in to that part of the magnification needs no glass
_LIGHT, _DARK = (255, 255, 255), (20, 20, 20)


def magnified(image_bgr: NDArray[np.uint8], column_px: float, row_px: float) -> NDArray[np.uint8]:
    """What the glass shows over a pixel.

    Args:
        image_bgr: the picture, (height, width, 3).
        column_px: of the position under the cross, fractions of a pixel included.
        row_px: the same.

    Returns:
        (diameter, diameter, 4) RGBA, transparent outside the glass.
    """
    middle = (_DIAMETER - 1) / 2
    to_glass = np.array(
        [
            [MAGNIFICATION, 0, middle - MAGNIFICATION * column_px],
            [0, MAGNIFICATION, middle - MAGNIFICATION * row_px],
        ]
    )
    glass = cv2.warpAffine(image_bgr, to_glass, (_DIAMETER, _DIAMETER), flags=cv2.INTER_LINEAR)
    centre = round(middle)
    for color, thickness in ((_DARK, 3), (_LIGHT, 1)):
        for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            inner = (centre + x * _CROSS_GAP, centre + y * _CROSS_GAP)
            cv2.line(glass, inner, (centre + x * centre, centre + y * centre), color, thickness)
    for color, thickness in ((_DARK, 5), (_LIGHT, 2)):
        cv2.circle(glass, (centre, centre), centre - 3, color, thickness, cv2.LINE_AA)
    mask = np.zeros(glass.shape[:2], np.uint8)
    cv2.circle(mask, (centre, centre), centre - 2, 255, cv2.FILLED, cv2.LINE_AA)
    return np.dstack([glass[..., ::-1], mask]).astype(np.uint8)


def place_beside(
    place_px: tuple[float, float], window: Window, beside_px: float, room_px: float
) -> tuple[float, float]:
    """Where the glass stands whole: right or left of the pixel; in a narrow window above or below it."""
    column_px, row_px = place_px
    row_inside_px = min(max(row_px, window.top_px + room_px), window.bottom_px - room_px)
    if column_px + beside_px + room_px <= window.right_px:
        return column_px + beside_px, row_inside_px
    if column_px - beside_px - room_px >= window.left_px:
        return column_px - beside_px, row_inside_px
    column_inside_px = min(max(column_px, window.left_px + room_px), window.right_px - room_px)
    if row_px - window.top_px > window.bottom_px - row_px:
        return column_inside_px, max(row_px - beside_px, window.top_px + room_px)
    return column_inside_px, min(row_px + beside_px, window.bottom_px - room_px)


class Magnifier:
    """The glass of one view."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._middle_px = (0.0, 0.0)
        self._radius_px = 0.0
        self._node = scene.add_image(
            "/magnifier",
            np.zeros((1, 1, 4), np.uint8),
            1.0,
            1.0,
            format="png",
            cast_shadow=False,
            receive_shadow=False,
            wxyz=FACING_WXYZ,
            visible=False,
        )

    def show(
        self,
        image_bgr: NDArray[np.uint8],
        plane: PicturePlane,
        window: Window,
        column_px: float,
        row_px: float,
    ) -> None:
        """Puts it beside a pixel, where there is room; not over a picture that is itself as large.

        Args:
            image_bgr: the picture, (height, width, 3).
            plane: of the picture.
            window: the part of it that is seen.
            column_px: of the pixel.
            row_px: of the pixel.
        """
        scale = window.pixels_per_screen_pixel
        if scale * MAGNIFICATION * _ENOUGH < 1:
            self.hide()
            return
        self._radius_px = _DIAMETER / 2 * scale
        room_px, beside_px = self._radius_px + _MARGIN * scale, _BESIDE * scale
        self._middle_px = place_beside((column_px, row_px), window, beside_px, room_px)
        middle_column_px, middle_row_px = self._middle_px
        self._node.position = plane.world(middle_column_px, middle_row_px, _LAYER)
        self._node.render_width = self._node.render_height = 2 * self._radius_px * plane.scale
        self._node.image = magnified(image_bgr, column_px, row_px)
        self._node.visible = True

    def hide(self) -> None:
        """Puts it away."""
        self._node.visible = False

    def covers(self, column_px: float, row_px: float) -> bool:
        """Whether a pixel of the picture cannot be seen for it."""
        return self._node.visible and math.dist((column_px, row_px), self._middle_px) <= self._radius_px
