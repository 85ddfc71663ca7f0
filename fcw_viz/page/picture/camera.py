"""How one tab looks at its picture: squarely, slid and zoomed, or away at another place of the scene."""

from collections import deque

import numpy as np
import viser
from numpy.typing import NDArray

from fcw.frame import ImageSize
from fcw_viz.page.picture.away import Orbit
from fcw_viz.page.picture.plane import FIELD_OF_VIEW_RAD, PicturePlane
from fcw_viz.page.script import run_script

_FIT_MARGIN = 1.02
_FARTHEST_FITS = 2.0  # zoomed out at most until the picture fills half the window
_CLOSEST_PIXEL = 64.0  # zoomed in at most until an image pixel covers that many screen pixels
_REMEMBERED_FITS = 16  # of a window that is being resized, on their way to the browser and back


class PictureCamera:
    """The camera of one tab.

    Attributes:
        plane: where the picture's pixels are in the scene.
        away: whether the camera looks at something else than the picture.
    """

    def __init__(self, client: viser.ClientHandle, image_size: ImageSize) -> None:
        self.plane = PicturePlane(image_size)
        self.away = False
        self._client = client
        self._fitting: deque[tuple[float, float, float]] = deque(maxlen=_REMEMBERED_FITS)
        self._fit_is_on_its_way = False
        client.camera.fov = FIELD_OF_VIEW_RAD

    def leave(self, orbit: Orbit) -> None:
        """Look at another place of the scene, where the camera orbits freely and clicks mean nothing here.

        Until `come_back` the picture is kept small, and fitting, zooming and sliding do nothing.
        """
        self.away = True
        run_script(self._client, f"window.__viserMutable.leavePicture({orbit.script_arguments()});")

    def come_back(self) -> None:
        """Look at the picture again exactly as before; it has to be shown anew."""
        self.away = False
        run_script(self._client, "window.__viserMutable.backToPicture();")

    def world(self, column_px: float, row_px: float, layer: int = 0) -> tuple[float, float, float]:
        """The scene position of a pixel; higher layers are nearer to the eye."""
        return self.plane.world(column_px, row_px, layer)

    @property
    def pixels_per_screen_pixel(self) -> float:
        """Image pixels that a CSS pixel covers now."""
        camera = self._client.camera
        return self.plane.pixels_per_screen_pixel(-float(camera.position[1]), camera.image_height)

    @property
    def window_px(self) -> tuple[float, float, float, float]:
        """The part of the image plane in view: left, top, right, bottom in pixels; may exceed the picture."""
        camera = self._client.camera
        column_px, row_px = self.plane.pixel(camera.position)
        half_height = self.pixels_per_screen_pixel * camera.image_height / 2
        half_width = half_height * camera.aspect
        return column_px - half_width, row_px - half_height, column_px + half_width, row_px + half_height

    def fit(self) -> None:
        """Shows the whole picture; it stays whole when the window changes, until somebody zooms or slides."""
        if self.away:
            return
        camera = self._client.camera
        size = self.plane.size
        across = max(size.width / camera.image_width, size.height / camera.image_height)
        pixels_per_screen_pixel = across * _FIT_MARGIN
        distance = self._distance(pixels_per_screen_pixel)
        self._fitting.append((0.0, -distance, 0.0))
        self._fit_is_on_its_way = True
        with self._client.atomic():
            camera.min_orbit_distance = self._distance(1 / _CLOSEST_PIXEL)
            camera.max_orbit_distance = distance * _FARTHEST_FITS
            self._look_at(*self.plane.middle_px, pixels_per_screen_pixel)

    def is_fitted(self, position: NDArray[np.float64]) -> bool:
        """Hear where the browser's camera is: whether `fit` put it there, lately, or has yet to reach it."""

        def is_there(fitting: tuple[float, float, float]) -> bool:
            return np.allclose(position, fitting, atol=1e-3)

        if self._fitting and is_there(self._fitting[-1]):
            self._fit_is_on_its_way = False
        return self._fit_is_on_its_way or any(map(is_there, self._fitting))

    def zoom(self, factor: float, centre_px: tuple[float, float] | None = None) -> None:
        """Zooms in by a factor (out, below 1) about a (column, row) that stays where it is on the screen."""
        column_px, row_px = self.plane.pixel(self._client.camera.position)
        fixed_column_px, fixed_row_px = (column_px, row_px) if centre_px is None else centre_px
        before = self.pixels_per_screen_pixel
        after = self._limited(before / factor)
        kept = after / before
        self._look_at(
            fixed_column_px + (column_px - fixed_column_px) * kept,
            fixed_row_px + (row_px - fixed_row_px) * kept,
            after,
        )

    def zoom_to(self, column_px: float, row_px: float, pixels_across: float) -> None:
        """Looks at a pixel with that many image pixels across the window."""
        self._look_at(column_px, row_px, self._limited(pixels_across / self._client.camera.image_width))

    def pan(self, columns_px: float, rows_px: float) -> None:
        """Moves the view to the right and down over the picture."""
        column_px, row_px = self.plane.pixel(self._client.camera.position)
        self._look_at(column_px + columns_px, row_px + rows_px, self.pixels_per_screen_pixel)

    def _distance(self, pixels_per_screen_pixel: float) -> float:
        return self.plane.distance(pixels_per_screen_pixel, self._client.camera.image_height)

    def _limited(self, pixels_per_screen_pixel: float) -> float:
        camera = self._client.camera
        distance = self._distance(pixels_per_screen_pixel)
        limited = min(max(distance, camera.min_orbit_distance), camera.max_orbit_distance)
        return self.plane.pixels_per_screen_pixel(limited, camera.image_height)

    def _look_at(self, column_px: float, row_px: float, pixels_per_screen_pixel: float) -> None:
        if self.away:
            return
        column_px = min(max(column_px, -0.5), self.plane.size.width - 0.5)
        row_px = min(max(row_px, -0.5), self.plane.size.height - 0.5)
        x, _, z = self.world(column_px, row_px)
        with self._client.atomic():
            self._client.camera.position = (x, -self._distance(pixels_per_screen_pixel), z)
            self._client.camera.look_at = (x, 0.0, z)
