"""Draws the SFND drive: distance and TTC of the program, end to end from pixels, beside the lidar's.

    FCW_DATA=DIR python docs/chart_sfnd.py CALIBRATION docs/images

The lidar's closing speed is the slope of a straight line through its distances of a second about each frame.
"""

import argparse
import csv
import math
import os
import sys
from pathlib import Path

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.camera.file import read_calibration
from fcw.camera.ground_plane import FloatArray
from fcw.charts.chart import Chart, Series
from fcw.detection.choice import NET, load_model, make_detector
from fcw.sources import open_source
from fcw.tracking.tracker import Tracker

FRAME_RATE_HZ = 9.65
HALF_WINDOW_S = 0.5
LONGEST_TTC_S = 20.0


def main() -> None:
    """Read the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("calibration", type=Path, help="file of the drive's calibration")
    parser.add_argument("out", type=Path, help="folder for sfnd-distance.svg and sfnd-ttc.svg")
    options = parser.parse_args()
    data = os.environ.get("FCW_DATA")
    if not data:
        sys.exit("FCW_DATA is not set: set it to the folder of real drives")
    draw(Path(data) / "kitti-sfnd", options.calibration, options.out)


def draw(folder: Path, calibration_path: Path, out: Path) -> None:
    """Run the drive, print how well it went, and write sfnd-distance.svg and sfnd-ttc.svg."""
    with (folder / "lead_lidar_distance.csv").open(encoding="utf-8") as file:
        lidar_m = np.array([float(row["cam_z_p10_m"] or "nan") for row in csv.DictReader(file)])
    times_s = np.arange(len(lidar_m)) / FRAME_RATE_HZ
    lidar_ttc_s = ttc_of(times_s, lidar_m)
    distance_m, ttc_s = followed(folder, read_calibration(calibration_path), len(lidar_m))
    for what, estimated, true in (("distance", distance_m, lidar_m), ("TTC", ttc_s, lidar_ttc_s)):
        known = np.isfinite(estimated) & np.isfinite(true) & (true <= LONGEST_TTC_S)
        error = np.median(np.abs(estimated[known] / true[known] - 1))
        sys.stdout.write(f"{what}: {known.sum()} of {len(lidar_m)} frames, median error {error:.1%}\n")
    duration_s = math.ceil(times_s[-1])
    for name, label, highest, estimated, true in (
        ("sfnd-distance", "distance from the camera, m", 10.0, distance_m, lidar_m),
        ("sfnd-ttc", "TTC, s", LONGEST_TTC_S, ttc_s, lidar_ttc_s),
    ):
        series = (
            Series("lidar", list(zip(times_s.tolist(), true.tolist(), strict=True)), line=True),
            Series("from pixels", list(zip(times_s.tolist(), estimated.tolist(), strict=True))),
        )
        chart = Chart("SFND drive, end to end", "s", label, (0.0, duration_s), (0.0, highest), series)
        (out / f"{name}.svg").write_text(chart.svg(), encoding="utf-8")


def followed(folder: Path, calibration: Calibration, count: int) -> tuple[FloatArray, FloatArray]:
    """Distance from the camera and TTC of the lead at every frame; nan where there is none."""
    detector = make_detector(NET, load_model(NET), calibration, for_tracker=True)
    tracker = Tracker(calibration)
    rows = np.full((count, 2), math.nan)
    for index, frame in zip(range(count), open_source(folder / "images").frames(), strict=False):
        time_ns, found = round(index / FRAME_RATE_HZ * 1e9), detector.detect(frame.image)
        tracks = tracker.update(time_ns, found, image=frame.image)
        lead = next((track for track in tracks if track.track_id == tracker.lead_id), None)
        if lead is not None:
            camera_m = lead.distance_m + calibration.reference_offset_m
            rows[index] = camera_m, camera_m / lead.closing_speed_mps if lead.ttc_s else math.nan
    return rows[:, 0], rows[:, 1]


def ttc_of(times_s: FloatArray, distances_m: FloatArray) -> FloatArray:
    """TTC by distances alone; nan where the gap does not close, or too few are known."""
    ttc_s = np.full(len(times_s), math.nan)
    for index, time_s in enumerate(times_s):
        near = (np.abs(times_s - time_s) <= HALF_WINDOW_S) & np.isfinite(distances_m)
        if near.sum() >= 3:
            closing_mps = -np.polyfit(times_s[near], distances_m[near], 1)[0]
            ttc_s[index] = distances_m[index] / closing_mps if closing_mps > 0 else math.nan
    return ttc_s


if __name__ == "__main__":
    main()
