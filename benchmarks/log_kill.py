"""What a killed run leaves: kill -9 at random moments of `fcw run`, then what its log still holds.

    python benchmarks/log_kill.py SOURCE [--calibration FILE] [--kills 10] [--seed 0]

The run is a process of its own that tells each frame before it is written. Lost is the drive's time between
the last frame told and the last one in the log.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from lines import say, where_and_with_what

from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.recovery import recover

TELLING_RUN = """
import os, sys
from fcw.logs.mcap.writer import McapSink
from fcw_viz.cli import main
write, pipe = McapSink.write, int(sys.argv[1])
def telling(sink, result, packets):
    os.write(pipe, b"%d\\n" % result.time_ns)
    write(sink, result, packets)
McapSink.write = telling
sys.exit(main(sys.argv[2:]))
"""


def run(arguments: list[str], kill_after_s: float | None) -> tuple[list[int], float]:
    """Run `fcw` with some arguments; frames' times as they were told, and seconds from the first to the end.

    Args:
        arguments: of the command line.
        kill_after_s: after the first frame; None lets it come to its end.
    """
    reading, writing = os.pipe()
    process = subprocess.Popen(
        [sys.executable, "-c", TELLING_RUN, str(writing), *arguments],
        pass_fds=[writing],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(writing)
    with os.fdopen(reading) as lines:
        first = lines.readline()
        started = time.perf_counter()
        if kill_after_s is not None:
            time.sleep(kill_after_s)
            process.send_signal(signal.SIGKILL)
        times_ns = [int(line) for line in (first, *lines) if line.endswith("\n")]
    process.wait()
    return times_ns, time.perf_counter() - started


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("source", type=Path)
    parser.add_argument("--calibration", type=Path)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    say(where_and_with_what())
    rng = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["run", str(options.source), "--out", folder]
        if options.calibration:
            arguments += ["--calibration", str(options.calibration)]
        times_ns, whole_s = run(arguments, None)
        say(f"{options.source}: {len(times_ns)} frames in {whole_s:.1f} s")
        say("killed at  frames told  in the log  signals lost  pictures lost  recovered")
        worst_signals_s = worst_pictures_s = 0.0
        for _ in range(options.kills):
            after_s = rng.uniform(0, whole_s)
            times_ns, _ = run(arguments, after_s)
            path, out = Path(folder) / "drive.mcap", Path(folder) / "recovered.mcap"
            out.unlink(missing_ok=True)
            log = DriveLog(path)
            results = list(log.results())
            shown_ns = [packet.time_ns for packet in log.video_packets() if packet.shown]
            start_ns = times_ns[0]
            last_ns = results[-1].time_ns if results else start_ns
            signals_s = (times_ns[-1] - last_ns) / 1e9
            pictures_s = (times_ns[-1] - max(shown_ns, default=start_ns)) / 1e9
            worst_signals_s = max(worst_signals_s, signals_s)
            worst_pictures_s = max(worst_pictures_s, pictures_s)
            said = f"{len(times_ns):11}  {len(results):10}  {signals_s:10.3f} s  {pictures_s:11.3f} s"
            if results:
                report = recover(path, out)  # re-reads all with mcap's readers, checksums and counts included
                recovered = f"{report.frames} frames, {report.pictures} pictures"
                assert not report.written or list(DriveLog(out).entries()) == list(log.entries())
            else:
                recovered = "nothing to recover"
            say(f"{after_s:7.2f} s  {said}  {recovered}{'' if not log.complete else ' (had ended)'}")
    say(f"at most {worst_signals_s:.3f} s of signals and {worst_pictures_s:.3f} s of pictures lost")


if __name__ == "__main__":
    main()
