"""Vehicles found in single pictures with a calibration whose pitch is wrong.

    python benchmarks/more_vehicles/wrong_pitch.py MORE/{judge,judge_hard,judge_later,judge_latest}

Each folder holds labels.json, images/ and calibration/ (`build.py`). Takes about six minutes on two cores.
"""

import argparse
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.detection.detector import Detection
from fcw.detection.matching import match_detections
from fcw.detection.net.detector import NetDetector, NetSettings
from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel
from fcw.detection.training.dataset import LabelledImage
from fcw.detection.training.folders import load_training_set
from fcw.errors import UserError

OFF_DEG = (0.0, -2.0, 2.0, -4.0, 4.0, -6.0, 6.0)
SIZE_TOLERANCES = (1.0, 2.0, 4.0, 6.0, math.inf)
NEAR_PART = 0.2
"""Of the picture's height, from which on a vehicle is near."""


@dataclass(slots=True)
class Tally:
    """What was found in all pictures: vehicles, near ones among them, and boxes that are none."""

    found: int = 0
    vehicles: int = 0
    near_found: int = 0
    near: int = 0
    false: int = 0

    def add(self, labelled: LabelledImage, found: tuple[Detection, ...]) -> None:
        """Take what was found in a picture."""
        boxes = np.array([(d.box.x, d.box.y, d.box.w, d.box.h) for d in found]).reshape(-1, 4)
        scores = np.array([d.score for d in found])
        matched = match_detections(boxes, scores, labelled.boxes, labelled.ignored, labelled.rear_boxes)
        hit: NDArray[np.bool_] = np.isin(np.arange(len(labelled.boxes)), matched[matched >= 0])
        near = ~labelled.ignored & (labelled.boxes[:, 3] >= NEAR_PART * labelled.size.height)
        self.found += int((hit & ~labelled.ignored).sum())
        self.vehicles += int((~labelled.ignored).sum())
        self.near_found += int((hit & near).sum())
        self.near += int(near.sum())
        self.false += int((matched == -1).sum())


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--model", type=Path, default=SHIPPED_NET_PATH)
    arguments = parser.parse_args()
    images, model = load_training_set(*arguments.folders), NetModel.load(arguments.model)
    lines = (
        "| pitch off, degrees | size tolerances | all | near | false boxes a picture |",
        "| --- " * 5 + "|",
    )
    sys.stdout.writelines(f"{line}\n" for line in lines)
    for off_deg in OFF_DEG:
        tallies = {tolerances: Tally() for tolerances in SIZE_TOLERANCES}
        for image in images:
            for tolerances, found in _found(model, _pitched(image.calibration, off_deg), image.labelled):
                tallies[tolerances].add(image.labelled, found)
        for tolerances, tally in tallies.items():
            all_part, near_part = tally.found / tally.vehicles, tally.near_found / tally.near
            false = tally.false / len(images)
            row = f"{off_deg:+.0f} | {tolerances:g} | {all_part:.3f} | {near_part:.3f} | {false:.3f}"
            sys.stdout.write(f"| {row} |\n")


def _pitched(calibration: Calibration, off_deg: float) -> Calibration:
    camera = calibration.camera
    return replace(calibration, camera=replace(camera, pitch_rad=camera.pitch_rad + math.radians(off_deg)))


def _found(
    model: NetModel, calibration: Calibration, labelled: LabelledImage
) -> Iterator[tuple[float, tuple[Detection, ...]]]:
    """By size tolerance; the nets see the picture once."""
    seen = None
    for tolerances in SIZE_TOLERANCES:
        try:
            most = min(tolerances, 1e6)  # of a box above the horizon infinity would be no number
            detector = NetDetector(model, calibration, NetSettings(size_tolerances=(most, most)))
        except UserError:  # no road in the picture
            yield tolerances, ()
            continue
        if seen is None:
            pyramid = detector.pyramid(labelled.read())
            glanced = detector.glance(pyramid)
            seen = detector.with_glance(glanced, *detector.look(pyramid, glanced))
        boxes, logits = seen
        yield tolerances, detector.decide(boxes.copy(), logits.copy())


if __name__ == "__main__":
    main()
