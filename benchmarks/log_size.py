"""How much the logs of a drive weigh beside its video.

    python benchmarks/log_size.py VIDEO [--calibration FILE]

Runs the whole job and prints the bytes a frame of drive.mcap and drive.rrd beyond those of the video in them.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from fcw.job import DriveJob
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME, RRD_NAME
from fcw_viz.console import MESSAGES
from fcw_viz.jobs.drive import run_on_console


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("video", type=Path)
    parser.add_argument("--calibration", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        frames = run_on_console(DriveJob(arguments.video, out, arguments.calibration), MESSAGES).summary[
            "frames"
        ]
        log = DriveLog(out / MCAP_NAME)
        video = sum(len(packet.data) for packet in log.video_packets())
        relayed = "relayed" if log.header.relays_video else "encoded anew"
        sys.stdout.write(
            f"{arguments.video.name}: {frames} frames, video {relayed}, {video / frames:.0f} B a frame\n"
        )
        for name in (MCAP_NAME, RRD_NAME):
            more = ((out / name).stat().st_size - video) / frames
            sys.stdout.write(f"  {name}: {more:.0f} B a frame more\n")


if __name__ == "__main__":
    main()
