"""What a batch writes of all its drives: thumbnails, the page's list, the fleet's page."""

import base64
import io
import os
import re
import shutil
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import cv2
import duckdb
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from export_drives import drive_header, marked_drive, marked_picture, write_log
from mcap.exceptions import EndOfFile
from mcap.records import Chunk, Message
from mcap.stream_reader import StreamReader, breakup_chunk

from fcw.annotation.records import Judgement, Verdict
from fcw.annotation.review import reference_to
from fcw.annotation.store import ReviewStore
from fcw.annotation.summary import summarise
from fcw.batch.fleet import FLEET_NAME, Fleet
from fcw.batch.ledger import DRIVES_NAME, RECORD_NAME, Record, State, write_record
from fcw.batch.moments import MOMENTS_NAME, WORST_NAME, moment_name, read_moment, write_moments
from fcw.batch.review_list import REVIEW_LIST_NAME, read_review_list
from fcw.batch.tables import EVENTS_NAME, write_tables
from fcw.errors import UserError
from fcw.logs.events import find_events
from fcw.logs.mcap.format import RESULT_TOPIC
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME, SUMMARY_NAME
from fcw.logs.records import NOTHING_SEEN
from fcw.logs.thumbnail import THUMBNAIL_PX
from fcw.warning.types import WarningLevel, WarningState
from fcw_viz.review_app.drive import duration_text
from fcw_viz.review_app.drive_card import listed_card, read_card
from fcw_viz.review_app.panels.folder_list import folder_html

UTC_NS = 1_795_132_800 * 10**9
"""2026-11-20, midnight."""


TRACK = b"""<gpx><trk><trkseg><trkpt lat="48" lon="11"><time>2026-11-20T00:00:00Z</time></trkpt>
<trkpt lat="48.0015" lon="11.003"><time>2026-11-20T00:00:01.5Z</time></trkpt></trkseg></trk></gpx>"""
"""Each second 0.001 degrees to the north and 0.002 to the east, for 1.5 s."""


def done_record(name: str, duration_s: float) -> Record:
    source = f"/d/{name}.mp4"
    record = Record(name, source, "van", State.DONE, identity=name, frames=75)
    notes = ("<end> of the file is missing", "blind for 2 s") if name == "a" else ()
    return replace(record, duration_s=duration_s, warnings=1, notes=notes)


@pytest.fixture(scope="module")
def batch(tmp_path_factory) -> Path:
    """Two drives with a warning each, and one that failed."""
    out = tmp_path_factory.mktemp("batch")
    records = [Record("torn", "/d/torn.mp4", "van", State.FAILED, "torn")]
    for name in ("a", "b"):
        header = replace(drive_header(), zero_utc_ns=UTC_NS, gpx=TRACK if name == "a" else b"")
        log = write_log(out / name / MCAP_NAME, marked_drive(75), header)
        write_moments(out / name)
        records.append(done_record(name, log.series().duration_s))
        write_record(records[-1], out / name)
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
        assert (card.camera, card.date) == (opened.camera, opened.date) == ("van", "2026-11-20")
        assert card.notes == opened.notes == done_record(log.parent.name, 0.0).notes
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


def test_files_of_a_batch_that_are_nested_deeply_count_as_missing(batch, tmp_path):
    deep = "[" * 99_999
    (tmp_path / "a").mkdir()
    os.link(batch / "a" / MCAP_NAME, tmp_path / "a" / MCAP_NAME)
    (tmp_path / "a" / SUMMARY_NAME).write_text(deep)
    write_tables(tmp_path, [done_record("a", 3.0)])
    assert "1 drive" in (tmp_path / FLEET_NAME).read_text()
    table = pq.read_table(tmp_path / REVIEW_LIST_NAME)
    rows = [row | {"events": deep} for row in table.to_pylist()]
    pq.write_table(pa.Table.from_pylist(rows, table.schema), tmp_path / REVIEW_LIST_NAME)
    assert read_review_list(tmp_path) == {}


def test_a_picture_that_is_no_thumbnail_is_neither_replaced_nor_shown(tmp_path: Path):
    write_log(tmp_path / MCAP_NAME, marked_drive(75), drive_header())
    write_moments(tmp_path)
    write_moments(tmp_path)  # in the place of its own
    assert read_moment(tmp_path, WORST_NAME)
    path = tmp_path / MOMENTS_NAME / WORST_NAME
    for foreign in (
        cv2.imencode(".jpg", np.zeros((9, 9, 3), np.uint8))[1].tobytes(),
        b"mine",
        bytes(2 << 20),
    ):
        path.write_bytes(foreign)
        assert read_moment(tmp_path, WORST_NAME) == b""
        with pytest.raises(UserError, match="is no thumbnail of a drive"):
            write_moments(tmp_path)
        assert path.read_bytes() == foreign


def test_advice_that_is_among_the_worst_moments_has_its_thumbnail(tmp_path: Path):
    advice = WarningState(WarningLevel.ADVISORY, 3, "headway", 20 / 6, 2.1, 0.9)
    drive = [
        (replace(result, warning=advice) if result.warning.level is WarningLevel.WARNING else result, packets)
        for result, packets in marked_drive(75)
    ]
    events = find_events(write_log(tmp_path / MCAP_NAME, drive, drive_header()).series())
    write_moments(tmp_path)
    assert {event.kind for event in events} == {"advisory"}
    assert all(read_moment(tmp_path, moment_name(event)) for event in events)


def test_the_fleet_has_the_worst_moments_and_four_charts(batch):
    page = (batch / FLEET_NAME).read_text()
    charts = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    assert len([ElementTree.fromstring(chart) for chart in charts]) == 4
    assert page.count("<figure>") == page.count("data:image/jpeg;base64,") == 10
    assert "2 drives" in page


def test_notes_on_a_drive_are_in_the_table_on_the_fleets_page_and_in_the_list(batch):
    table = pq.read_table(batch / DRIVES_NAME).to_pydict()
    assert dict(zip(table["drive"], table["notes"], strict=True)) == {
        "a": "<end> of the file is missing; blind for 2 s",
        "b": None,
        "torn": None,
    }
    assert (
        "<li>a: &lt;end&gt; of the file is missing</li><li>a: blind for 2 s</li>"
        in (batch / FLEET_NAME).read_text()
    )
    cards = [listed_card(one.drive, log, one) for log, one in read_review_list(batch).items()]
    html = folder_html("drives", cards, 0, 1000.0)
    assert html.count("&lt;end&gt; of the file is missing") == 1


def test_a_list_without_notes_and_files_as_earlier_batches_wrote_it_is_read(batch, tmp_path):
    (tmp_path / "a").mkdir()
    os.link(batch / "a" / MCAP_NAME, tmp_path / "a" / MCAP_NAME)
    earlier = pq.read_table(batch / REVIEW_LIST_NAME).drop_columns(["notes", "source"])
    pq.write_table(earlier, tmp_path / REVIEW_LIST_NAME)
    assert [one.notes for one in read_review_list(tmp_path).values()] == [()]


def test_rates_and_the_lists_hours_are_of_what_was_seen(tmp_path):
    (tmp_path / "a").mkdir()
    shown = marked_drive(51)
    late_ns = 40 * 24 * 3600 * 10**9
    late = [(replace(result, time_ns=result.time_ns + late_ns), ()) for result, _ in shown[26:]]
    log = write_log(tmp_path / "a" / MCAP_NAME, [*shown[:26], *late], drive_header())
    series = log.series()
    seen_h = (series.duration_s - float(np.diff(series.time_ns).max()) / 1e9) / 3600
    fleet = Fleet()
    record = replace(done_record("a", series.duration_s), warnings=1)
    fleet.add(record, series, find_events(series), log.header, tmp_path)
    assert fleet.warnings_per_hour == [pytest.approx(1 / seen_h)]
    assert f"1 drive · {duration_text(seen_h * 3600)} · " in folder_html(
        "drives", [read_card("a", log.path)], 0, 1000.0
    )


def test_one_drive_is_not_called_drives():
    fleet = Fleet(["a"], ["van"], [None], [1.0], [0.1])
    assert "<h1>1 drive</h1>" in fleet.html(Path())


def test_drives_that_say_when_they_were_stand_over_days_each_camera_in_its_colour():
    day_ns = 86_400 * 10**9
    monday_ns = 1_793_577_600 * 10**9  # 2026-11-02 00:00 UTC
    begun_ns = [monday_ns + 18 * day_ns // 24, monday_ns + 14 * day_ns, None]
    dated = Fleet(["a", "b"], ["van", "bus"], [*begun_ns[:2]], [1.0, 2.0], [0.1, 0.3])
    warnings, mount = dated.charts()[:2]
    for chart in (warnings, mount):
        assert chart.x_label == "days since 2026-11-02, UTC"
        assert chart.x_range == (0.0, 14.0)
    assert [(one.name, list(one.points)) for one in mount.series] == [
        ("bus", [(14.0, 0.3)]),
        ("van", [(0.75, 0.1)]),
    ]
    undated = Fleet(["a", "b", "c"], ["van"] * 3, begun_ns, [1.0] * 3, [0.1] * 3)
    assert undated.charts()[0].x_label.startswith("drive number")


def test_each_dot_has_its_drives_name_and_its_number_in_a_list_of_all():
    names, rates = ["<a>", "b", "c"], [1.0, 2.0, np.nan]
    fleet = Fleet(names, ["van", "bus", ""], [None] * 3, rates, [0.1, 0.2, 0.3])
    charts = [ElementTree.fromstring(chart.svg()) for chart in fleet.charts()[:2]]
    told = [{dot.findtext("{*}title") for dot in chart.iterfind(".//{*}circle")} for chart in charts]
    assert told == [{"1. <a>: 1.00", "2. b: 2.00"}, {"1. <a>: 0.10", "2. b: 0.20", "3. c: 0.30"}]
    (listed,) = re.findall(r"<ol>(.*?)</ol>", fleet.html(Path()))
    assert listed == "<li>&lt;a&gt; (van)</li><li>b (bus)</li><li>c</li>"


def test_a_fleet_without_any_drive_is_a_page_too(tmp_path):
    assert write_tables(tmp_path, [Record("torn", "/d/torn.mp4", "van", State.FAILED, "torn")]) == (0, ())
    assert "0 drives" in (tmp_path / FLEET_NAME).read_text()


def test_the_fleets_page_says_how_many_drives_it_lacks_and_where_the_reasons_are(batch, tmp_path):
    page = (batch / FLEET_NAME).read_text()
    assert "<b>1 more drive is not done</b> (1 failed)" in page
    assert DRIVES_NAME in page
    assert "fcw review" in page
    states = (State.FAILED, State.UNCALIBRATED, State.FAILED)
    write_tables(tmp_path, [Record(f"{n}", f"/{n}.mp4", "van", one, "!") for n, one in enumerate(states)])
    page = (tmp_path / FLEET_NAME).read_text()
    assert "<b>3 more drives are not done</b> (2 failed, 1 no calibration)" in page
    write_tables(tmp_path, [])
    assert "not done" not in (tmp_path / FLEET_NAME).read_text()


def test_the_bytes_of_an_event_hold_it_whole(batch):
    events = pq.read_table(batch / EVENTS_NAME).to_pylist()
    assert len(events) == 10
    for event in events:
        path = batch / event["drive"] / MCAP_NAME
        with path.open("rb") as file:
            file.seek(event["log_offset"])
            part = io.BytesIO(file.read(event["log_bytes"]))
        log = DriveLog(path)
        times_ns = []
        with suppress(EndOfFile):
            for chunk in StreamReader(part, skip_magic=True, emit_chunks=True).records:
                for record in breakup_chunk(chunk) if isinstance(chunk, Chunk) else ():
                    if isinstance(record, Message) and log.chunks.topics[record.channel_id] == RESULT_TOPIC:
                        times_ns.append(record.log_time)
        start_ns, end_ns = (log.series().time_ns[0] + event[name] * 1e9 for name in ("start_s", "end_s"))
        assert min(times_ns) <= start_ns
        assert max(times_ns) >= end_ns
        assert event["log_bytes"] < path.stat().st_size


def test_the_share_judged_false_is_that_of_the_summary_where_people_disagree(batch, tmp_path, monkeypatch):
    (tmp_path / "a").mkdir()
    shutil.copy(batch / "a" / MCAP_NAME, tmp_path / "a")
    log = DriveLog(tmp_path / "a" / MCAP_NAME)
    first, second, third = find_events(log.series())[:3]
    store = ReviewStore(log)
    for person, event, judgement in (
        ("anna", first, Judgement.RIGHT),
        ("bert", first, Judgement.FALSE),
        ("anna", second, Judgement.FALSE),
        ("anna", third, Judgement.TOO_LATE),
    ):
        store.add(person, Verdict(reference_to(event), judgement))
    store.close()
    write_tables(tmp_path, [done_record("a", 3.0)])
    verdicts = pq.read_table(tmp_path / EVENTS_NAME).column("verdict").to_pylist()
    assert verdicts == ["disagreed", "false", "too late", None, None]
    docs = (Path(__file__).parents[2] / "docs" / "batch.md").read_text()
    (question,) = re.findall(r"-- share judged false\n(.*)", docs)
    monkeypatch.chdir(tmp_path)
    assert duckdb.execute(question).fetchall() == [(1 / 2,)]
    assert summarise({"a": log.path}).all[WarningLevel.WARNING].share_false == 1 / 2


def test_warnings_are_counted_per_hour_in_which_something_could_be_seen(tmp_path, monkeypatch):
    frames = [
        (replace(result, notes=(NOTHING_SEEN,)) if result.index < 25 else result, packets)
        for result, packets in marked_drive(75)
    ]
    series = write_log(tmp_path / "a" / MCAP_NAME, frames, drive_header()).series()
    record = done_record("a", series.duration_s)
    write_tables(tmp_path, [record])
    # The lens is covered for the first 25 frames of 75, at 25 a second.
    (told,) = pq.read_table(tmp_path / DRIVES_NAME).select(["duration_s", "seen_s"]).to_pylist()
    assert told["duration_s"] - told["seen_s"] == pytest.approx(1.0, abs=0.05)
    docs = (Path(__file__).parents[2] / "docs" / "batch.md").read_text()
    (question,) = re.findall(r"-- warnings per hour\n(.*)", docs)
    monkeypatch.chdir(tmp_path)
    fleet = Fleet()
    fleet.add(record, series, find_events(series), drive_header(), tmp_path)
    assert duckdb.execute(question).fetchall() == [(pytest.approx(fleet.warnings_per_hour[0]),)]


def test_events_of_a_drive_with_a_gpx_track_have_their_place(batch):
    events = pq.read_table(batch / EVENTS_NAME).to_pylist()
    of_track = [event for event in events if event["drive"] == "a"]
    for event in of_track:
        if event["peak_s"] <= 1.5:
            assert event["latitude_deg"] == pytest.approx(48 + 0.001 * event["peak_s"], abs=1e-9)
            assert event["longitude_deg"] == pytest.approx(11 + 0.002 * event["peak_s"], abs=1e-9)
        else:
            assert event["latitude_deg"] is event["longitude_deg"] is None
    assert {event["peak_s"] <= 1.5 for event in of_track} == {True, False}
    assert {event["latitude_deg"] for event in events if event["drive"] == "b"} == {None}


def test_one_log_that_cannot_be_read_costs_the_others_nothing(batch, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(batch, out)
    records = [done_record(name, 3.0) for name in ("a", "b")]
    write_record(records[1], out / "b")
    (out / "b" / MCAP_NAME).write_bytes(b"no log")
    count, unreadable = write_tables(out, records)
    assert count == 5
    assert [(record.name, record.state) for record in unreadable] == [("b", State.LOST)]
    assert str(out / "b" / MCAP_NAME) in unreadable[0].reason
    assert pq.read_table(out / DRIVES_NAME).column("state").to_pylist() == ["done", "not finished"]
    assert pq.read_table(out / DRIVES_NAME).column("events").to_pylist() == [5, 0]
    assert not (out / "b" / RECORD_NAME).exists()  # so that the next batch runs it
