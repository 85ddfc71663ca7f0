"""The report of a calibration: one HTML page with everything in it, which a browser prints to PDF."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import date
from html import escape
from pathlib import Path
from shlex import quote

import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.file import calibration_text
from fcw.errors import UserError
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.numbers_text import (
    in_units,
    interval_text,
    percent_text,
    row_distance_text,
    typed_text,
    unit_name,
)
from fcw_viz.calibrate_app.document.solution import EFFECT_DISTANCE_M
from fcw_viz.calibrate_app.document.state import Result, SessionState
from fcw_viz.calibrate_app.drawing.birds_eye import birds_eye
from fcw_viz.calibrate_app.drawing.drawing import draw
from fcw_viz.calibrate_app.drawing.figures import interval_plot, residual_bar
from fcw_viz.calibrate_app.drawing.svg import picture_overlay_svg
from fcw_viz.page.picture.label_layout import Window

PICTURE_WIDTH_CSS_PX = 1000.0
"""Width of the page, and so of the picture in it."""
STYLE = Path(__file__).with_suffix(".css")


def report_html(
    state: SessionState,
    image_bgr: NDArray[np.uint8],
    frame: int,
    source: str,
    made_on: date,
    versions: Mapping[str, str],
) -> str:
    """The page's text.

    Args:
        state: the moment to report.
        image_bgr: (height, width, 3), the picture to show with the rows on it.
        frame: its index in the source.
        source: path of the source, as `fcw run` takes it.
        made_on: today.
        versions: of the program and its libraries, by name.

    Raises:
        UserError: what was said determines no camera.
    """
    result = state.solution.result
    if result is None:
        raise UserError(f"no report yet: {state.solution.hint}")
    document, calibration = state.document, result.calibration
    scale = document.image_size.width / PICTURE_WIDTH_CSS_PX
    size = document.image_size
    window = Window(-0.5, -0.5, size.width - 0.5, size.height - 0.5, scale)
    picture = picture_overlay_svg(image_bgr, draw(state, None, frame, window), scale)
    title = f"Camera calibration of {Path(source).name}"
    body = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="dim">{made_on.isoformat()}, pictures of {size}, picture {frame + 1} shown</p>',
        f'<p class="quality">{escape(result.quality)}</p>',
        *_warnings(state),
        picture,
        "<h2>Distances</h2>",
        f'<div class="columns"><div>{_rows_table(result, document.imperial)}'
        f"{_reading(calibration, document.imperial)}</div>"
        f"<div>{interval_plot(result, document.imperial)}</div></div>",
        "<h2>Points</h2>",
        _points_table(document, result),
        *_exact_words(result),
        "<h2>The ground from above, and the camera</h2>",
        f'<div class="columns"><div>{birds_eye(result, document.marks, document.imperial)}</div>'
        f"<div>{_camera_table(state, result)}{_priors(state)}</div></div>",
        "<h2>How to use it</h2>",
        *_use(state, source),
        f"<pre>{escape(calibration_text(calibration))}</pre>",
        f"<footer>{escape(', '.join(f'{name} {number}' for name, number in versions.items()))}</footer>",
    ]
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        # Without an icon of its own the browser would ask a server for one.
        f'<link rel="icon" href="data:,"><style>{STYLE.read_text(encoding="utf-8")}</style></head>'
        f"<body>{''.join(body)}</body></html>\n"
    )


def _warnings(state: SessionState) -> Iterator[str]:
    if state.solution.height_assumed:
        yield _warning(
            "The camera height was not given. It is assumed here, and the intervals allow for that."
        )
    for trouble in state.solution.troubles:
        yield _warning(trouble.text)


def _warning(text: str) -> str:
    return f'<p class="warning">{escape(text)}</p>'


def _rows_table(result: Result, imperial: bool) -> str:
    def cells(distance_m: float, row_px: float, low_m: float, high_m: float) -> list[str]:
        bounded = math.isfinite(high_m)
        half = percent_text((high_m - low_m) / 2 / distance_m) if bounded else "no upper end"
        interval = interval_text(low_m, high_m, imperial, " to ")
        return [row_distance_text(distance_m, imperial), f"{row_px:.2f}", interval, half]

    rows = [cells(row.distance_m, row.row_px, row.low_m, row.high_m) for row in result.rows]
    heads = ("distance", "row", f"interval, {unit_name(imperial)}", "±")
    return _table(heads, rows)


def _reading(calibration: Calibration, imperial: bool) -> str:
    offset_m = calibration.reference_offset_m
    ahead = f"{in_units(offset_m, imperial):.2f} {unit_name(imperial)} ahead of the camera"
    reference = f"the reference (the front bumper), {ahead}" if offset_m else "the camera"
    return (
        f'<p class="dim">Along the road, from {reference}. With this click error, the true distance lies '
        "within the interval in 68 of 100 calibrations.</p>"
    )


def _points_table(document: Document, result: Result) -> str:
    imperial, unit = document.imperial, unit_name(document.imperial)
    rows, classes = [], []
    for mark in document.marks:
        distance = "not given" if mark.distance_m is None else typed_text(mark.distance_m, imperial)
        residual = result.residuals.get(mark.id)
        if residual is None:
            errors = ["", "", "not used"]
        else:
            metres = in_units(residual.distance_m, imperial)
            errors = [
                _signed(residual.row_px),
                _signed(metres) if math.isfinite(metres) else "beyond the horizon",
                "" if result.exact else residual_bar(residual.row_px / document.row_sigma_px),
            ]
        picture = "" if mark.frame is None else str(mark.frame + 1)
        rows.append([mark.name, distance, f"{mark.column_px:.2f}", f"{mark.row_px:.2f}", *errors, picture])
        classes.append("" if residual else "off")
    heads = ("point", "distance", "column", "row", "residual, px", f"residual, {unit}", "", "picture")
    return _table(heads, rows, classes)


def _signed(value: float) -> str:
    """With its sign, except for what is zero to these digits."""
    text = f"{value:+.2f}"
    return "0.00" if float(text) == 0 else text


def _exact_words(result: Result) -> Iterator[str]:
    if result.exact:
        yield (
            '<p class="dim">Three facts, whatever they are, always fit almost exactly, so small residuals '
            "say nothing here. A fourth point would show errors.</p>"
        )


def _camera_table(state: SessionState, result: Result) -> str:
    calibration, sigmas, document = result.calibration, result.sigmas, state.document
    camera, turned = calibration.camera, calibration.orientation
    field_of_view_deg = math.degrees(calibration.field_of_view_rad)
    # d(fov)/d(f) of fov = 2 atan(width / 2 f)
    width_px = document.image_size.width
    by_focal = width_px / (camera.focal_y_px**2 + (width_px / 2) ** 2)

    def length(metres: float) -> str:
        return f"{in_units(metres, document.imperial):.3f} {unit_name(document.imperial)}"

    assumed = " (assumed)" if state.solution.height_assumed else ""
    rows = [
        [
            "pitch, down",
            f"{math.degrees(camera.pitch_rad):.3f} ± {math.degrees(sigmas.pitch_rad):.3f}°",
        ],
        [
            "yaw, left",
            f"{math.degrees(turned.yaw_rad):.2f} ± {math.degrees(turned.yaw_sigma_rad):.2f}°",
        ],
        [
            "roll, right",
            f"{math.degrees(turned.roll_rad):.2f} ± {math.degrees(turned.roll_sigma_rad):.2f}°",
        ],
        ["focal length", f"{camera.focal_y_px:.2f} ± {sigmas.focal_y_px:.2f} px"],
        [
            "horizontal field of view",
            f"{field_of_view_deg:.2f} ± {math.degrees(by_focal * sigmas.focal_y_px):.2f}°",
        ],
        ["principal row", f"{camera.principal_row_px:.2f} ± {sigmas.principal_row_px:.2f}"],
        ["horizon row", f"{camera.horizon_row_px:.2f} ± {sigmas.horizon_row_px:.2f}"],
        ["height above the road", f"{length(camera.height_m)}{assumed}"],
        ["reference ahead of the camera", length(calibration.reference_offset_m)],
        ["click error", f"{calibration.row_sigma_px:g} px"],
    ]
    return (
        f"{_table(('camera', ''), rows)}"
        '<p class="dim">Pitch, focal length and principal row trade off against each other: each alone may '
        "be known poorly while every distance is known well. Judge by the distances.</p>"
    )


def _priors(state: SessionState) -> str:
    document = state.document
    facts: list[tuple[str, str, Gaussian, bool, float, str]] = []
    for name, field, belief, unit, unit_text in (
        ("field of view", "field_of_view", document.field_of_view, math.degrees(1), "°"),
        ("principal row", "principal_row", document.principal_row, 1.0, ""),
        ("horizon as set, row", "horizon", document.horizon, 1.0, ""),
    ):
        if belief is not None:
            facts.append((name, field, belief.prior, belief.enabled, unit, unit_text))
    if state.solution.lane_horizon is not None:
        lanes = state.solution.lane_horizon
        facts.append(("lane lines meet at row", "lane_lines", lanes, document.lane_lines_enabled, 1.0, ""))
    if not facts:
        return '<p class="dim">Only the points were used.</p>'
    rows = []
    for name, field, prior, enabled, unit, unit_text in facts:
        effect = state.solution.effects.get(field)
        words = "" if effect is None else f"{_error(effect.error_without)} → {_error(effect.error_with)}"
        value = f"{prior.value * unit:.1f} ± {prior.sigma * unit:.1f}{unit_text}"
        rows.append([name, value, words if enabled else f"{words} (off)"])
    at = row_distance_text(EFFECT_DISTANCE_M, document.imperial)
    return _table(("known apart from the points", "", f"error at {at}"), rows)


def _error(relative: float) -> str:
    return percent_text(relative) if math.isfinite(relative) else "open"


def _use(state: SessionState, source: str) -> Iterator[str]:
    name, source = escape(quote(state.save_path.name)), escape(quote(source))
    yield (
        f"<p><code>fcw run {source}</code> finds the calibration where it is saved by default, "
        f"beside the source as <code>{name}</code>; for other drives of the same camera, "
        f"<code>fcw run DRIVE --calibration {name}</code>. It holds until the camera is moved.</p>"
    )
    rows = [
        [f"<code>{name}</code>", "everything: camera, points, uncertainty and all other inputs (below)"],
        ["ROS camera_info", "the lens only; no height, pitch or uncertainty"],
        ["Kalibr camchain", "the same for Kalibr"],
    ]
    body = "".join(f'<tr><td>{head}</td><td class="words">{words}</td></tr>' for head, words in rows)
    yield f"<table>{body}</table>"
    yield f"<p>This is <code>{name}</code> with all digits. Saved as a file, it is the calibration:</p>"


def _table(heads: Iterable[str], rows: Sequence[Sequence[str]], classes: Sequence[str] = ()) -> str:
    """A table; cells that begin with markup are taken as they are."""
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    body = ""
    for index, row in enumerate(rows):
        cells = "".join(f"<td>{cell if cell.startswith('<') else escape(cell)}</td>" for cell in row)
        kind = f' class="{classes[index]}"' if index < len(classes) and classes[index] else ""
        body += f"<tr{kind}>{cells}</tr>"
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
