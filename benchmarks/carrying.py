"""What carrying by the picture costs: time of the tracker's thread with and without pictures.

    python benchmarks/carrying.py [--vehicles 3]

The shipped drive, 1280x720; the nearest vehicles of its truth stand for detections, every fifth frame without
any, so that all are carried then. Both trackers take turns, frame by frame.
"""

import argparse
import csv
import datetime
import platform
import statistics
import sys
import time
from collections import defaultdict
from pathlib import Path

from fcw.box import Box
from fcw.camera.file import read_calibration
from fcw.detection.detector import Detection
from fcw.sources import open_source
from fcw.threads import one_opencv_thread
from fcw.tracking.tracker import Tracker
from fcw.versions import versions

DRIVE = Path(__file__).parents[1] / "recordings" / "demo"
SEEN_FRACTION = 0.7


def nearest_vehicles(path: Path, count: int) -> dict[int, list[Detection]]:
    """By frame the boxes of the nearest vehicles that are in sight, where there are so many."""
    found: defaultdict[int, list[tuple[float, Detection]]] = defaultdict(list)
    with path.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["vehicle"] and float(row["visible_fraction"]) >= SEEN_FRACTION:
                box = Box(*(float(row[name]) for name in ("box_x", "box_y", "box_w", "box_h")))
                found[int(row["frame"])].append((float(row["distance_m"]), Detection(box, 9.0)))
    return {
        frame: [detection for _, detection in sorted(vehicles, key=lambda pair: pair[0])[:count]]
        for frame, vehicles in found.items()
    }


def main() -> None:
    """Print the median and the 95th percentile of both, and of the difference."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--vehicles", type=int, default=3)
    count = parser.parse_args().vehicles
    calibration = read_calibration(DRIVE / "drive.calibration.yaml")
    vehicles = nearest_vehicles(DRIVE / "truth.csv", count)
    trackers = {with_picture: Tracker(calibration) for with_picture in (False, True)}
    spent_ms: dict[bool, list[float]] = {False: [], True: []}
    with one_opencv_thread():
        for frame in open_source(DRIVE / "drive.mp4").frames():
            detections = vehicles.get(frame.index, []) if frame.index % 5 else []
            tracks = ()
            for with_picture, tracker in trackers.items():
                before = time.thread_time()
                tracks = tracker.update(
                    frame.time_ns, detections, image=frame.image if with_picture else None
                )
                spent_ms[with_picture].append((time.thread_time() - before) * 1e3)
            if len(tracks) != count:
                for times in spent_ms.values():
                    times.pop()
    more_ms = [after - before for before, after in zip(spent_ms[False], spent_ms[True], strict=True)]
    software = ", ".join(f"{name} {version}" for name, version in versions().items())
    sys.stdout.write(
        f"{datetime.date.today()} {platform.processor() or platform.machine()}, {software}\n"
        f"{len(more_ms)} frames with {count} vehicles, ms of thread time a frame: median, 95th percentile\n"
    )
    for name, times in (
        ("boxes alone", spent_ms[False]),
        ("with pictures", spent_ms[True]),
        ("more", more_ms),
    ):
        sys.stdout.write(
            f"  {name:14s} {statistics.median(times):.2f} {statistics.quantiles(times, n=20)[18]:.2f}\n"
        )


if __name__ == "__main__":
    main()
