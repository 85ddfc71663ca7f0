"""How the time of a frame grows with the size of its picture: the shipped drive in HD, full HD and 4K.

    PYTHONPATH=benchmarks python benchmarks/speed/picture_sizes.py [--rounds 2] [--seconds 24]

Prints by size the time of a frame for decoding alone and for the whole job, by the clock, medians of rounds
in which all sizes take turns. Enlarged pictures get a little noise, as of a sensor: without it they
would be decoded too quickly. Takes five minutes on two cores, 200 MB of disk and 1.5 GB of memory.
"""

import argparse
import statistics
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import av
import cv2
import numpy as np
from lines import say, say_row, where_and_with_what

from fcw.camera.file import default_path
from fcw.job import DriveJob
from fcw.sources import open_source
from fcw_viz.benchmark.drive_cases import DECODE, RELAYED, drive_cases
from fcw_viz.benchmark.long_drive import repeat_packets
from fcw_viz.commands.demo import demo_folder

SIZES = (1280, 720), (1920, 1080), (3840, 2160)
START_S, END_S = 25.0, 33.0
"""The part of the drive that is enlarged, and then repeated: the lead brakes in it."""
NOISE_LEVELS = 2.0
CODEC_OPTIONS: dict[str, str] = {"preset": "veryfast", "crf": "24", "bf": "0"}


def main() -> None:
    """Print a row for each size."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=24.0)
    given = parser.parse_args()
    say(where_and_with_what())
    drive = demo_folder() / "drive.mp4"
    times_ms: dict[tuple[str, tuple[int, int]], list[float]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder:
        runs = {}
        for size in SIZES:
            say(f"enlarging the drive to {size[0]}x{size[1]}")
            long = Path(folder) / f"{size[1]}.mp4"
            enlarge(drive, Path(folder) / "part.mp4", size)
            repeat_packets(Path(folder) / "part.mp4", long, given.seconds)
            cases = drive_cases(DriveJob(source=long, out=Path(), calibration=default_path(drive)))
            runs |= {(case, size): cases[case] for case in (DECODE, RELAYED)}
        for number in range(given.rounds + 1):  # the first is not counted: kernels may compile in it
            say(f"round {number} of {given.rounds}")
            for name, run in runs.items():
                start = time.perf_counter()
                frames = run()
                if number > 0:
                    times_ms[name].append(1e3 * (time.perf_counter() - start) / frames)
    say_row(("pictures", "decoding alone, ms", "whole job, ms", "frames a second"), head=True)
    for size in SIZES:
        decode_ms, job_ms = (statistics.median(times_ms[case, size]) for case in (DECODE, RELAYED))
        say_row((f"{size[0]}x{size[1]}", f"{decode_ms:.1f}", f"{job_ms:.1f}", f"{1e3 / job_ms:.0f}"))


def enlarge(drive: Path, out: Path, size: tuple[int, int]) -> None:
    """Write a part of a drive with pictures of another size."""
    rng = np.random.default_rng(0)
    noises = [rng.normal(0, NOISE_LEVELS, (size[1], size[0], 1)) for _ in range(4)]
    source = open_source(drive)
    with av.open(str(out), "w") as container:
        stream = container.add_stream("libx264", rate=round(source.frame_rate_hz))
        stream.width, stream.height, stream.pix_fmt, stream.gop_size = *size, "yuv420p", 30
        stream.options = dict(CODEC_OPTIONS)
        for frame in source.frames(round(START_S * 1e9)):
            if frame.time_ns > END_S * 1e9:
                break
            large = cv2.resize(frame.image, size, interpolation=cv2.INTER_CUBIC)
            noisy = np.clip(large + noises[frame.index % len(noises)], 0, 255).astype(np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(noisy, format="bgr24")))
        container.mux(stream.encode(None))


if __name__ == "__main__":
    main()
