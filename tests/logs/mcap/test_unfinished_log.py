"""Logs whose writer was killed, and files that are no logs."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.writer import Writer
from running.tiny_nets import write_quick_net

from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.recovery import recover

KILLED_WRITER = """
import os, signal, sys
from pathlib import Path
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
whole = DriveLog(Path(sys.argv[1]))
sink = McapSink(Path(sys.argv[2]))
sink.open(whole.header)
for result, packets in whole.entries():
    sink.write(result, packets)
    if result.index == 57:
        os.kill(os.getpid(), signal.SIGKILL)
"""

TELLING_RUN = """
import sys
from fcw.logs.mcap.writer import McapSink
from fcw_viz.cli import main
write = McapSink.write
def telling(sink, result, packets):
    print(result.time_ns, flush=True)
    write(sink, result, packets)
McapSink.write = telling
sys.exit(main())
"""


def test_a_killed_writer_loses_half_a_second_at_most(whole_log, header, short_drive, tmp_path):
    path = tmp_path / "killed.mcap"
    root = Path(__file__).parents[3]
    run = subprocess.run(
        [sys.executable, "-c", KILLED_WRITER, str(whole_log), str(path)],
        cwd=root,
        env={**os.environ, "PYTHONPATH": str(root)},
        check=False,
        timeout=120,
    )
    assert run.returncode == -signal.SIGKILL
    log = DriveLog(path)
    assert not log.complete
    assert log.header == header
    entries = list(log.entries())
    assert [result for result, _ in entries] == [result for result, _ in short_drive[: len(entries)]]
    assert 58 - 3 <= len(entries) <= 58
    with_pictures = [(result, packets) for result, packets in entries if packets]
    assert with_pictures == short_drive[: len(with_pictures)]
    assert 58 - 5 <= len(with_pictures) <= len(entries)


@pytest.mark.slow
@pytest.mark.parametrize("lines", [20, 333])
def test_a_killed_run_loses_half_a_second_at_most_and_is_made_whole(tmp_path, lines: int):
    root = Path(__file__).parents[3]
    run = subprocess.Popen(
        [
            sys.executable,
            "-c",
            TELLING_RUN,
            "run",
            "--detector",
            f"onnx:{write_quick_net(tmp_path / 'quick.onnx')}",
            str(root / "recordings/demo/drive.mp4"),
            "--out",
            tmp_path,
        ],
        cwd=root,
        env={**os.environ, "PYTHONPATH": str(root)},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert run.stdout is not None
    with run.stdout as told:
        times_ns = [int(told.readline()) for _ in range(lines)]
        run.kill()
        times_ns += [int(line) for line in told if line.endswith("\n")]
    assert run.wait() == -signal.SIGKILL
    log = DriveLog(tmp_path / "drive.mcap")
    assert not log.complete
    results = list(log.results())
    assert [result.time_ns for result in results] == times_ns[: len(results)]
    assert times_ns[-1] - results[-1].time_ns <= 500_000_000
    pictures_ns = [packet.time_ns for packet in log.video_packets() if packet.shown]
    assert pictures_ns == times_ns[: len(pictures_ns)]
    assert times_ns[-1] - max(pictures_ns, default=0) <= 500_000_000
    report = recover(tmp_path / "drive.mcap", tmp_path / "whole.mcap")
    assert (report.frames, report.pictures) == (len(results), len(pictures_ns))
    assert list(DriveLog(tmp_path / "whole.mcap").entries()) == list(log.entries())


@pytest.mark.slow
def test_a_log_torn_anywhere_gives_all_before_the_tear(whole_log, header, short_drive, tmp_path):
    data = whole_log.read_bytes()
    path = tmp_path / "torn.mcap"
    counts: list[int] = []
    for length in range(len(data) - 1, 2000, -max(1, len(data) // 150)):
        path.write_bytes(data[:length])
        log = DriveLog(path)
        assert not log.complete
        assert log.header == header
        read = list(log.entries())
        assert [result for result, _ in read] == [result for result, _ in short_drive[: len(read)]]
        assert list(log.results()) == [result for result, _ in read]
        with_pictures = [(result, packets) for result, packets in read if packets]
        assert with_pictures == short_drive[: len(with_pictures)]
        assert len(log.series()) == len(read)
        counts.append(len(read))
    assert counts == sorted(counts, reverse=True)
    assert counts[0] == len(short_drive)


def test_a_torn_log_says_so_and_how_much_can_be_read(whole_log, tmp_path):
    path = tmp_path / "torn.mcap"
    data = whole_log.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    log = DriveLog(path)
    results = list(log.results())
    pictures = [packet for packet in log.video_packets() if packet.shown]
    (note,) = log.notes
    assert note.startswith(f"{path}: its writer was stopped before it closed the log; ")
    assert f"signals can be read up to {results[-1].time_ns / 1e9:.2f} s" in note
    assert f"pictures up to {pictures[-1].time_ns / 1e9:.2f} s" in note
    assert f"`fcw recover {path}`" in note
    assert DriveLog(whole_log).notes == ()
    path.write_bytes(data[: DriveLog(whole_log).chunks.chunks[0].chunk_start_offset + 20])
    (note,) = DriveLog(path).notes
    assert note.endswith("no frame can be read")


def test_zeros_of_a_power_cut_are_passed_over(whole_log, short_drive, tmp_path):
    path = tmp_path / "torn.mcap"
    data = whole_log.read_bytes()
    path.write_bytes(data[: len(data) // 2] + bytes(5000))
    results = list(DriveLog(path).results())
    assert len(results) > 30
    assert results == [result for result, _ in short_drive[: len(results)]]


def test_a_damaged_log_is_said_to_be(whole_log):
    data = bytearray(whole_log.read_bytes())
    for at in range(len(data) // 2, len(data) // 2 + 40):
        data[at] ^= 0x55
    whole_log.write_bytes(data)
    with pytest.raises(UserError, match=r"drive\.mcap: the log is damaged"):
        list(DriveLog(whole_log).results())


def refusal(path: Path) -> str:
    with pytest.raises(UserError) as caught:
        DriveLog(path)
    assert str(caught.value).startswith(f"{path}: ")
    return str(caught.value)


def test_a_missing_log(tmp_path):
    assert "cannot read the log (No such file or directory)" in refusal(tmp_path / "drive.mcap")


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", b"no log" * 100, b"\x89MCAP0\r\n" + b"\xff" * 99])
def test_a_file_that_is_no_log(tmp_path, content: bytes):
    path = tmp_path / "drive.mcap"
    path.write_bytes(content)
    words = "not a drive log, or one cut off at its start (" if content else "an empty file; expected"
    assert words in refusal(path)
    assert "()" not in refusal(path)


def test_the_mcap_of_others(tmp_path):
    path = tmp_path / "robot.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/a", "json", writer.register_schema("a", "jsonschema", b"{}"))
        writer.add_message(channel, 1, b"{}", 1)
        writer.finish()
    assert "an MCAP file, but no drive log of fcw" in refusal(path)


def test_a_log_of_a_later_version(whole_log):
    data = whole_log.read_bytes()
    field, version = b"\x0e\0\0\0format_version\x01\0\0\0", b"1"
    assert data.count(field + version) == 1
    whole_log.write_bytes(data.replace(field + version, field + b"9"))
    assert "drive log of format version 9, expected 1" in refusal(whole_log)
