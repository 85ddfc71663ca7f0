"""What is drawn over the picture, and how it reaches the page's scene."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import viser
from drawing_states import SIZE, document_of, good_document, marks_at, paper_document, shown, state_of
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Gaussian
from fcw.logs.overlay import ROW_COLOR
from fcw_viz.calibrate_app.document.document import Belief, Document, Line
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.drawing.drawing import (
    HORIZON_COLOR,
    STALE_COLOR,
    STALE_WORDS,
    Drawing,
    Measured,
    draw,
    visible_rows,
)
from fcw_viz.calibrate_app.drawing.overlay import LINE_LAYER, PictureOverlay
from fcw_viz.calibrate_app.drawing.pen import MAXIMUM_DASHES, FillKind
from fcw_viz.page.picture.label_layout import LabelWish, Window, lay_out_labels

WHOLE = Window(-0.5, -0.5, SIZE.width - 0.5, SIZE.height - 0.5, 1.0)


@st.composite
def documents(draw_from: st.DrawFn) -> Document:
    """Clicks of any quality, near and far, some switched off, with and without a horizon and lane lines."""
    distances_m = draw_from(
        st.lists(st.floats(3.0, 60.0), min_size=3, max_size=7, unique_by=lambda value: round(value))
    )
    errors_px = draw_from(st.lists(st.floats(-3.0, 3.0), min_size=7, max_size=7))
    off = draw_from(st.sets(st.integers(3, 6)))
    marks = tuple(
        replace(mark, enabled=index not in off, frame=index % 2)
        for index, mark in enumerate(marks_at(distances_m, errors_px=errors_px))
    )
    ends = st.tuples(st.floats(0.0, 1279.0), st.floats(0.0, 719.0))
    lines = st.builds(Line, ends, ends)
    horizon = draw_from(st.none() | st.builds(Belief, st.builds(Gaussian, st.floats(200, 450), st.just(2.0))))
    return replace(
        document_of(marks, draw_from(st.floats(0.1, 3.0))),
        horizon=horizon,
        lane_lines=draw_from(st.just((None, None)) | st.tuples(lines, lines)),
        imperial=draw_from(st.booleans()),
    )


@st.composite
def windows(draw_from: st.DrawFn) -> Window:
    """Any zoom from twice too far out to 64 screen pixels for one of the picture, anywhere."""
    scale = math.exp(draw_from(st.floats(math.log(1 / 64), math.log(3.0))))
    column_px, row_px = draw_from(st.floats(0, 1279)), draw_from(st.floats(0, 719))
    half_width_px, half_height_px = 500 * scale, 400 * scale
    return Window(
        column_px - half_width_px,
        row_px - half_height_px,
        column_px + half_width_px,
        row_px + half_height_px,
        scale,
    )


@given(documents(), windows(), st.booleans())
def test_labels_never_overlap_and_are_never_cut_at_any_calibration_and_zoom(
    document: Document, window: Window, grip: bool
) -> None:
    drawing = draw(state_of(document), 2, 0, window, True, grip, Measured(640, 400, "8.1 m  8.0–8.2"))
    for first, second in combinations(drawing.labels, 2):
        assert not first.area.overlaps(second.area), (first.text, second.text)
    for label in drawing.labels:
        assert window.left_px <= label.area.left_px
        assert label.area.right_px <= window.right_px
        assert window.top_px <= label.area.top_px
        assert label.area.bottom_px <= window.bottom_px


@given(documents(), windows())
def test_what_is_drawn_is_finite_and_little_at_any_zoom(document: Document, window: Window) -> None:
    drawing = draw(state_of(document), None, None, window)
    points = [point for stroke in drawing.strokes for point in stroke.points_px]
    points += [corner for fill in drawing.fills for corner in fill.corners_px]
    assert np.isfinite(np.array(points)).all()
    assert len(drawing.strokes) < 8 * MAXIMUM_DASHES


@given(documents(), st.sampled_from((0.3, 1.0, 2.5)))
def test_rows_are_drawn_where_the_calibration_sees_their_distances(document: Document, scale: float) -> None:
    state = state_of(document)
    if state.shown is None or state.shown.calibration.straightening is not None:
        return  # rows of a turned camera lie aslant: test_warped
    calibration = state.shown.calibration
    drawing = draw(state, None, None, replace(WHOLE, pixels_per_screen_pixel=scale))
    across = {
        stroke.points_px[0][1]
        for stroke in drawing.strokes
        if stroke.color == ROW_COLOR and stroke.points_px[-1][0] - stroke.points_px[0][0] == SIZE.width
    }
    expected = [calibration.row_at(row.distance_m) for row in visible_rows(state.shown.rows, SIZE, scale)]
    assert sorted(across) == pytest.approx(sorted(expected), abs=1e-9)


def test_every_label_of_a_row_tells_its_distance_and_its_interval() -> None:
    texts = [label.text for label in draw(state_of(good_document()), None, 0, WHOLE).labels]
    # notes/calibration.md: 5, 10, 20 m at 1 px, 37.9 to 42.6 m without what every lens has
    assert "20 m  19.7–20.3" in texts
    assert "10 m  9.89–10.11" in texts
    assert any(text.startswith("40 m  38.7–41.4") for text in texts)
    imperial = replace(good_document(), imperial=True)
    assert all(" m " not in label.text for label in draw(state_of(imperial), None, 0, WHOLE).labels)


def test_zoomed_in_no_row_of_the_window_goes_without_its_label() -> None:
    state = state_of(good_document())
    far = Window(560, 320, 720, 400, 160 / 1400)
    texts = " ".join(label.text for label in draw(state, None, 0, far).labels)
    assert all(f"{distance_m} m  " in texts for distance_m in (20, 30, 40, 50, 80))


def test_bands_that_overlap_stand_side_by_side() -> None:
    state = state_of(replace(good_document((4.0, 5.0, 7.0)), row_sigma_px=4.0))
    bands = [fill for fill in draw(state, None, 0, WHOLE).fills if fill.kind is FillKind.ROW_BAND]
    rectangles = [(*fill.corners_px[0], *fill.corners_px[2]) for fill in bands]
    assert len(rectangles) >= 8
    for (left, top, right, bottom), (left2, top2, right2, bottom2) in combinations(rectangles, 2):
        assert right <= left2 or right2 <= left or bottom <= top2 or bottom2 <= top
    narrow = [right - left for left, _, right, _ in rectangles if right - left < SIZE.width / 2]
    assert len(narrow) >= 3, "30, 40, 50 and 80 m cannot be told apart from 4, 5, 7 m"


def test_a_band_is_one_sigma_of_its_row() -> None:
    state = state_of(good_document())
    tops = {
        (fill.corners_px[0][1], fill.corners_px[2][1])
        for fill in draw(state, None, 0, WHOLE).fills
        if fill.kind is FillKind.ROW_BAND
    }
    at_10 = next(row for row in shown(state).rows if row.distance_m == 10.0)
    band = (at_10.row_px - at_10.row_sigma_px, at_10.row_px + at_10.row_sigma_px)
    assert any((top, bottom) == pytest.approx(band, abs=1e-6) for top, bottom in tops)


def test_a_result_that_is_not_current_is_grey_and_says_so() -> None:
    last_good = shown(state_of(good_document()))
    state = state_of(good_document((4.0, 4.0, 7.0)), last_good)
    assert not state.current
    drawing = draw(state, None, 0, WHOLE)
    assert any(label.text == STALE_WORDS for label in drawing.labels)
    assert not {stroke.color for stroke in drawing.strokes} & {ROW_COLOR, HORIZON_COLOR}
    assert STALE_COLOR in {stroke.color for stroke in drawing.strokes}
    assert not any("one more point" in label.text for label in drawing.labels)
    current = draw(state_of(good_document()), None, 0, WHOLE)
    assert STALE_COLOR not in {stroke.color for stroke in current.strokes}


def test_words_on_a_stale_result_find_a_corner_that_is_free() -> None:
    last_good = shown(state_of(good_document()))
    ends = (Line((70.0, 700.0), (400.0, 420.0)), Line((1200.0, 700.0), (760.0, 420.0)))
    document = replace(good_document((4.0, 4.0, 7.0)), lane_lines=ends, lane_lines_enabled=False)
    state = state_of(document, last_good)
    assert not state.current
    drawing = draw(state, None, 0, WHOLE, handles=True)
    assert any(label.text == STALE_WORDS for label in drawing.labels)


def test_a_residual_leads_from_the_mark_to_the_row_of_the_solution() -> None:
    marks = marks_at((5.0, 10.0, 15.0, 20.0), errors_px=(0.0, 6.0, 0.0, -4.0))
    state = state_of(document_of(marks))
    calibration = shown(state).calibration
    lines = [stroke.points_px for stroke in draw(state, None, 0, WHOLE).strokes if stroke.strong]
    for mark in marks:
        there = (mark.column_px, calibration.row_at(mark.distance_m or math.nan))
        assert any(
            line[0] == (mark.column_px, mark.row_px) and line[1] == pytest.approx(there) for line in lines
        )


def test_the_next_click_is_shown_with_what_it_gains() -> None:
    texts = [label.text for label in draw(state_of(good_document()), None, 0, WHOLE).labels]
    words = "one more point here, at about 40 m, would cut the error by "
    assert any(text.startswith(words) for text in texts)


def test_lines_that_meet_nowhere_are_drawn_without_a_crossing() -> None:
    lines = (Line((300.0, 700.0), (500.0, 400.0)), Line((900.0, 700.0), (1100.0, 400.0)))
    drawing = draw(state_of(replace(good_document(), lane_lines=lines)), None, 0, WHOLE)
    assert not any("lane lines" in label.text for label in drawing.labels)


@given(st.lists(st.text("0123456789 m", min_size=1, max_size=12), max_size=6))
def test_the_more_important_words_get_their_first_place(texts: list[str]) -> None:
    wishes = [LabelWish(text, ((100.0, 100.0), (100.0, 300.0))) for text in texts]
    labels = lay_out_labels(wishes, WHOLE)
    assert [label.text for label in labels] == texts[:2]
    assert [label.row_px for label in labels] == [100.0, 300.0][: len(texts)]


class FakeView:
    """A view on a plane as the page has it."""

    def __init__(self) -> None:
        self.scale = 10 / SIZE.width
        self.window_px = (-0.5, -0.5, SIZE.width - 0.5, SIZE.height - 0.5)
        self.pixels_per_screen_pixel = 1.0
        self.changed: list[Callable[[], None]] = []

    def world(self, column_px: float, row_px: float, layer: int = 0) -> tuple[float, float, float]:
        x = (column_px + 0.5 - SIZE.width / 2) * self.scale
        return x, -layer * 2e-5, (SIZE.height / 2 - row_px - 0.5) * self.scale

    def on_view_change(self, callback: Callable[[], None]) -> None:
        self.changed.append(callback)


class FakeScene:
    """Keeps what was added to the scene."""

    def __init__(self) -> None:
        self.nodes: dict[str, SimpleNamespace] = {}

    def _add(self, name: str, **values: Any) -> SimpleNamespace:
        assert name not in self.nodes, "made anew instead of moved"
        self.nodes[name] = SimpleNamespace(**{"visible": True, **values})
        return self.nodes[name]

    def add_mesh_simple(self, name: str, vertices: Any, faces: Any, **values: Any) -> SimpleNamespace:
        return self._add(name, vertices=vertices, faces=faces, **values)

    def add_line_segments(self, name: str, points: Any, colors: Any, **values: Any) -> SimpleNamespace:
        assert values["thickness_units"] == "screen"
        return self._add(name, points=points, colors=colors, **values)

    def add_label(self, name: str, text: str, **values: Any) -> SimpleNamespace:
        return self._add(name, text=text, **values)

    def labels(self) -> list[str]:
        return [node.text for node in self.nodes.values() if hasattr(node, "text") and node.visible]


class FakeClient:
    """A tab without a browser."""

    def __init__(self) -> None:
        self.scene = FakeScene()

    @contextmanager
    def atomic(self) -> Iterator[None]:
        yield


@pytest.fixture
def page() -> tuple[PictureOverlay, FakeView, FakeScene]:
    view, client = FakeView(), FakeClient()
    return PictureOverlay(view, cast(viser.ClientHandle, client)), view, client.scene


def rows_of_lines(view: FakeView, scene: FakeScene, strong: bool = False) -> np.ndarray:
    """Picture rows of the ends of all lines in the scene."""
    points = scene.nodes[f"/overlay/lines_{LINE_LAYER}_{int(strong)}"].points
    return SIZE.height / 2 - 0.5 - points[..., 2] / view.scale


def test_the_rows_are_in_the_scene_at_the_calibrations_rows(
    page: tuple[PictureOverlay, FakeView, FakeScene],
) -> None:
    overlay, view, scene = page
    state = state_of(good_document())
    overlay.show(state, None, 0)
    for row in visible_rows(shown(state).rows, SIZE, 1.0):
        expected_px = shown(state).calibration.row_at(row.distance_m)
        # The scene's numbers are single precision: 1e-4 px of a picture 1280 wide.
        assert np.abs(rows_of_lines(view, scene) - expected_px).min() < 1e-4


def test_a_drag_moves_what_exists_and_what_vanishes_is_hidden(
    page: tuple[PictureOverlay, FakeView, FakeScene],
) -> None:
    overlay, _, scene = page
    dragged = [marks_at((5.0, 10.0, 20.0), errors_px=(0.0, 0.0, 0.1 * step)) for step in range(20)]
    overlay.show(state_of(document_of(dragged[0])), 3, 0)
    before = set(scene.nodes)
    for marks in dragged:
        overlay.show(state_of(document_of(marks)), 3, 0)
        lines = scene.nodes[f"/overlay/lines_{LINE_LAYER}_0"]
        assert lines.points.shape[:2] == lines.colors.shape[:2]
    assert {name for name in scene.nodes if not name.startswith("/overlay/label")} == {
        name for name in before if not name.startswith("/overlay/label")
    }
    empty: SessionState = state_of(Document(SIZE))
    overlay.show(empty, None, 0)
    assert not any(node.visible for node in scene.nodes.values())
    overlay.show(state_of(paper_document()), None, 0)
    assert any(text.startswith("10 m") for text in scene.labels())


def test_labels_are_thinned_anew_when_the_view_changes(
    page: tuple[PictureOverlay, FakeView, FakeScene],
) -> None:
    overlay, view, scene = page
    overlay.show(state_of(good_document()), None, 0)
    at_fit = set(scene.labels())
    view.pixels_per_screen_pixel = 5.0
    for callback in view.changed:
        callback()
    assert len(scene.labels()) < len(at_fit)


def test_the_measured_point_comes_and_goes(page: tuple[PictureOverlay, FakeView, FakeScene]) -> None:
    overlay, _, scene = page
    overlay.show(state_of(good_document()), None, 0)
    overlay.measure(Measured(300.0, 500.0, "9 m  8.9–9.1"))
    assert "9 m  8.9–9.1" in scene.labels()
    overlay.measure(None)
    assert "9 m  8.9–9.1" not in scene.labels()


def test_nothing_is_drawn_before_anything_was_said() -> None:
    assert draw(state_of(Document(SIZE)), None, 0, WHOLE) == Drawing(False, (), (), ())
