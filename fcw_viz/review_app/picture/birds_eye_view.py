"""The bird's eye of a tab: a few nodes of its scene, far below the picture, that follow the frames."""

import math

import numpy as np
import viser

from fcw.logs.overlay import OTHER_TRACK_COLOR, OWN_CAR_SIZE_M, ROW_COLOR
from fcw.logs.records import DriveHeader, FrameResult
from fcw_viz.page.picture.away import Orbit
from fcw_viz.page.picture.view import PictureView
from fcw_viz.review_app.picture import birds_eye
from fcw_viz.review_app.picture.birds_eye import Ground, GroundVehicle

BELOW = 1000.0
"""Scene units under the picture: the ground is never seen from there, nor the picture from here."""
AHEAD_WXYZ = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""Vehicle axes in the scene's, which has y away from the eye."""
MOST_VEHICLES = 16
"""Boxes of the pool; where more are followed the nearest are shown."""
ORBIT = Orbit(
    position=(0.0, -birds_eye.EYE_BEHIND_M, 19.0 - BELOW),
    look_at=(0.0, 21.0, -BELOW),
    distances=(8.0, 300.0),
    depths=(1.0, 700.0),
    lowest_rad=math.radians(88),
)
"""From behind and above; never from under the road."""
OWN_COLOR = (70, 110, 160)
LINE_PX = 1.5
PATH_OPACITY = 0.3
LINE_ABOVE_M = 0.02
"""Lines lie this high over the path's ground, that both are seen."""
ARROW_M = (0.12, 0.4, 1.1)
"""Radius of the shaft, radius and length of the head."""
ROOT = "/birds_eye"
PANEL_TOP = -1.0
"""The picture's place: over all other parts of the panel."""


class BirdsEye:
    """What one tab sees from above, in that tab's thread; nothing is sent while it is not looked at."""

    def __init__(self, client: viser.ClientHandle, view: PictureView) -> None:
        """Nothing is seen before `load` and `toggle`."""
        self._client = client
        self._view = view
        self._header: DriveHeader | None = None
        self._nodes: _Nodes | None = None
        self._small = client.gui.add_image(np.zeros((9, 16, 3), np.uint8), visible=False, order=PANEL_TOP)

    @property
    def active(self) -> bool:
        """Whether it is looked at instead of the picture."""
        return self._view.away

    def load(self, header: DriveHeader) -> None:
        """Show another drive from now on."""
        self._header = header
        if self._nodes is not None:
            self._nodes.remove()
            self._nodes = None

    def toggle(self) -> None:
        """Go there, or come back; then the frame has to be shown anew."""
        if self.active:
            self.come_back()
        elif self._header is not None:
            if self._nodes is None:
                self._nodes = _Nodes(self._client.scene, self._header.imperial)
            with self._client.atomic():
                self._nodes.root.visible = self._small.visible = True
                self._view.leave(ORBIT)

    def come_back(self) -> None:
        """Look at the picture again exactly as before; it has to be shown anew."""
        if self._nodes is None or not self.active:
            return
        with self._client.atomic():
            self._view.come_back()
            self._nodes.root.visible = self._small.visible = False

    def show(self, result: FrameResult, yaw_rate_radps: float | None = None) -> None:
        """Follow to a frame, where it is looked at; its picture is that of the view.

        Args:
            result: of the frame.
            yaw_rate_radps: how fast we turn, where that is known.
        """
        if not self.active or self._header is None or self._nodes is None:
            return
        seen = birds_eye.ground(result, self._header.calibration, self._header.imperial, yaw_rate_radps)
        with self._client.atomic():
            self._small._format, self._small._data = "jpeg", self._view.sent
            self._nodes.show(seen)


class _Nodes:
    """The nodes of the scene: made once, then moved."""

    def __init__(self, scene: viser.SceneApi, imperial: bool) -> None:
        self._scene = scene
        self.root = scene.add_frame(
            ROOT, show_axes=False, wxyz=AHEAD_WXYZ, position=(0.0, 0.0, -BELOW), visible=False
        )
        length_m, _, height_m = OWN_CAR_SIZE_M
        scene.add_box(
            f"{ROOT}/own",
            OWN_COLOR,
            OWN_CAR_SIZE_M,
            position=(-length_m / 2, 0.0, height_m / 2),
            cast_shadow=False,
            receive_shadow=False,
        )
        rings = [birds_eye.ring(distance_m) for distance_m in birds_eye.RING_DISTANCES_M]
        scene.add_line_segments(
            f"{ROOT}/rings",
            np.concatenate([birds_eye.segments(ring) for ring in rings]),
            ROW_COLOR,
            thickness=LINE_PX,
            thickness_units="screen",
        )
        for distance_m in birds_eye.RING_DISTANCES_M:
            text, position = birds_eye.ring_label(distance_m, imperial)
            scene.add_label(f"{ROOT}/ring {distance_m:g}", text, position=position, anchor="center-left")
        left, right = birds_eye.path_edges(0.0)
        self._path = scene.add_mesh_simple(
            f"{ROOT}/path",
            np.concatenate([left, right]),
            birds_eye.strip_faces(birds_eye.PATH_POINTS),
            color=OWN_COLOR,
            opacity=PATH_OPACITY,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )
        self._path_at = np.concatenate([left, right])
        self._arrows = scene.add_arrows(
            f"{ROOT}/arrows",
            np.zeros((1, 2, 3)),
            np.zeros((1, 3), np.uint8),
            shaft_radius=ARROW_M[0],
            head_radius=ARROW_M[1],
            head_length=ARROW_M[2],
            visible=False,
        )
        self._intervals = scene.add_line_segments(
            f"{ROOT}/intervals",
            np.zeros((1, 2, 3)),
            np.zeros((1, 2, 3), np.uint8),
            thickness=2 * LINE_PX,
            thickness_units="screen",
            visible=False,
        )
        self._speed = scene.add_label(
            f"{ROOT}/speed",
            "",
            position=(-length_m / 2, 0.0, height_m),
            anchor="bottom-center",
            visible=False,
        )
        self._vehicles: list[_VehicleNode] = []

    def remove(self) -> None:
        """Take all of it out of the scene."""
        self.root.remove()

    def show(self, seen: Ground) -> None:
        """Move all that moves; what stays as it is is not sent."""
        shown = seen.vehicles[:MOST_VEHICLES]
        while len(self._vehicles) < len(shown):
            self._vehicles.append(_VehicleNode(self._scene, f"{ROOT}/vehicle {len(self._vehicles)}"))
        for node, vehicle in zip(self._vehicles, shown, strict=False):
            node.show(vehicle)
        for node in self._vehicles[len(shown) :]:
            node.hide()
        points, colors = birds_eye.arrows(shown)
        self._arrows.visible = len(points) > 0
        if len(points):
            self._arrows.points, self._arrows.colors = points.astype(np.float32), colors
        self._intervals.visible = len(shown) > 0
        if shown:
            ends = np.array([vehicle.interval_m for vehicle in shown], np.float32)
            ends[..., 2] = LINE_ABOVE_M
            of_both_ends = np.repeat(np.array([v.color for v in shown], np.uint8)[:, None], 2, axis=1)
            self._intervals.points, self._intervals.colors = ends, of_both_ends
        path = np.concatenate([seen.path_left_m, seen.path_right_m])
        if not np.array_equal(path, self._path_at):
            self._path_at = path
            self._path.vertices = path.astype(np.float32)
        if self._speed.text != seen.own_speed:
            self._speed.visible = bool(seen.own_speed)
            self._speed.text = seen.own_speed
        if self._path.color != seen.path_color:
            self._path.color = seen.path_color


class _VehicleNode:
    """One box of the pool with its label."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._box = scene.add_box(name, OTHER_TRACK_COLOR, cast_shadow=False, receive_shadow=False)
        # Beside the box, not under it: a node's children are drawn in its axes, and labels need none.
        self._label = scene.add_label(
            f"{name} label", "", anchor="bottom-center", depth_test=False, visible=False
        )
        self._shown: GroundVehicle | None = None

    def show(self, vehicle: GroundVehicle) -> None:
        """Stand for a vehicle."""
        before, self._shown = self._shown, vehicle
        if before is None:
            self._box.visible = True
        if before is None or before.size_m != vehicle.size_m:
            self._box.dimensions = vehicle.size_m
        if before is None or before.color != vehicle.color:
            self._box.color = vehicle.color
        if before is None or before.label != vehicle.label:
            self._label.visible = bool(vehicle.label)
            self._label.text = vehicle.label or self._label.text
        if before is None or before.centre_m != vehicle.centre_m:
            self._box.position = vehicle.centre_m
            self._label.position = vehicle.label_at_m

    def hide(self) -> None:
        """Stand for none."""
        if self._shown is not None:
            self._box.visible = self._label.visible = False
            self._shown = None
