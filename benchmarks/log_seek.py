"""How fast an hour's log opens, and jumps to a picture.

    python benchmarks/log_seek.py DRIVE.mcap [--hours 1] [--seed 0]

Makes the long log by repeating a drive in a scratch folder: its packets as they are, and encoded anew. Each
jump is to a random frame, and ends with its picture decoded. Where a machine has other work, the processor
time says what a jump takes without it.
"""

import argparse
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from lines import say, where_and_with_what

from fcw.frame import Frame, VideoPacket
from fcw.logs.encode import VideoEncoder
from fcw.logs.events import find_events
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.pictures import LogPictures
from fcw.logs.records import FrameResult

Entry = tuple[FrameResult, tuple[VideoPacket, ...]]


def encoded_anew(log: DriveLog) -> list[Entry]:
    """A drive's entries with its pictures encoded as we do it."""
    encoder = VideoEncoder(log.header.image_size, log.header.frame_rate_hz)
    pictures = LogPictures(log)
    entries: list[Entry] = []
    for result in log.results():
        frame = Frame(result.index, result.time_ns, np.ascontiguousarray(pictures.at(result.index)))
        entries.append((result, encoder.encode(frame)))
    encoder.close()
    return entries


def repeated(entries: list[Entry], duration_s: float, period_ns: int) -> Iterator[Entry]:
    """The entries again and again, numbered and timed on."""
    span_ns = entries[-1][0].time_ns - entries[0][0].time_ns + period_ns
    for lap in range(int(np.ceil(duration_s * 1e9 / span_ns))):
        for result, packets in entries:
            moved = replace(
                result, index=lap * len(entries) + result.index, time_ns=result.time_ns + lap * span_ns
            )
            # Packets that only feed the decoder before the first frame would run into the lap before.
            own = packets if lap == 0 else packets[-1:] if not packets[0].keyframe else packets
            yield moved, tuple(replace(packet, time_ns=packet.time_ns + lap * span_ns) for packet in own)


def report(path: Path, seed: int, jumps: int) -> None:
    """Print what opening, events and jumps take."""
    started = time.perf_counter()
    log = DriveLog(path)
    series = log.series()
    opened_s = time.perf_counter() - started
    started = time.perf_counter()
    events = find_events(series)
    events_s = time.perf_counter() - started
    started = time.perf_counter()
    chunks = log.chunks.chunks
    index_s = time.perf_counter() - started
    size = path.stat().st_size
    say(
        f"  {len(series)} frames, {series.duration_s / 3600:.2f} h, {size / 1e6:.0f} MB, {len(chunks)} chunks"
    )
    say(f"  keyframes every {np.median(np.diff(series.keyframe_ns)) / 1e9:.2f} s (median)")
    say(
        f"  header and series: {opened_s * 1e3:.0f} ms; {len(events)} events: {events_s * 1e3:.0f} ms; "
        f"index of chunks: {index_s * 1e3:.0f} ms"
    )
    rng = np.random.default_rng(seed)
    pictures = LogPictures(log)
    for what, read in (("picture", pictures.at), ("result", log.result_at)):
        times_ms: list[float] = []
        own_ms: list[float] = []
        for frame in rng.choice(series.frame_index, jumps):
            started, own = time.perf_counter(), time.process_time()
            read(int(frame))
            times_ms.append((time.perf_counter() - started) * 1e3)
            own_ms.append((time.process_time() - own) * 1e3)
        median, p90, most = np.quantile(times_ms, (0.5, 0.9, 1.0))
        say(
            f"  random {what}: {median:.0f} ms median, {p90:.0f} ms p90, {most:.0f} ms at most, of {jumps}; "
            f"processor time {np.median(own_ms):.0f} ms median"
        )


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("drive", type=Path)
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--jumps", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    say(where_and_with_what())
    log = DriveLog(options.drive)
    say(f"{options.drive}: {log.header.image_size}, {log.header.frame_rate_hz:.2f} frames/s")
    period_ns = round(1e9 / log.header.frame_rate_hz)
    with tempfile.TemporaryDirectory() as folder:
        for what, entries in (("as it is", list(log.entries())), ("encoded anew", encoded_anew(log))):
            say(f"{what}:")
            path = Path(folder) / "drive.mcap"
            sink = McapSink(path)
            sink.open(log.header)
            started = time.perf_counter()
            for result, packets in repeated(entries, options.hours * 3600, period_ns):
                sink.write(result, packets)
            sink.close()
            count = len(DriveLog(path).series())
            say(f"  written in {(time.perf_counter() - started) / count * 1e3:.2f} ms a frame")
            report(path, options.seed, options.jumps)


if __name__ == "__main__":
    main()
