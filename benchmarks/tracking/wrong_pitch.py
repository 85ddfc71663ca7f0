"""Vehicles found with a calibration whose pitch is wrong: with fixed windows, and in a whole run.

    FCW_DATA=DIR PYTHONPATH=benchmarks python benchmarks/tracking/wrong_pitch.py [--detector net]

The right calibrations are those of `calibrations.txt`. Counted are the boxes that the right calibration finds
and another one finds as well (IoU 0.5), in every 15th picture from the fifth to the fifteenth second of each
clip. "Follows" is `fcw run`, which looks where own motion and vehicles say that the camera looks. Takes about
twenty minutes.
"""

import argparse
import math
import sys
import tempfile
import threading
from dataclasses import replace
from pathlib import Path

from real_drives import data_folder

import fcw
from fcw.box import Box, shared_area
from fcw.camera.calibration import Calibration
from fcw.detection.choice import load_model, make_detector
from fcw.detection.training.own_data import read_calibration_table
from fcw.sources import open_source

CLIPS = ("kb_dashcam1", "kb_dashcam2", "tmo_seattlestreet2", "solidWhiteRight")
OFF_DEG = (-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0)
EVERY, SETTLED_S, LONGEST_S = 15, 5.0, 15.0
SAME_IOU = 0.5

Found = dict[int, list[Box]]
"""Boxes by the number of the picture."""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--detector", default="net")
    detector = parser.parse_args().detector
    data = data_folder()
    table = read_calibration_table(data / "calibrations.txt")
    totals = {off_deg: [0, 0, 0, 0] for off_deg in OFF_DEG}
    for number, clip in enumerate(CLIPS, start=1):
        say(f"{number} of {len(CLIPS)}: {clip}")
        path = data / "clips" / f"{clip}.mp4"
        cameras = {off_deg: turned(table[clip], off_deg) for off_deg in OFF_DEG}
        looks = {
            off_deg: (fixed(path, camera, detector), follows(path, camera, detector))
            for off_deg, camera in cameras.items()
        }
        for off_deg, (by_fixed, by_run) in looks.items():
            for place, (found, truth) in enumerate(((by_fixed, looks[0.0][0]), (by_run, looks[0.0][1]))):
                totals[off_deg][2 * place] += matched(found, truth)
                totals[off_deg][2 * place + 1] += sum(map(len, truth.values()))
    say("off by, degrees   windows fixed   follows")
    for off_deg, (fixed_found, fixed_all, run_found, run_all) in totals.items():
        say(f"{off_deg:+15.0f} {fixed_found / fixed_all:15.0%} {run_found / run_all:9.0%}")


def say(text: str) -> None:
    """A line of the report."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def turned(right: Calibration, off_deg: float) -> Calibration:
    """The same camera, believed to look so much farther down than it does."""
    camera = replace(right.camera, pitch_rad=right.camera.pitch_rad + math.radians(off_deg))
    return Calibration.from_camera(camera, right.image_size)


def fixed(path: Path, calibration: Calibration, name: str) -> Found:
    """By the detector alone."""
    detector = make_detector(name, load_model(name), calibration)
    found: Found = {}
    for frame in open_source(path).frames():
        if frame.time_ns > LONGEST_S * 1e9:
            break
        if frame.index % EVERY == 0 and frame.time_ns >= SETTLED_S * 1e9:
            found[frame.index] = [detection.box for detection in detector.detect(frame.image)]
    return found


def follows(path: Path, calibration: Calibration, name: str) -> Found:
    """By a run."""
    stop = threading.Event()
    found: Found = {}

    def take(result: fcw.FrameResult) -> None:
        if result.time_ns > LONGEST_S * 1e9:
            stop.set()
        elif result.index % EVERY == 0 and result.time_ns >= SETTLED_S * 1e9:
            found[result.index] = [detection.box for detection in result.detections]

    with tempfile.TemporaryDirectory() as folder:
        job = fcw.DriveJob(source=path, out=Path(folder) / "drive", calibration=calibration, detector=name)
        fcw.run_drive(job, stop=stop, on_result=take)
    return found


def matched(found: Found, truth: Found) -> int:
    """How many boxes of the truth were found."""
    return sum(
        any(overlap(box, other) >= SAME_IOU for other in found.get(index, ()))
        for index, boxes in truth.items()
        for box in boxes
    )


def overlap(one: Box, other: Box) -> float:
    """Intersection over union."""
    shared = shared_area(one, other)
    return shared / (one.w * one.h + other.w * other.h - shared)


if __name__ == "__main__":
    main()
