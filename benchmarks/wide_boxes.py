"""How often a box is none of a vehicle, by how wide it is for its height; what a wide one should count for.

    FCW_DATA=DIR python benchmarks/wide_boxes.py [--model FILE]

In all completely labelled pictures, most of which the net learnt from. A box is a vehicle's, from whatever
side it is seen, if it overlaps a labelled one, counted or not, by IoU 0.5, and nobody's if less than half of
it lies in any. First, whose the boxes are that the net finds at every score without the bonus of
`NetSettings.wide_bonus`; then how well a logistic model of that foretells boxes of cameras left out, by
bonus; last, what is found at the score of `fcw run` without the bonus and with it, by the side that is seen.
Takes two minutes on one core.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from lines import say, say_row, where_and_with_what
from numpy.typing import NDArray
from real_drives import data_folder
from rich.console import Console
from rich.progress import track
from scipy.optimize import minimize

from fcw.detection.boxes.overlap import intersection_areas, intersection_over_union
from fcw.detection.matching import HIT_IOU, IGNORED_PART
from fcw.detection.net.detector import NetDetector, NetSettings, doublings
from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel
from fcw.errors import UserError
from fcw.evaluation.detection.cameras import LabelledCameras, read_cameras
from fcw.evaluation.detection.labels import AnnotatedImage

LOWEST_LOGIT = -1.5
LOGITS = (LOWEST_LOGIT, 0.0, 0.75, 1.5, 2.25)
ASPECTS = (0.0, 1.2, 1.5, 1.7, 1.9)
BONUSES = (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
USUAL = NetSettings()
NOBODY = "nobody"
SIDES = ("rear", "rear-quarter", "front", "side", "unclear", "not said", NOBODY)


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """What was found, but for boxes of which it is not said whether they show a vehicle.

    Attributes:
        cameras: (N,) whose pictures they are in.
        logits: (N,) by the net.
        aspects: (N,) width over height.
        vehicle: (N,) whether they show one.
    """

    cameras: NDArray[np.str_]
    logits: NDArray[np.float64]
    aspects: NDArray[np.float64]
    vehicle: NDArray[np.bool_]

    @property
    def doublings(self) -> NDArray[np.float64]:
        """(N,) what `NetSettings.wide_bonus` is multiplied by."""
        return doublings(self.aspects, USUAL.wide_aspect, USUAL.widest_aspect)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--model", type=Path, default=SHIPPED_NET_PATH)
    arguments = parser.parse_args()
    data = data_folder()
    cv2.setNumThreads(1)
    try:
        boxes, tallies = look_at(NetModel.load(arguments.model), read_cameras(data))
    except UserError as error:
        sys.exit(str(error))
    say(where_and_with_what())
    print_counts(boxes)
    print_fits(boxes)
    print_tallies(tallies)


def look_at(model: NetModel, cameras: LabelledCameras) -> tuple[Boxes, Mapping[float, Counter[str]]]:
    """All boxes without the bonus, and by bonus, how often which side is found at the model's score."""
    rows, tallies = [], {bonus: Counter[str]() for bonus in (0.0, USUAL.wide_bonus)}
    every_score = NetSettings(wide_bonus=0.0, score_threshold=LOWEST_LOGIT)
    images = [image for image in cameras.images if image.labelled.complete]
    for image in track(images, "detecting", console=Console(stderr=True)):
        calibration = cameras.calibration_of(image.labelled)
        detector = NetDetector(model, calibration, every_score)
        pyramid = detector.pyramid(image.labelled.read())
        glanced = detector.glance(pyramid)
        seen = detector.with_glance(glanced, *detector.look(pyramid, glanced))
        boxes, logits = decided(detector, *seen)
        shown = whose(image, boxes)
        told = shown != ""
        names = np.full(len(boxes), image.labelled.camera)
        vehicle = shown != NOBODY
        rows.append([each[told] for each in (names, logits, boxes[:, 2] / boxes[:, 3], vehicle)])
        for bonus, tally in tallies.items():
            boxes, _ = decided(NetDetector(model, calibration, NetSettings(wide_bonus=bonus)), *seen)
            tally.update(whose(image, boxes).tolist())
    return Boxes(*(np.concatenate(column) for column in zip(*rows, strict=True))), tallies


def decided(
    detector: NetDetector, boxes: NDArray[np.float64], logits: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N, 4) boxes and (N,) logits that a detector makes of what the nets saw."""
    found = detector.decide(boxes.copy(), logits.copy())
    rows = np.array([(d.box.x, d.box.y, d.box.w, d.box.h, d.score) for d in found]).reshape(-1, 5)
    return rows[:, :4], rows[:, 4]


def whose(image: AnnotatedImage, boxes: NDArray[np.float64]) -> NDArray[np.str_]:
    """(N,) the side from which each box shows a vehicle, NOBODY, or empty where that is not said."""
    labels, shown = image.labelled.boxes, np.full(len(boxes), NOBODY, "U16")
    if not len(labels):
        return shown
    overlap = intersection_over_union(boxes, labels)
    covered = intersection_areas(boxes, labels) / np.prod(boxes[:, 2:], axis=1)[:, None]
    shown[covered.max(axis=1) >= IGNORED_PART] = ""
    for box in np.flatnonzero(overlap.max(axis=1) >= HIT_IOU):
        shown[box] = image.attributes[int(overlap[box].argmax())].get("view") or "not said"
    return shown


def print_counts(boxes: Boxes) -> None:
    say("\nBoxes of nobody, of all, by width over height and logit\n")
    say_row(["width over height", *(f"logit from {logit:g}" for logit in LOGITS)], head=True)
    aspect_bins, logit_bins = np.digitize(boxes.aspects, ASPECTS), np.digitize(boxes.logits, LOGITS)
    for number, aspect in enumerate(ASPECTS, start=1):
        cells = []
        for column in range(1, len(LOGITS) + 1):
            here = boxes.vehicle[(aspect_bins == number) & (logit_bins == column)]
            cells.append(f"{np.sum(~here)} of {len(here)}")
        say_row([f"from {aspect:g}", *cells])


def print_fits(boxes: Boxes) -> None:
    """By bonus: negative log likelihood of boxes by a logistic model of those of all other cameras."""
    names = sorted(set(boxes.cameras.tolist()))
    say("\nHow unlikely the boxes of cameras left out are (negative log likelihood), by bonus\n")
    columns = [f"{name}: {np.sum(boxes.cameras == name)} boxes" for name in names]
    say_row(["bonus", *columns, "all"], head=True)
    for bonus in BONUSES:
        inputs = np.column_stack([np.ones_like(boxes.logits), boxes.logits + bonus * boxes.doublings])
        surprises = []
        for name in names:
            tested = boxes.cameras == name
            weights = fit(inputs[~tested], boxes.vehicle[~tested])
            surprises.append(surprise(weights, inputs[tested], boxes.vehicle[tested]))
        say_row([f"{bonus:g}", *(f"{each:.1f}" for each in (*surprises, sum(surprises)))])


def fit(inputs: NDArray[np.float64], vehicle: NDArray[np.bool_]) -> NDArray[np.float64]:
    start = np.eye(1, inputs.shape[1], 1)[0]
    return np.asarray(minimize(surprise, start, args=(inputs, vehicle)).x)


def surprise(weights: NDArray[np.float64], inputs: NDArray[np.float64], vehicle: NDArray[np.bool_]) -> float:
    logits = inputs @ weights
    return float(np.sum(np.logaddexp(0.0, logits) - vehicle * logits))


def print_tallies(tallies: Mapping[float, Counter[str]]) -> None:
    say("\nBoxes at the model's score, by the side from which they show a vehicle\n")
    say_row(["bonus", *SIDES], head=True)
    for bonus, tally in tallies.items():
        say_row([f"{bonus:g}", *(tally[side] for side in SIDES)])


if __name__ == "__main__":
    main()
