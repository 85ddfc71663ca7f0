"""What is taken along from the page is what it says."""

import csv
import io
from pathlib import Path

import av
import pytest
from review_drives import CAUTION_S, RATE_HZ, WARNING_END_S, frame_number

from fcw.logs.export.clip import DriveClip
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.taking import (
    AROUND_S,
    clip_around,
    event_table,
    exported_file,
    held_range,
    write_from_its_start,
)


def test_a_clip_reaches_around_its_event_and_not_beyond_the_drive():
    assert clip_around(20.0, 22.0, 100.0) == (20.0 - AROUND_S, 22.0 + AROUND_S)
    assert clip_around(1.0, 9.0, 10.0) == (0.0, 10.0)


def test_the_clip_as_mcap_holds_the_event(drive: Drive, tmp_path: Path):
    between = clip_around(CAUTION_S, WARNING_END_S, drive.duration_s)
    file = tmp_path / "clip.mcap"
    file.write_bytes(exported_file(drive.log.path, "mcap", between))
    clip = Drive.open("clip", file)
    assert clip.events[0].kind == "warning"
    assert clip.duration_s == pytest.approx(between[1] - between[0], abs=1.1)  # from a keyframe on
    assert DriveLog(file).complete


def test_what_a_clip_is_said_to_hold_is_what_it_holds(drive: Drive, tmp_path: Path):
    between = clip_around(CAUTION_S + 0.36, WARNING_END_S, drive.duration_s)
    file = tmp_path / "clip.mcap"
    file.write_bytes(exported_file(drive.log.path, "mcap", between))
    clip, held = Drive.open("clip", file), held_range(drive.log.path, between)
    assert held[0] <= between[0]
    assert (clip.first_ns - drive.first_ns) / 1e9 == pytest.approx(held[0])
    assert held[0] + clip.duration_s == pytest.approx(held[1])


def test_the_clip_for_rerun_begins_where_it_should(drive: Drive, tmp_path: Path):
    between = CAUTION_S + 0.36, WARNING_END_S
    assert held_range(drive.log.path, between)[0] < between[0]  # there is no keyframe
    sink = McapSink(tmp_path / "clip.mcap")
    write_from_its_start(DriveClip.open(drive.log.path, between=between), sink)
    clip = Drive.open("clip", tmp_path / "clip.mcap")
    assert (clip.first_ns - drive.first_ns) / 1e9 == pytest.approx(between[0])
    first, last = (clip.frame_index(row) for row in (0, clip.last_row))
    assert [frame_number(clip.pictures().at(index)) for index in (first, last)] == [first, last]


def test_the_clip_as_mp4_plays_as_long(drive: Drive):
    content = exported_file(drive.log.path, "mp4", (9.0, 11.0))
    with av.open(io.BytesIO(content), "r") as video:
        assert sum(1 for _ in video.decode(video=0)) == pytest.approx(2 * RATE_HZ, abs=1)


def test_the_table_has_every_event(drive: Drive):
    rows = list(csv.DictReader(io.StringIO(event_table(drive.log.path).decode())))
    assert [row["kind"] for row in rows] == [event.kind for event in drive.events]
    assert [float(row["start_s"]) for row in rows] == pytest.approx([e.start_s for e in drive.events])
