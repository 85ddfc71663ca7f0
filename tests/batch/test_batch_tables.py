"""What a batch writes of all its drives: thumbnails, the page's list, the fleet's page."""

import base64
import os
import re
from pathlib import Path
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from export_drives import drive_header, marked_drive, marked_picture, write_log

from fcw.batch.fleet import FLEET_NAME, Fleet
from fcw.batch.ledger import Record, State
from fcw.batch.moments import WORST_NAME, moment_name, read_moment, write_moments
from fcw.batch.review_list import REVIEW_LIST_NAME, read_review_list
from fcw.batch.tables import write_tables
from fcw.logs.events import find_events
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME
from fcw.logs.thumbnail import THUMBNAIL_PX
from fcw_viz.review_app.drive_card import listed_card, read_card


@pytest.fixture(scope="module")
def batch(tmp_path_factory) -> Path:
    """Two drives with a warning each, and one that failed."""
    out = tmp_path_factory.mktemp("batch")
    records = [Record("torn", "/d/torn.mp4", "van", State.FAILED, "torn")]
    for name in ("a", "b"):
        log = write_log(out / name / MCAP_NAME, marked_drive(75), drive_header())
        write_moments(out / name)
        duration_s = log.series().duration_s
        records.append(
            Record(name, f"/d/{name}.mp4", "van", State.DONE, "", name, 75, 1.0, duration_s, warnings=1)
        )
    write_tables(out, records)
    return out


def test_a_warning_and_the_worst_moment_have_a_thumbnail_of_their_time(batch):
    log = DriveLog(batch / "a" / MCAP_NAME)
    warnings = [event for event in find_events(log.series()) if event.kind == "warning"]
    assert len(warnings) == 5
    for warning in warnings:
        jpeg = read_moment(batch / "a", moment_name(warning))
        image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        assert image is not None
        assert image.shape[1] >= THUMBNAIL_PX[0]
        shown = marked_picture(round(warning.peak_s * 25))
        assert np.median(image) == pytest.approx(np.median(shown), abs=3)
    assert read_moment(batch / "a", WORST_NAME)
    assert read_moment(batch / "a", "7.jpg") == b""


def test_the_list_says_what_the_logs_say(batch):
    listed = read_review_list(batch)
    assert {log.parent.name for log in listed} == {"a", "b"}
    for log, one in listed.items():
        card, opened = listed_card("x", log, one), read_card("x", log)
        assert card.events == opened.events
        assert (card.duration_s, card.imperial, card.judged) == (
            opened.duration_s,
            opened.imperial,
            opened.judged,
        )
        assert base64.b64decode(card.thumbnail) == read_moment(log.parent, WORST_NAME)


def test_a_log_that_is_another_by_now_is_not_in_the_list(batch, tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        os.link(batch / name / MCAP_NAME, tmp_path / name / MCAP_NAME)
    data = (batch / REVIEW_LIST_NAME).read_bytes()
    (tmp_path / REVIEW_LIST_NAME).write_bytes(data)
    assert len(read_review_list(tmp_path)) == 2
    replaced = tmp_path / "a" / MCAP_NAME
    whole = replaced.read_bytes()
    replaced.unlink()
    replaced.write_bytes(whole)
    assert [log.parent.name for log in read_review_list(tmp_path)] == ["b"]
    for torn in (data[:-20], b"", b"PAR1"):
        (tmp_path / REVIEW_LIST_NAME).write_bytes(torn)
        assert read_review_list(tmp_path) == {}


def test_the_fleet_has_the_worst_moments_and_four_charts(batch):
    page = (batch / FLEET_NAME).read_text()
    charts = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    assert len([ElementTree.fromstring(chart) for chart in charts]) == 4
    assert page.count("<figure>") == page.count("data:image/jpeg;base64,") == 10
    assert "2 drives" in page


def test_one_drive_is_not_called_drives():
    assert "<h1>1 drive</h1>" in Fleet(["a"], [1.0], [0.1]).html(Path())


def test_a_fleet_without_any_drive_is_a_page_too(tmp_path):
    assert write_tables(tmp_path, [Record("torn", "/d/torn.mp4", "van", State.FAILED, "torn")]) == 0
    assert "0 drives" in (tmp_path / FLEET_NAME).read_text()
