"""The drawing over the picture, on the page's surface: what exists is moved, not made anew."""

import threading
from collections.abc import Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.drawing.drawing import Drawing, Measured, draw, fill_style
from fcw_viz.calibrate_app.drawing.pen import Fill, FillKind, Stroke
from fcw_viz.page.picture.label_layout import Area, Label, Point, Window
from fcw_viz.page.picture.lines import (
    OUTLINE_COLOR,
    OUTLINE_CSS_PX,
    THICKNESS_CSS_PX,
    Surface,
    linear_light,
)

FILL_LAYERS: dict[FillKind, int] = {
    FillKind.CORRIDOR: 1,
    FillKind.HORIZON_BAND: 2,
    FillKind.ROW_BAND: 3,
}
OUTLINE_LAYER, LINE_LAYER, LABEL_LAYER = 4, 5, 6
PLANE_PX = 1024.0
"""Any length; a power of two divides without error."""
QUAD_FACES = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)


class PictureOverlay:
    """Rows, horizon, marks and words of one tab, over its picture."""

    def __init__(self, view: Surface, client: viser.ClientHandle) -> None:
        self._view = view
        self._client = client
        self._lock = threading.RLock()
        self._shown: tuple[SessionState, int | None, int | None, bool] | None = None
        self._measured: Measured | None = None
        self._label_areas: tuple[Area, ...] = ()
        self._nodes = _Nodes(view, client.scene)
        view.on_view_change(self._redraw)

    def show(
        self, state: SessionState, selected: int | None, frame: int | None, horizon_grip: bool = False
    ) -> None:
        """Draw one moment of the session.

        Args:
            state: the moment.
            selected: id of the selected mark.
            frame: index of the picture shown; marks of others are drawn faint.
            horizon_grip: whether the horizon can be dragged, so that it shows its grip.
        """
        with self._lock:
            self._shown = (state, selected, frame, horizon_grip)
            self._redraw()

    def measure(self, measured: Measured | None) -> None:
        """Draw the measuring tool's point, or take it away."""
        with self._lock:
            self._measured = measured
            self._redraw()

    @property
    def label_areas(self) -> tuple[Area, ...]:
        """What the words cover now, for others who put words over the picture."""
        return self._label_areas

    def _redraw(self) -> None:
        with self._lock:
            if self._shown is None:
                return
            state, selected, frame, grip = self._shown
            window = Window(*self._view.window_px, self._view.pixels_per_screen_pixel)
            drawing = draw(state, selected, frame, window, True, grip, self._measured)
            self._label_areas = tuple(label.area for label in drawing.labels)
            with self._client.atomic():
                self._nodes.update(drawing)


class _Nodes:
    """The scene nodes: one for each kind of area, one for lines of each thickness, one for each label."""

    def __init__(self, view: Surface, scene: viser.SceneApi) -> None:
        self._view = view
        self._scene = scene
        self._meshes: dict[FillKind, viser.MeshHandle] = {}
        self._lines: dict[tuple[int, bool], viser.LineSegmentsHandle] = {}
        self._labels: list[viser.LabelHandle] = []

    def update(self, drawing: Drawing) -> None:
        """Bring the nodes to the drawing."""
        for kind in FillKind:
            fills = [fill for fill in drawing.fills if fill.kind is kind]
            self._update_fills(kind, fills, drawing.current)
        for strong in (False, True):
            strokes = [stroke for stroke in drawing.strokes if stroke.strong is strong]
            self._update_strokes(strokes, strong)
        self._update_labels(drawing.labels)

    def _update_fills(self, kind: FillKind, fills: Sequence[Fill], current: bool) -> None:
        mesh = self._meshes.get(kind)
        if not fills:
            if mesh is not None:
                mesh.visible = False
            return
        color, opacity = fill_style(kind, current)
        # Translucent nodes are drawn in the order of their own positions, not of their corners.
        position = self._view.world(0.0, 0.0, FILL_LAYERS[kind])
        corners = self._world([corner for fill in fills for corner in fill.corners_px], FILL_LAYERS[kind])
        vertices = (corners - np.array(position)).astype(np.float32)
        faces = (QUAD_FACES + 4 * np.arange(len(fills), dtype=np.uint32)[:, None, None]).reshape(-1, 3)
        if mesh is None:
            self._meshes[kind] = self._scene.add_mesh_simple(
                f"/overlay/{kind.value}",
                vertices,
                faces,
                color=color,
                opacity=opacity,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
                position=position,
            )
            return
        mesh.vertices, mesh.faces, mesh.color = vertices, faces, color
        mesh.position, mesh.visible = position, True

    def _update_strokes(self, strokes: Sequence[Stroke], strong: bool) -> None:
        ends = [
            pair for stroke in strokes for pair in zip(stroke.points_px, stroke.points_px[1:], strict=False)
        ]
        colors = np.array(
            [[linear_light(stroke.color)] * 2 for stroke in strokes for _ in stroke.points_px[1:]],
            dtype=np.uint8,
        )
        for layer in (OUTLINE_LAYER, LINE_LAYER):
            lines = self._lines.get((layer, strong))
            if not ends:
                if lines is not None:
                    lines.visible = False
                continue
            points = self._world([end for pair in ends for end in pair], layer)
            points = points.reshape(-1, 2, 3).astype(np.float32)
            outline = layer == OUTLINE_LAYER
            if lines is None:
                self._lines[layer, strong] = self._scene.add_line_segments(
                    f"/overlay/lines_{layer}_{int(strong)}",
                    points,
                    np.array(OUTLINE_COLOR, dtype=np.uint8) if outline else colors,
                    thickness=THICKNESS_CSS_PX[strong] + (2 * OUTLINE_CSS_PX if outline else 0.0),
                    thickness_units="screen",
                )
                continue
            lines.points = points
            if not outline:
                lines.colors = colors
            lines.visible = True

    def _update_labels(self, labels: Sequence[Label]) -> None:
        for index, label in enumerate(labels):
            position = self._view.world(label.left_px, label.row_px, LABEL_LAYER)
            if index == len(self._labels):
                self._labels.append(
                    self._scene.add_label(
                        f"/overlay/label_{index}", label.text, position=position, anchor="center-left"
                    )
                )
                continue
            handle = self._labels[index]
            handle.text, handle.position, handle.visible = label.text, position, True
        for handle in self._labels[len(labels) :]:
            handle.visible = False

    def _world(self, points_px: Sequence[Point], layer: int) -> NDArray[np.float64]:
        """(N, 3) scene positions; a layer is a plane, so that three of them give all."""
        corner, right, below = (
            np.array(self._view.world(column_px, row_px, layer))
            for column_px, row_px in ((0.0, 0.0), (PLANE_PX, 0.0), (0.0, PLANE_PX))
        )
        axes = np.array([right - corner, below - corner]) / PLANE_PX
        return corner + np.array(points_px) @ axes
