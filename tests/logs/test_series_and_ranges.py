"""Signals as columns, ranges of time, and single frames of a log."""

import io
import math
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st
from searching import examples

from fcw.frame import VideoPacket
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader, FrameResult
from fcw.logs.series import NO_TRACK, DriveSeries, SeriesBuilder
from fcw.warning.types import WarningLevel, WarningState

Drive = list[tuple[FrameResult, tuple[VideoPacket, ...]]]


def write_log(path: Path, header: DriveHeader, drive: Drive) -> DriveLog:
    sink = McapSink(path)
    sink.open(header)
    for result, packets in drive:
        sink.write(result, packets)
    sink.close()
    return DriveLog(path)


def series_of(drive: Drive) -> DriveSeries:
    builder = SeriesBuilder()
    for result, packets in drive:
        builder.add(result, packets)
    return builder.build()


def assert_alike(one: DriveSeries, other: DriveSeries) -> None:
    for field in fields(DriveSeries):
        mine, theirs = getattr(one, field.name), getattr(other, field.name)
        if isinstance(mine, np.ndarray):
            assert mine.dtype == theirs.dtype
            np.testing.assert_array_equal(mine, theirs)
        else:
            assert mine == theirs


def test_a_policy_of_ones_own_may_name_its_rule_anew_in_each_frame(short_drive):
    result = short_drive[0][0]
    rules = [f"at {number} m/s" for number in range(300)]
    warned = [replace(result, warning=WarningState(WarningLevel.WARNING, 7, rule)) for rule in rules]
    series = DriveSeries.from_bytes(series_of([(one, ()) for one in warned]).to_bytes())
    assert [series.rules[number] for number in series.rule] == rules


@pytest.fixture(scope="module")
def whole(tmp_path_factory, header, short_drive) -> DriveLog:
    return write_log(tmp_path_factory.mktemp("whole") / "drive.mcap", header, short_drive)


@pytest.fixture(scope="module")
def torn(tmp_path_factory, whole) -> DriveLog:
    path = tmp_path_factory.mktemp("torn") / "drive.mcap"
    path.write_bytes(whole.path.read_bytes()[: whole.path.stat().st_size // 2])
    return DriveLog(path)


@pytest.fixture(scope="module")
def logs(whole, torn) -> list[tuple[DriveLog, Drive]]:
    """The whole and the torn log, each with all that is in it."""
    return [(log, list(log.entries())) for log in (whole, torn)]


def test_columns_hold_what_the_results_say(short_drive):
    series = series_of(short_drive)
    assert len(series) == 100
    assert series.duration_s == pytest.approx(9.9)
    np.testing.assert_array_equal(series.time_ns, [result.time_ns for result, _ in short_drive])
    np.testing.assert_array_equal(series.level, [result.warning.level for result, _ in short_drive])
    assert [series.rules[k] for k in series.rule] == [result.warning.rule for result, _ in short_drive]
    assert set(series.lead_id) == {7}
    assert set(series.distance_m) == {20.0}
    assert set(series.closing_speed_mps) == {8.0}
    assert set(series.ttc_s) == {2.5}
    assert series.headway_s[0] == pytest.approx(20 / 22)
    assert series.required_deceleration_mps2[0] == pytest.approx(8**2 / (2 * 20))
    assert series.keyframe_ns.tolist() == [-200_000_000, *(k * 10**9 for k in range(10))]


def test_what_is_not_known_is_nan():
    free = FrameResult(0, 0, (), (), None, WarningState(WarningLevel.NONE), None)
    series = series_of([(free, ())])
    assert series.lead_id[0] == series.warned_id[0] == NO_TRACK
    for name in ("distance_m", "closing_speed_mps", "ttc_s", "headway_s", "ego_speed_mps"):
        assert math.isnan(getattr(series, name)[0])


@examples(30)
@given(data=st.data())
def test_columns_come_back_from_their_bytes(any_frame_result, data):
    drive = [(result, ()) for result in data.draw(st.lists(any_frame_result, max_size=5))]
    with np.errstate(over="ignore"):  # beyond single precision
        series = series_of(drive)
    assert_alike(DriveSeries.from_bytes(series.to_bytes()), series)


def test_other_bytes_are_no_columns(short_drive):
    data = series_of(short_drive).to_bytes()
    for wrong in (b"", b"PK", data[: len(data) // 2], data[:100] + b"\xff" * 200 + data[300:]):
        with pytest.raises(ValueError, match="no columns of a drive"):
            DriveSeries.from_bytes(wrong)


@pytest.mark.slow
def test_an_hours_columns_are_a_few_megabytes(short_drive):
    one = short_drive[30][0]
    rng = np.random.default_rng(0)
    track = one.tracks[1]
    hour = (
        replace(
            one,
            index=i,
            time_ns=i * 33_333_333,
            tracks=(replace(track, distance_m=float(d), closing_speed_mps=float(v)),),
        )
        for i, (d, v) in enumerate(rng.normal((30, 2), (5, 3), (108_000, 2)))
    )
    builder = SeriesBuilder()
    for result in hour:
        builder.add(result, ())
    assert len(builder.build().to_bytes()) < 4_000_000


def test_a_log_brings_its_columns_and_a_torn_one_yields_them(whole, torn, short_drive):
    assert_alike(whole.series(), series_of(short_drive))
    parts: list[float] = []
    series = torn.series(parts.append)
    count = len(series)
    assert 0 < count < 100
    assert parts == sorted(parts)
    assert 0 < parts[-1] <= 1
    kept = [(result, packets) for result, packets in short_drive[:count]]
    assert_alike(replace(series, keyframe_ns=series_of(kept).keyframe_ns), series_of(kept))
    assert set(series.keyframe_ns) <= set(series_of(kept).keyframe_ns)


def test_damaged_columns_are_gathered_from_the_messages(whole, short_drive, tmp_path):
    data = bytearray(whole.path.read_bytes())
    at = data.index(b"drive.series") + 200
    data[at : at + 50] = bytes(50)
    path = tmp_path / "drive.mcap"
    path.write_bytes(data)
    assert_alike(DriveLog(path).series(), series_of(short_drive))


def test_rows_are_found_by_frame_and_time(short_drive):
    series = series_of(short_drive[20:])  # a log cut out of a drive: its numbers begin at 20
    assert series.row_of(20) == 0
    assert series.row_of(99) == 79
    for missing in (19, 100):
        with pytest.raises(IndexError, match=f"no frame {missing}"):
            series.row_of(missing)
    assert series.row_at(2_000_000_000) == 0
    assert series.row_at(2_099_999_999) == 0
    assert series.row_at(2_100_000_000) == 1
    assert series.row_at(0) == 0
    assert series.row_at(10**12) == 79
    assert series.keyframe_before(1_999_999_999) is None
    assert series.keyframe_before(2_950_000_000) == 2_000_000_000


@examples(60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(bounds=st.tuples(*[st.none() | st.integers(-3 * 10**8, 11 * 10**9)] * 2), of_torn=st.booleans())
def test_a_range_gives_what_is_in_it(logs, bounds, of_torn: bool):
    log, everything = logs[of_torn]
    start_ns, end_ns = bounds
    first, last = -(10**18) if start_ns is None else start_ns, 10**18 if end_ns is None else end_ns
    inside = [(r, p) for r, p in everything if first <= r.time_ns < last]
    assert list(log.results(start_ns, end_ns)) == [result for result, _ in inside]
    assert list(log.entries(start_ns, end_ns)) == inside


@examples(60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(start_ns=st.integers(-(10**8), 10**10), length_ns=st.integers(1, 3 * 10**9), of_torn=st.booleans())
def test_packets_of_a_range_start_at_the_keyframe_before(logs, start_ns, length_ns, of_torn: bool):
    log, everything = logs[of_torn]
    packets = [packet for _, packets in everything for packet in packets]
    keyframes_ns = [packet.time_ns for packet in packets if packet.keyframe and packet.time_ns <= start_ns]
    expected = [p for p in packets if max(keyframes_ns) <= p.time_ns < start_ns + length_ns]
    assert list(log.video_packets(start_ns, start_ns + length_ns)) == expected


def test_a_frame_is_found_by_its_number(whole, torn, short_drive):
    for index in (0, 1, 37, 64, 99):
        assert whole.result_at(index) == short_drive[index][0]
    assert torn.result_at(37) == short_drive[37][0]
    for log, index in ((whole, 100), (whole, -1), (torn, 99)):
        with pytest.raises(IndexError, match=f"no frame {index}"):
            log.result_at(index)


def test_signals_and_pictures_stand_apart(whole):
    table = whole.chunks
    for chunk in table.chunks:
        topics = {table.topics[channel_id] for channel_id in chunk.message_index_offsets}
        assert topics == {"/camera/image"} or "/camera/image" not in topics
        if "/camera/image" in topics:
            assert chunk.message_end_time - chunk.message_start_time <= 500_000_000
            seconds = {time_ns // 10**9 for time_ns in (chunk.message_start_time, chunk.message_end_time)}
            assert len(seconds) == 1  # there is a keyframe each second, and chunks end before
        else:
            assert chunk.message_end_time - chunk.message_start_time < 300_000_000


def test_a_log_of_before_the_interval_of_the_own_speed_is_read(short_drive):
    series = series_of(short_drive)
    with np.load(io.BytesIO(series.to_bytes())) as stored:
        older = {name: stored[name] for name in stored if name != "ego_speed_sigma_mps"}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **older)
    read = DriveSeries.from_bytes(buffer.getvalue())
    assert np.isnan(read.ego_speed_sigma_mps).all()
    assert len(read.ego_speed_sigma_mps) == len(series)
