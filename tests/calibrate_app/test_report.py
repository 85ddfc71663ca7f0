"""The report: its numbers are those of the command line, and it needs nothing but itself."""

import math
import re
from dataclasses import replace
from datetime import date
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import yaml
from drawing_states import SIZE, document_of, good_document, marks_at, paper_document, state_of

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.file import read_calibration
from fcw.camera.solve import calibrate
from fcw.errors import UserError
from fcw_viz.calibrate_app.document.document import Belief, Document
from fcw_viz.calibrate_app.document.numbers_text import interval_text
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.report import report_html
from fcw_viz.commands.calibrate.summary import calibration_summary

PICTURE = np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
FOUR_POINTS = document_of(marks_at((5.0, 10.0, 20.0, 30.0), errors_px=(0.4, -0.7, 0.9, -0.5)))


def report(state: SessionState, source: str = "drive.mp4") -> str:
    return report_html(state, PICTURE, 0, source, date(2026, 11, 20), {"fcw": "0.1.0"})


def headless(document: Document) -> Calibration:
    """What the command line makes of the same numbers."""
    points = [mark.ground_point for mark in document.marks]
    horizon = document.horizon and document.horizon.prior
    return calibrate(
        [point for point in points if point], SIZE, 1.225, 0.0, document.row_sigma_px, horizon_row=horizon
    )


class Tables(HTMLParser):
    """The rows of all tables: the texts of their cells."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self._in_cell = False
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self._in_cell = True
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        if tag in ("td", "th"):
            self._in_cell = False

    def handle_data(self, data: str) -> None:
        if self._in_cell:
            self.rows[-1][-1] += data


@pytest.mark.parametrize("document", [good_document(), FOUR_POINTS, paper_document()])
def test_every_row_is_that_of_the_command_line(document: Document) -> None:
    summary = calibration_summary(headless(document))
    rows = {row[0]: row[1:] for row in Tables(report(state_of(document))).rows if row}
    assert len(summary["rows"]) == 8
    for expected in summary["rows"]:
        row_px, interval, _ = rows[f"{expected['distance_m']:g} m"]
        assert row_px == f"{expected['row_px']:.2f}"
        high_m = math.inf if expected["high_m"] is None else expected["high_m"]
        assert interval == interval_text(expected["low_m"], high_m, False, " to ")


def test_the_camera_and_its_uncertainty_are_those_of_the_command_line() -> None:
    document = replace(FOUR_POINTS, horizon=Belief(Gaussian(326.0, 2.0)))
    summary = calibration_summary(headless(document))
    sigmas = summary["sigmas"]
    cells = {row[0]: row[1] for row in Tables(report(state_of(document))).rows if len(row) > 1}
    pitch, sigma = math.degrees(summary["pitch_rad"]), math.degrees(sigmas["pitch_rad"])
    assert cells["pitch, down"] == f"{pitch:.3f} ± {sigma:.3f}°"
    turned = summary["orientation"]
    for name, field in (("yaw, left", "yaw"), ("roll, right", "roll")):
        value, sigma = (math.degrees(turned[f"{field}{end}"]) for end in ("_rad", "_sigma_rad"))
        assert cells[name] == f"{value:.2f} ± {sigma:.2f}°"
    assert cells["focal length"] == f"{summary['focal_y_px']:.2f} ± {sigmas['focal_y_px']:.2f} px"
    assert cells["principal row"] == f"{summary['principal_row_px']:.2f} ± {sigmas['principal_row_px']:.2f}"
    assert cells["horizon row"] == f"{summary['horizon_row_px']:.2f} ± {sigmas['horizon_row_px']:.2f}"
    assert cells["horizon as set, row"] == "326.0 ± 2.0"


def test_points_have_the_residuals_of_the_command_line() -> None:
    off = replace(FOUR_POINTS.marks[0], id=5, enabled=False)
    document = replace(FOUR_POINTS, marks=(*FOUR_POINTS.marks, off))
    rows = {row[0]: row for row in Tables(report(state_of(document))).rows if row}
    residuals_px = calibration_summary(headless(document))["residuals_px"]
    for name, residual_px in zip("ABCD", residuals_px, strict=True):
        assert rows[name][4] == f"{residual_px:+.2f}"
    assert "not used" in rows["E"]


def test_residuals_of_an_exact_solution_are_said_to_mean_nothing() -> None:
    assert "say nothing" in report(state_of(good_document()))
    assert "say nothing" not in report(state_of(FOUR_POINTS))


def test_the_calibration_file_in_the_report_is_the_calibration(tmp_path: Path) -> None:
    html = report(state_of(FOUR_POINTS))
    match = re.search(r"<pre>(.*?)</pre>", html, re.DOTALL)
    assert match is not None
    path = tmp_path / "from_report.yaml"
    path.write_text(match[1].replace("&amp;", "&").replace("&#x27;", "'"))
    assert yaml.safe_load(path.read_text())["height_m"] == 1.225
    assert read_calibration(path) == headless(FOUR_POINTS)


def test_an_implausible_camera_carries_its_warning_and_its_likely_cause() -> None:
    html = report(state_of(paper_document()))
    (warning,) = re.findall(r'<p class="warning">(.*?)</p>', html)
    assert "2.29 m" in warning


def test_nothing_is_reported_where_no_camera_follows() -> None:
    with pytest.raises(UserError, match="no report yet"):
        report(state_of(good_document((4.0, 4.0, 7.0))))


def test_nothing_in_the_report_comes_from_elsewhere_and_names_cannot_be_markup() -> None:
    html = report(state_of(FOUR_POINTS), source="<b>&drive's.mp4")
    assert not re.search(r'(?:src|href)="(?!data:)', html)
    assert "url(" not in html
    assert "<script" not in html
    assert "<b>&drive" not in html
    assert "&lt;b&gt;&amp;drive" in html


def test_a_report_in_feet_has_feet_in_its_tables() -> None:
    rows = Tables(report(state_of(replace(FOUR_POINTS, imperial=True)))).rows
    assert any(row and row[0] == "100 ft" for row in rows)
    assert not any(re.search(r"\d m\b", cell) for row in rows for cell in row)
