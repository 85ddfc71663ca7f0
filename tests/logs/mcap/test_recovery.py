"""Whole logs made of torn and of damaged ones, judged by mcap's own readers."""

import os
from pathlib import Path

import pytest
from mcap.reader import make_reader

from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.recovery import recover
from fcw.logs.names import recovered_path
from fcw_viz.cli import main


@pytest.fixture
def torn(whole_log) -> Path:
    data = whole_log.read_bytes()
    whole_log.write_bytes(data[: len(data) * 2 // 3])
    return whole_log


def messages(path: Path) -> list[tuple[str, int, int, bytes]]:
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        read = [
            (channel.topic, message.log_time, message.sequence, message.data)
            for _, channel, message in reader.iter_messages(log_time_order=False)
        ]
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == len(read)
    counts = {summary.channels[k].topic: n for k, n in summary.statistics.channel_message_counts.items()}
    assert counts == {topic: sum(other == topic for other, *_ in read) for topic in counts}
    return read


def test_a_recovered_log_has_all_that_the_torn_one_gives(torn, tmp_path):
    out = tmp_path / "new.mcap"
    before = torn.read_bytes()
    parts: list[float] = []
    report = recover(torn, out, parts.append)
    old, new = DriveLog(torn), DriveLog(out)
    assert new.complete
    assert new.notes == ()
    assert new.header == old.header
    entries = list(new.entries())
    assert entries == list(old.entries())
    assert report.frames == len(entries) == len(new.series())
    assert report.pictures == sum(bool(packets) for _, packets in entries)
    assert report.duration_s == pytest.approx((entries[-1][0].time_ns - entries[0][0].time_ns) / 1e9)
    assert (report.damaged_chunks, report.was_complete) == (0, False)
    assert report.torn_bytes > 0
    assert parts == sorted(parts)
    assert parts[-1] == 1
    assert torn.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir() if path not in (torn, out)] == []
    messages(out)


def test_the_messages_of_a_log_that_was_only_not_closed_stay_as_they_are(whole_log, tmp_path):
    before = messages(whole_log)
    data = whole_log.read_bytes()
    whole_log.write_bytes(data[:-20])  # the last record, which says that it was
    report = recover(whole_log, tmp_path / "new.mcap")
    assert messages(tmp_path / "new.mcap") == before
    assert (report.was_complete, report.frames) == (False, 100)


def test_of_a_whole_log_nothing_is_written(whole_log, tmp_path):
    report = recover(whole_log, tmp_path / "new.mcap")
    assert (report.written, report.torn_bytes, report.frames) == (False, 0, 100)
    assert report.pictures == sum(bool(packets) for _, packets in DriveLog(whole_log).entries())
    assert list(tmp_path.iterdir()) == [whole_log]


def test_of_a_log_with_a_damaged_part_the_rest_is_recovered(whole_log, short_drive, tmp_path):
    chunks = DriveLog(whole_log).chunks.chunks
    data = bytearray(whole_log.read_bytes())
    damaged = chunks[len(chunks) // 2]
    middle = damaged.chunk_start_offset + damaged.chunk_length // 2
    data[middle : middle + 20] = bytes(20)
    whole_log.write_bytes(data)
    with pytest.raises(UserError, match=r"the log is damaged .* `fcw recover "):
        list(DriveLog(whole_log).entries())
    report = recover(whole_log, tmp_path / "new.mcap")
    assert report.damaged_chunks == 1
    expected = dict(short_drive)
    entries = list(DriveLog(tmp_path / "new.mcap").entries())
    assert len(entries) > 90
    assert all(packets in (expected[result], ()) for result, packets in entries)
    messages(tmp_path / "new.mcap")


def test_a_damaged_index_does_not_matter(whole_log, short_drive, tmp_path):
    data = bytearray(whole_log.read_bytes())
    data[-60:-30] = bytes(30)
    whole_log.write_bytes(data)
    assert recover(whole_log, tmp_path / "new.mcap").written
    assert list(DriveLog(tmp_path / "new.mcap").entries()) == short_drive


def test_a_log_of_no_readable_frame_is_refused_and_nothing_left(whole_log, tmp_path):
    first = DriveLog(whole_log).chunks.chunks[0]
    whole_log.write_bytes(whole_log.read_bytes()[: first.chunk_start_offset + 20])
    with pytest.raises(UserError, match=r"drive\.mcap: no frame of this log can be read"):
        recover(whole_log, tmp_path / "new.mcap")
    assert list(tmp_path.iterdir()) == [whole_log]


def test_nothing_is_replaced(torn, tmp_path):
    for out in (torn, tmp_path / "other"):
        if out != torn:
            out.write_text("mine")
        before = out.read_bytes()
        with pytest.raises(
            UserError, match="is there already; move it away, or name another file with --out"
        ):
            recover(torn, out)
        assert out.read_bytes() == before


def test_the_command_recovers_beside_the_drive_and_says_what_came_of_it(torn, capsys):
    assert main(["recover", str(torn.parent)]) == 0
    said = capsys.readouterr().out
    log = DriveLog(recovered_path(torn))
    results = list(log.results())
    assert recovered_path(torn).name == "drive.recovered.mcap"
    assert f"{len(results)} frames, {log.series().duration_s:.2f} s" in said
    assert "at most 0.3 s of signals and 0.5 s of pictures are lost" in said
    assert f"\n  review it: fcw review {recovered_path(torn)}\n" in said
    assert main(["recover", str(torn)]) == 2
    said = capsys.readouterr().err
    assert "drive.recovered.mcap: is there already" in said
    assert f"`fcw review {recovered_path(torn)}` opens it" in said


def test_what_is_said_of_a_torn_log_names_the_one_recovered_of_it_unless_that_is_of_an_earlier_drive(torn):
    assert DriveLog(torn).notes[0].endswith(f"`fcw recover {torn}` makes a complete log of it")
    out = recovered_path(torn)
    recover(torn, out)
    assert DriveLog(torn).notes[0].endswith(f"{out} is the complete log recovered from it")
    os.utime(out, ns=(0, torn.stat().st_mtime_ns - 1))
    assert "`fcw recover" in DriveLog(torn).notes[0]
    with pytest.raises(UserError, match=r"name another file with --out$"):
        recover(torn, out)


def test_the_command_on_a_whole_log_says_that_nothing_was_lost(whole_log, tmp_path, capsys):
    assert main(["recover", str(whole_log), "--out", str(tmp_path / "new.mcap")]) == 0
    assert "the log is complete: nothing was lost, and nothing was written" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == [whole_log]


def test_the_command_on_what_is_no_log(tmp_path, capsys):
    assert main(["recover", str(tmp_path)]) == 2
    assert "drive.mcap: cannot read the log (No such file or directory)" in capsys.readouterr().err
