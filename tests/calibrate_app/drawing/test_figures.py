"""The SVG figures: well formed, and true to the numbers that they show."""

import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from drawing_states import SIZE, document_of, good_document, marks_at, paper_document, shown, state_of
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw_viz.calibrate_app.document.numbers_text import gain_text, interval_text, percent_text
from fcw_viz.calibrate_app.drawing.birds_eye import birds_eye, ground_scale
from fcw_viz.calibrate_app.drawing.drawing import draw
from fcw_viz.calibrate_app.drawing.figures import BAR_SIGMAS, interval_plot, residual_bar
from fcw_viz.calibrate_app.drawing.svg import picture_overlay_svg
from fcw_viz.page.picture.label_layout import Window

SVG = "{http://www.w3.org/2000/svg}"


def words(svg: str) -> str:
    return " | ".join(text.text or "" for text in ElementTree.fromstring(svg).iter(f"{SVG}text"))


@given(
    st.lists(st.floats(3.0, 70.0), min_size=3, max_size=6, unique_by=lambda value: round(value)),
    st.floats(-0.05, 0.3),
    st.floats(500.0, 2500.0),
    st.floats(0.1, 3.0),
    st.booleans(),
)
def test_figures_are_well_formed_and_finite(
    distances_m: list[float], pitch_rad: float, focal_px: float, sigma_px: float, imperial: bool
) -> None:
    camera = GroundPlaneCamera(pitch_rad, focal_px, 359.5, 1.3, 639.5)
    document = document_of(marks_at(distances_m, camera), sigma_px)
    result = state_of(document).shown
    if result is None:
        return
    for svg in (interval_plot(result, imperial), birds_eye(result, document.marks, imperial)):
        ElementTree.fromstring(svg)
        assert not re.search(r"\b(nan|inf)\b", svg)


def test_the_plot_tells_the_interval_at_its_distances() -> None:
    text = words(interval_plot(shown(state_of(good_document())), imperial=False))
    # notes/calibration.md: 5, 10, 20 m at 1 px, 37.9 to 42.6 m without what every lens has
    assert "19.7–20.3" in text
    assert "38.7–41.4" in text
    assert "no upper end" not in text


def test_the_plot_says_where_there_is_no_upper_end() -> None:
    result = shown(state_of(replace(paper_document(), row_sigma_px=8.0)))
    text = words(interval_plot(result, imperial=False))
    match = re.search(r"beyond (\d+) m the interval has no upper end", text)
    assert match is not None
    limit_m, calibration = float(match[1]), result.calibration
    assert math.isfinite(calibration.distance_interval(calibration.row_at(0.95 * limit_m))[1])
    assert math.isinf(calibration.distance_interval(calibration.row_at(1.06 * limit_m))[1])
    assert "open" in text


def test_the_plot_in_feet_has_no_metres() -> None:
    text = words(interval_plot(shown(state_of(paper_document())), imperial=True))
    assert "distance in ft" in text
    assert " m " not in text


@given(
    st.lists(st.tuples(st.floats(0.0, 1279.0), st.floats(380.0, 719.0)), min_size=1, max_size=5),
    st.floats(0.0, 3.0),
)
def test_marks_lie_on_the_ground_where_the_calibration_sees_them(
    pixels: list[tuple[float, float]], offset_m: float
) -> None:
    document = replace(good_document(), from_bumper=True, bumper_offset_m=offset_m)
    result = shown(state_of(document))
    marks = tuple(
        replace(document.marks[0], id=number, column_px=column_px, row_px=row_px)
        for number, (column_px, row_px) in enumerate(pixels, start=1)
    )
    scale = ground_scale(result, marks)
    circles = ElementTree.fromstring(birds_eye(result, marks, imperial=False)).iter(f"{SVG}circle")
    drawn = {circle.get("data-mark"): circle for circle in circles}
    for mark in marks:
        distance_m = result.calibration.distance_at(mark.row_px)
        if distance_m > scale.ahead_m:
            continue
        circle = drawn[str(mark.id)]
        x, y = float(circle.get("cx", "")), float(circle.get("cy", ""))
        # Back from the drawing to the ground, ahead being up and the reference the origin.
        assert scale.ahead_m - y / scale.px_per_m == pytest.approx(distance_m, abs=1e-3)
        lateral_m = result.calibration.lateral_at(mark.column_px, mark.row_px)
        assert (scale.width_px / 2 - x) / scale.px_per_m == pytest.approx(lateral_m, abs=1e-3)


def test_seen_from_above_the_camera_stands_behind_the_bumper() -> None:
    document = replace(good_document(), from_bumper=True, bumper_offset_m=1.6)
    result = shown(state_of(document))
    svg = ElementTree.fromstring(birds_eye(result, document.marks, imperial=False))
    camera = next(circle for circle in svg.iter(f"{SVG}circle") if circle.get("data-name") == "camera")
    scale = ground_scale(result, document.marks)
    assert float(camera.get("cy", "")) == pytest.approx((scale.ahead_m + 1.6) * scale.px_per_m, abs=1e-3)


def test_marks_switched_off_are_hollow_from_above() -> None:
    marks = marks_at((5.0, 10.0, 15.0, 20.0))
    document = document_of((*marks[:3], replace(marks[3], enabled=False)))
    svg = ElementTree.fromstring(birds_eye(shown(state_of(document)), document.marks, imperial=False))
    fills = {circle.get("data-mark"): circle.get("fill") for circle in svg.iter(f"{SVG}circle")}
    assert fills["4"] == "none"
    assert fills["3"] != "none"


@given(st.floats(-20.0, 20.0))
def test_a_residual_bar_is_as_long_as_the_residual_until_it_is_full(sigmas: float) -> None:
    svg = ElementTree.fromstring(residual_bar(sigmas))
    bar = list(svg.iter(f"{SVG}rect"))[1]
    full_width = float(
        list(ElementTree.fromstring(residual_bar(BAR_SIGMAS)).iter(f"{SVG}rect"))[1].get("width", "")
    )
    expected = min(abs(sigmas), BAR_SIGMAS) / BAR_SIGMAS * full_width
    assert float(bar.get("width", "")) == pytest.approx(expected, abs=0.011)
    goes_on = svg.find(f"{SVG}polygon") is not None
    assert goes_on == (abs(sigmas) > BAR_SIGMAS)


def test_the_picture_holds_itself_and_its_rows() -> None:
    state = state_of(good_document())
    window = Window(-0.5, -0.5, SIZE.width - 0.5, SIZE.height - 0.5, 1.28)
    drawing = draw(state, None, 0, window)
    svg = picture_overlay_svg(np.full((SIZE.height, SIZE.width, 3), 90, np.uint8), drawing, 1.28)
    root = ElementTree.fromstring(svg)
    (image,) = root.iter(f"{SVG}image")
    assert image.get("href", "").startswith("data:image/jpeg;base64,")
    # Rows count from the centre of the top-left pixel.
    assert root.get("viewBox") == "-0.5 -0.5 1280 720"
    row_px = shown(state).calibration.row_at(20.0)
    lines = {line.get("points") for line in root.iter(f"{SVG}polyline")}
    assert f"-0.5,{row_px:.1f} 1279.5,{row_px:.1f}" in lines
    assert "20 m\u200219.7–20.3" in words(svg)


@pytest.mark.parametrize(
    ("low_m", "high_m", "imperial", "text"),
    [
        (19.71, 20.32, False, "19.7–20.3"),
        (4.981, 5.019, False, "4.98–5.02"),
        (29.9, 64.1, False, "30–64"),
        (45.2, math.inf, False, "45 and beyond"),
        (-0.3, math.inf, False, "0 and beyond"),
        (math.inf, math.inf, False, "beyond the horizon"),
        (30.48, 33.528, True, "100–110"),
    ],
)
def test_intervals_have_the_digits_that_they_carry(
    low_m: float, high_m: float, imperial: bool, text: str
) -> None:
    assert interval_text(low_m, high_m, imperial) == text


def test_gains_are_said_in_words() -> None:
    assert gain_text(0.08, 0.04) == "would halve the error"
    assert gain_text(0.08, 0.02) == "would cut the error to a quarter"
    assert gain_text(0.09, 0.03) == "would cut the error to a third"
    assert gain_text(0.1, 0.09) == "would cut the error by 10%"
    assert (percent_text(0.0123), percent_text(0.123)) == ("1.2%", "12%")
