"""A part of the picture that is taken hold of anywhere: dragged there, the picture stays."""

import numpy as np
import viser

from fcw.box import Box
from fcw_viz.page.picture.handle import HandleSurface, OnDrag

BEHIND_LAYER = -2
"""Behind the picture and behind the handles, which are met first; it is met all the same."""


class Area:
    """A box of the picture that can be dragged; made by `PictureView.add_area`."""

    def __init__(self, view: HandleSurface, scene: viser.SceneApi, name: str, on_drag: OnDrag) -> None:
        self._view, self._on_drag = view, on_drag
        self._box: Box | None = None
        self._dragged_to: tuple[float, float] | None = None
        self._target = scene.add_mesh_simple(
            f"/areas/{name}",
            np.zeros((4, 3), np.float32),
            np.array([[0, 1, 2], [0, 2, 3]]),
            opacity=0.0,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._target.on_drag("left")(self._dragged)

    def show(self, box: Box | None) -> None:
        """Put it over a box; None for nowhere."""
        if box == self._box:
            return
        self._box = box
        self._target.visible = box is not None
        if box is not None:
            world, sides = self._view.plane.world, (box.x, box.right)
            left, right = (world(column, box.y, BEHIND_LAYER) for column in sides)
            low_left, low_right = (world(column, box.bottom, BEHIND_LAYER) for column in sides)
            self._target.vertices = np.array([left, right, low_right, low_left], np.float32)

    async def _dragged(self, event: viser.SceneNodeDragEvent[viser.MeshHandle]) -> None:
        eye = event.client.camera.position
        # viser's start lies half a screen pixel beside the mouse: nothing for what is only moved.
        position = event.start_position if event.phase == "start" else event.end_position
        at_px = self._view.plane.pixel_under(eye, np.array(position) - eye)
        if event.phase != "update":
            self._dragged_to = None
            self._view.run_in_order(self._on_drag, event.phase, *at_px)
            return
        waits = self._dragged_to is not None
        self._dragged_to = at_px
        if not waits:
            self._view.run_in_order(self._catch_up)

    def _catch_up(self) -> None:
        at_px, self._dragged_to = self._dragged_to, None
        if at_px is not None:
            self._on_drag("update", *at_px)
