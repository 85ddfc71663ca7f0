"""Training folders from public datasets, which `net` learns from beside the project's own data.

    python benchmarks/more_vehicles/build.py CLONES OUT
    fcw train --data $FCW_DATA OUT/{kitti,bdd,caltech,gathered,hard,later,latest} --detector net --out net.npz
    fcw evaluate detection OUT/judge/labels.json --images OUT/judge/images --calibration OUT/judge/calibration

and the same with `judge_hard`, `judge_later` and `judge_latest`.

CLONES is a folder for clones of the repositories below; those that are missing are cloned (bare, about
6 GB in all). The JSON files beside this one say which pictures are taken,
and what was judged by eye: of BDD100K which vehicles are seen from behind, of the Caltech cars the boxes. The
boxes of what was gathered were proposed by a net (YOLOX-nano), or are a dataset's own, and each was judged by
eye. Other boxes are the datasets' own.

| folder | pictures | terms |
| --- | --- | --- |
| kitti | KITTI object detection, 66 drives, at most one picture a second | CC BY-NC-SA 3.0 |
| bdd | BDD100K, the first 200 of its validation split | education, research, not-for-profit |
| caltech | Caltech cars 1999 and 2001, a rear each | no licence in the repository: research |
| gathered | more of BDD100K, German traffic signs, dash cameras, photographs | research: many state none |
| judge | the same of other drives, a quarter of those on the road: nothing learns from them | as above |
| hard | bad weather and light, lorries, buses, vans, near and half-hidden vehicles | as above |
| judge_hard | the same of other drives, a quarter: nothing learns from them | as above |
| later | more of BDD100K, dash cameras of South Asia and elsewhere, night, fog, lorries, buses | as above |
| judge_later | the same of other drives, a quarter: nothing learns from them | as above |
| latest | more of BDD100K, day and night, rain; lorries, buses, vans, dense traffic; some fog | as above |
| judge_latest | the same of other drives, a fifth: nothing learns from them | as above |

Cameras are rough: height and field of view are assumed, the horizon lies where the vehicles' sizes put it.
"""

import argparse
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from folders import LEAST_WIDTH_PX, Folder, Rough
from gathered import GATHERED, HARD, LATER, LATEST, build_gathered
from numpy.typing import NDArray
from repositories import Files, Repository

from fcw.frame import ImageSize

CHOICE = Path(__file__).with_name("choice.json")
KITTI_PICTURES = "siddharth-thatikanti/MovingObjectDetection_DL"
KITTI_LABELS = "swordlidev/Vote3Deep_lidar"
BDD_PICTURES = "abivarghese1/BDD100K-data-analysis-pipeline"
BDD_LABELS = "anushapv2000/bdd100k-object-detection"
CALTECH = "danakianfar/computer_vision_1"
CALTECH_COMMIT = "ae19d04db5aa77356430bf559d41af9e7c6a6684"

VEHICLES = {"Car": "car", "Van": "van", "Truck": "truck"}
BDD_CLASSES = {1: "bus", 2: "car", 3: "motorcycle", 8: "truck", 9: "train"}
"""The alphabetical order of BDD100K's classes, of which these have boxes here."""
REAR_RAD, QUARTER_RAD = 0.35, 0.9
"""So far from seen straight from behind a vehicle still counts as rear, and as rear-quarter."""
MOST_TRUNCATION = 0.35
SAME_PX = 2

KITTI_CAMERA = Rough(1.65, 721.5 / 1242)
BDD_CAMERA = Rough(1.4, 0.5 / math.tan(math.radians(63) / 2))
CALTECH_CAMERA = Rough(1.3, 0.5 / math.tan(math.radians(42) / 2))
KITTI_HORIZON = 172.9 / 1242
"""Beside the width."""


def build_kitti(clones: Path, folder: Folder, drives: Mapping[str, Sequence[int]]) -> None:
    """Vehicles whose angle of view says that they are seen from behind; every other picture is background."""
    numbers = sorted((number, drive) for drive, of_drive in drives.items() for number in of_drive)
    with (
        Repository(clones, KITTI_PICTURES).files() as pictures,
        Repository(clones, KITTI_LABELS).files() as labels,
    ):
        for index, (number, drive) in enumerate(numbers):
            picture = kitti_picture(pictures, number)
            size = ImageSize(picture.shape[1], picture.shape[0])
            calibration = KITTI_CAMERA.calibration(size, KITTI_HORIZON * size.width)
            lines = labels.text(f"training/label_2/{number:06d}.txt").splitlines()
            boxes = [box for line in lines if (box := kitti_box(line.split()))]
            clip = f"kitti_object_{drive}_sync"
            folder.add(f"{number:06d}", clip, picture, calibration, boxes, complete=index % 2 == 0)


def kitti_picture(files: Files, number: int) -> NDArray[np.uint8]:
    """A picture, on whichever side of the mirror's split it lies."""
    try:
        return files.picture(f"dataset/kitti/images/train/{number:06d}.png")
    except FileNotFoundError:
        return files.picture(f"dataset/kitti/images/val/{number:06d}.png")


def kitti_box(fields: Sequence[str]) -> dict[str, Any] | None:
    """A line of `label_2`; None for people."""
    kind, truncation, occluded, alpha = fields[0], float(fields[1]), int(fields[2]), float(fields[3])
    if kind in ("Pedestrian", "Person_sitting", "Cyclist"):
        return None
    left, top, right, bottom = map(float, fields[4:8])
    from_behind = abs(math.remainder(alpha + math.pi / 2, 2 * math.pi))
    counts = (
        kind in VEHICLES
        and from_behind <= QUARTER_RAD
        and occluded in (0, 1)
        and truncation <= MOST_TRUNCATION
        and right - left >= LEAST_WIDTH_PX
    )
    return {
        "bbox": [round(left, 2), round(top, 2), round(right - left, 2), round(bottom - top, 2)],
        "ignore": not counts,
        "kind": VEHICLES.get(kind, "other"),
        "view": "rear" if from_behind < REAR_RAD else "rear-quarter",
    }


def build_bdd(clones: Path, folder: Folder, choice: Mapping[str, Mapping[str, Any]]) -> None:
    """Vehicles that were judged by eye, known by the middle of their boxes."""
    with (
        Repository(clones, BDD_PICTURES).files() as pictures,
        Repository(clones, BDD_LABELS).files() as labels,
    ):
        for name, chosen in choice.items():
            picture = pictures.picture(f"outputs/evaluation/val_data/images/val/{name}.jpg")
            size = ImageSize(picture.shape[1], picture.shape[0])
            path = f"assignment_data_bdd/data_analysis/data/bdd100k_yolo_dataset/val/labels/{name}.txt"
            boxes = [box for line in labels.text(path).splitlines() if (box := bdd_box(line, size, chosen))]
            calibration = BDD_CAMERA.calibration(size, chosen["horizon_row_px"])
            folder.add(name, f"bdd_{name}", picture, calibration, boxes, chosen.get("complete", True))


def bdd_box(line: str, size: ImageSize, chosen: Mapping[str, Any]) -> dict[str, Any] | None:
    """A line of the labels; None for what is no vehicle."""
    number, *parts = line.split()
    if int(number) not in BDD_CLASSES:
        return None
    x, y, w, h = (float(part) for part in parts)
    x, y, w, h = x * size.width, y * size.height, w * size.width, h * size.height
    views = [v for cx, cy, v in chosen["vehicles"] if abs(cx - x) <= SAME_PX and abs(cy - y) <= SAME_PX]
    return {
        "bbox": [round(x - w / 2, 2), round(y - h / 2, 2), round(w, 2), round(h, 2)],
        "ignore": not views or w < LEAST_WIDTH_PX,
        "kind": BDD_CLASSES[int(number)],
        "occluded": int(views[:1] == ["h"]),
    }


def build_caltech(clones: Path, folder: Folder, choice: Mapping[str, Mapping[str, Any]]) -> None:
    """One vehicle a picture; others have no boxes."""
    with Repository(clones, CALTECH).files(CALTECH_COMMIT) as pictures:
        for name, chosen in choice.items():
            picture = pictures.picture(f"project/Caltech4/ImageData/{name}.jpg")
            size = ImageSize(picture.shape[1], picture.shape[0])
            calibration = CALTECH_CAMERA.calibration(size, chosen["horizon_row_px"])
            box = {"bbox": chosen["box"], "ignore": False, "kind": "car", "view": "rear"}
            clip = f"caltech_{chosen['clip']}"
            folder.add(name.replace("/", "_"), clip, picture, calibration, [box], complete=False)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("clones", type=Path, help="folder of the repositories' clones")
    parser.add_argument("out", type=Path, help="folder for the training folders")
    arguments = parser.parse_args()
    kept = json.loads(CHOICE.read_text())
    builders = (
        ("kitti", "kitti", build_kitti),
        ("bdd", "bdd100k", build_bdd),
        ("caltech", "caltech", build_caltech),
    )
    for name, source, build in builders:
        folder = Folder(arguments.out / name)
        build(arguments.clones, folder, kept[source])
        folder.write()
    for choice, *names in (
        (GATHERED, "gathered", "judge"),
        (HARD, "hard", "judge_hard"),
        (LATER, "later", "judge_later"),
        (LATEST, "latest", "judge_latest"),
    ):
        learn, judge = (Folder(arguments.out / name) for name in names)
        build_gathered(arguments.clones, choice, learn, judge)
        for folder in (learn, judge):
            folder.write()


if __name__ == "__main__":
    main()
