"""Tables of tracks: read back by pandas and pyarrow they hold what the frames' results held."""

import math
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow.parquet as pq
import pytest
from export_drives import STEP_NS, drive_header, in_time, write_log
from hypothesis import HealthCheck, given
from hypothesis import strategies as st
from searching import examples

from fcw.errors import UserError
from fcw.logs.export.clip import DriveClip
from fcw.logs.export.columns import EVENT_COLUMNS, TRACK_COLUMNS, Column, track_rows
from fcw.logs.export.table import write_csv, write_parquet
from fcw.logs.records import FrameResult

DOCS = Path(__file__).parents[3] / "docs" / "export.md"
PANDAS_TYPES = {"string": "string", "int64": "Int64", "float64": "float64", "bool": "boolean"}


def own_values(result: FrameResult) -> dict[str, Any]:
    """Own motion and path: empty where they are not known."""
    motion, path = result.own_motion, result.own_path
    mount = motion.mount if motion else None
    return {
        "ego_speed_sigma_mps": motion.speed_sigma_mps if motion else None,
        "ego_speed_source": (motion.speed_source.value or None) if motion else None,
        "yaw_rate_radps": motion.yaw_rate_radps if motion else None,
        "camera_yaw_rad": mount.yaw_rad if mount else None,
        "camera_pitch_rad": mount.pitch_rad if mount else None,
        "camera_roll_rad": mount.roll_rad if mount else None,
        "path_curvature_per_m": path.curvature_per_m if path else None,
        "path_offset_m": path.offset_m if path else None,
    }


def expected_rows(drive: str, results: Sequence[FrameResult]) -> Iterator[dict[str, Any]]:
    """What a table must hold, written out."""
    for result in results:
        warning = result.told_warning
        frame = {
            "drive": drive,
            "frame": result.index,
            "time_ns": result.time_ns,
            "time_s": (result.time_ns - results[0].time_ns) / 1e9,
            "ego_speed_mps": result.ego_speed_mps,
            **own_values(result),
            "lead_id": result.lead_id,
            "warning_level": warning.level.name.lower(),
            "warning_track_id": warning.track_id,
            "warning_rule": warning.rule or None,
            "warning_ttc_s": warning.ttc_s,
            "warning_required_deceleration_mps2": warning.required_deceleration_mps2,
            "warning_headway_s": warning.headway_s,
            "warning_distance_m": warning.distance_m,
            "warning_distance_low_m": warning.distance_low_m,
            "warning_distance_high_m": warning.distance_high_m,
            "warning_closing_speed_mps": warning.closing_speed_mps,
            "warning_overlap_m": warning.overlap_m,
            "warning_collision_probability": warning.collision_probability,
            "warning_needed_distance_m": warning.needed_distance_m,
            "warning_assumes": warning.assumes or None,
            "warning_extrapolated": warning.extrapolated,
            "notes": "; ".join(result.notes) or None,
        }
        for track in result.tracks:
            box = track.box
            yield frame | {
                "track_id": track.track_id,
                "is_lead": track.track_id == result.lead_id,
                "in_path": track.in_path,
                "seen_by": track.seen_by.value,
                "coasting": track.coasting,
                "age_s": track.age_s,
                "score": track.score,
                "box_x_px": box.x,
                "box_y_px": box.y,
                "box_w_px": box.w,
                "box_h_px": box.h,
                "distance_m": track.distance_m,
                "distance_low_m": track.distance_low_m,
                "distance_high_m": track.distance_high_m,
                "lateral_m": track.lateral_m,
                "lateral_speed_mps": track.lateral_speed_mps,
                "closing_speed_mps": track.closing_speed_mps,
                "closing_speed_sigma_mps": track.closing_speed_sigma_mps,
                "closing_acceleration_mps2": track.closing_acceleration_mps2,
                "closing_acceleration_sigma_mps2": track.closing_acceleration_sigma_mps2,
                "ttc_s": track.ttc_s,
                "width_m": track.width_m,
                "lateral_sigma_m": track.lateral_sigma_m,
                "lateral_speed_sigma_mps": track.lateral_speed_sigma_mps,
                "lateral_slowing_mps2": track.lateral_slowing_mps2,
                "lateral_speed_by_bearing_mps": track.lateral_speed_by_bearing_mps,
                "lateral_speed_by_bearing_sigma_mps": track.lateral_speed_by_bearing_sigma_mps,
                "doubtful": track.doubtful,
                "found_part": track.found_part,
            }
        if not result.tracks:
            yield frame


def assert_equal(found: Sequence[dict[str, Any]], expected: Sequence[dict[str, Any]]) -> None:
    assert len(found) == len(expected)
    for row, wanted in zip(found, expected, strict=True):
        for column in TRACK_COLUMNS:
            value = wanted.get(column.name)
            if value is None:
                assert row[column.name] is None, column.name
            else:
                assert row[column.name] == value, column.name
                assert type(row[column.name]) is type(value), column.name


def from_pandas(frame: pd.DataFrame) -> list[dict[str, Any]]:
    return [
        {
            name: None if value is pd.NA or (isinstance(value, float) and math.isnan(value)) else value
            for name, value in row.items()
        }
        for row in frame.to_dict("records")
    ]


def read_csv(path: Path) -> pd.DataFrame:
    types: Any = {column.name: PANDAS_TYPES[column.kind] for column in TRACK_COLUMNS}
    return pd.read_csv(path, dtype=types, keep_default_na=False, na_values=[""])


def drawn_results(data: st.DataObject, any_frame_result: st.SearchStrategy[FrameResult]) -> list[FrameResult]:
    results = data.draw(st.lists(any_frame_result, min_size=1, max_size=4))
    words = st.sampled_from(["", "ttc", 'two, "quoted" words', "two\nlines", "ä ≥ NA", "NaN"])
    return in_time(
        [
            replace(
                result,
                warning=replace(result.warning, rule=data.draw(words), assumes=data.draw(words)),
                notes=data.draw(st.lists(words.filter(bool), max_size=2).map(tuple)),
            )
            for result in results
        ],
        data.draw(st.sampled_from([0, 5_000_000_000, 123_456_789_012_345_678])),
    )


@pytest.mark.slow
@examples(25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_csv_and_parquet_give_back_every_frame_and_track(any_frame_result, tmp_path, data):
    results = drawn_results(data, any_frame_result)
    write_log(tmp_path / "some drive" / "drive.mcap", [(result, ()) for result in results], drive_header())
    clip = DriveClip.open(tmp_path / "some drive" / "drive.mcap")
    expected = list(expected_rows("some drive", results))

    assert write_csv(tmp_path / "t.csv", TRACK_COLUMNS, track_rows([clip], lambda: None)) == len(expected)
    assert_equal(from_pandas(read_csv(tmp_path / "t.csv")), expected)

    assert write_parquet(tmp_path / "t.parquet", TRACK_COLUMNS, track_rows([clip], lambda: None)) == len(
        expected
    )
    assert_equal(pq.read_table(tmp_path / "t.parquet").to_pylist(), expected)


def test_several_drives_stand_in_one_table_by_their_names(header, short_drive, tmp_path):
    clips = []
    for name in ("first", "second"):
        write_log(tmp_path / name / "drive.mcap", short_drive[:5], header)
        clips.append(DriveClip.open(tmp_path / name / "drive.mcap", name))
    write_csv(tmp_path / "t.csv", TRACK_COLUMNS, track_rows(clips, lambda: None))
    frame = read_csv(tmp_path / "t.csv")
    assert frame.groupby("drive").size().to_dict() == {"first": 10, "second": 10}


def test_parquet_fields_say_their_unit_and_meaning(header, short_drive, tmp_path):
    write_log(tmp_path / "drive.mcap", short_drive[:2], header)
    clip = DriveClip.open(tmp_path / "drive.mcap")
    write_parquet(tmp_path / "t.parquet", TRACK_COLUMNS, track_rows([clip], lambda: None))
    schema = pq.read_schema(tmp_path / "t.parquet")
    assert schema.field("distance_m").metadata[b"unit"] == b"m"
    assert b"calibration's reference" in schema.field("distance_m").metadata[b"meaning"]
    assert schema.field("closing_acceleration_mps2").metadata[b"unit"] == b"m/s^2"


def test_a_range_holds_its_frames_with_both_ends_and_times_from_the_drives_first_frame(
    header, short_drive, tmp_path
):
    drive = [(replace(result, time_ns=result.time_ns + STEP_NS), ()) for result, _ in short_drive]
    write_log(tmp_path / "drive.mcap", drive, header)
    clip = DriveClip.open(tmp_path / "drive.mcap", between=(2.0, 2.3))
    rows = list(track_rows([clip], lambda: None))
    assert sorted({row.result.index for row in rows}) == [20, 21, 22, 23]
    assert sorted({row.clip.time_s(row.result.time_ns) for row in rows}) == [2.0, 2.1, 2.2, 2.3]


def test_without_pyarrow_the_way_to_get_it_is_named(header, short_drive, tmp_path, monkeypatch):
    write_log(tmp_path / "drive.mcap", short_drive[:2], header)
    rows = track_rows([DriveClip.open(tmp_path / "drive.mcap")], lambda: None)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(UserError, match=r"pyarrow.*pip install 'fcw\[parquet\]'"):
        write_parquet(tmp_path / "t.parquet", TRACK_COLUMNS, rows)
    assert not (tmp_path / "t.parquet").exists()


def test_a_table_that_fails_half_way_leaves_the_older_one(header, short_drive, tmp_path):
    def rows() -> Iterator[Any]:
        yield from list(good)[:3]
        raise RuntimeError("half way")

    write_log(tmp_path / "drive.mcap", short_drive[:5], header)
    clip = DriveClip.open(tmp_path / "drive.mcap")
    for write, name in ((write_csv, "t.csv"), (write_parquet, "t.parquet")):
        good = track_rows([clip], lambda: None)
        (tmp_path / name).write_text("older")
        with pytest.raises(RuntimeError, match="half way"):
            write(tmp_path / name, TRACK_COLUMNS, rows())
        assert (tmp_path / name).read_text() == "older"
        assert sorted(path.name for path in tmp_path.iterdir() if "partial" in path.name) == []


@pytest.mark.parametrize("columns", [TRACK_COLUMNS, EVENT_COLUMNS], ids=["tracks", "events"])
def test_the_documentation_lists_every_column_with_its_unit(columns: tuple[Column[Any], ...]):
    listed = re.findall(r"^\| `(\w+)` \| (\w+) \| (.*?) ?\| (.*) \|$", DOCS.read_text(), re.MULTILINE)
    rows = [(column.name, column.kind, column.unit, column.meaning) for column in columns]
    assert any(listed[i : i + len(rows)] == rows for i in range(len(listed)))
