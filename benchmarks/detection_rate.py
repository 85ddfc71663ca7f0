"""Detection rate against false positives of both detectors on the data's validation split.

    FCW_DATA=DIR python benchmarks/detection_rate.py [MODEL.npz]

The figures of the weights' model card. Besides the false positives per picture of DESIGN.md's rules it gives
those on mere background: the others are boxes that miss a vehicle's outline.
"""

import os
import sys
from pathlib import Path

import numpy as np

from fcw.detection.acf import AcfDetector, AcfSettings, FullAcfDetector, FullAcfSettings
from fcw.detection.dataset import LabelledImage, background, read_calibration_table, read_labels
from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from fcw.evaluation.detection import LabelledDetections, detection_curve

FPPI = (0.046, 0.1, 1.0)


def main() -> None:
    data = Path(os.environ["FCW_DATA"])
    model = Model.load(Path(sys.argv[1]) if len(sys.argv) > 1 else SHIPPED_MODEL_PATH)
    calibrations = read_calibration_table(data / "calibrations.txt")
    lowest = model.rejection_threshold
    tusimple = read_labels(data / "tusimple/validation.json", data / "tusimple/images")
    labels = read_labels(data / "labels/validation.json", data / "labels/images")
    clips = sorted({image.clip for image in labels})
    sets = {"tusimple": tusimple, "labels": labels}
    sets |= {f"  {clip}": tuple(image for image in labels if image.clip == clip) for clip in clips}

    heads = ["set", "detector", "pictures", "vehicles", *(f"at {f:g}" for f in FPPI), "shipped: rate"]
    print_row([*heads, "false", "background"])
    for name, images in sets.items():
        for kind in ("acf", "acf-full"):
            detectors = {
                (image.clip, image.size): AcfDetector(
                    model,
                    calibrations[image.clip].for_image_size(image.size),
                    AcfSettings(score_threshold=lowest),
                )
                if kind == "acf"
                else FullAcfDetector(model, FullAcfSettings(score_threshold=lowest))
                for image in images
            }
            results = [detect(detectors[image.clip, image.size], image) for image in images]
            curve = detection_curve(results)
            shipped = curve.at_threshold(model.score_threshold)
            nothing = sum(
                int((r.scores[background(r.detections, r.labels, r.ignored)] >= model.score_threshold).sum())
                for r in results
            )
            rates = [curve.at_fppi(fppi).detection_rate for fppi in FPPI]
            figures = [*rates, shipped.detection_rate, shipped.fppi, nothing / len(images)]
            print_row([name, kind, len(images), curve.vehicles, *(f"{figure:.3f}" for figure in figures)])


def detect(detector: AcfDetector | FullAcfDetector, image: LabelledImage) -> LabelledDetections:
    found = detector.detect(image.read())
    boxes = np.array([[d.box.x, d.box.y, d.box.w, d.box.h] for d in found], np.float64).reshape(-1, 4)
    return LabelledDetections(boxes, np.array([d.score for d in found]), image.boxes, image.ignored)


def print_row(cells: list[object]) -> None:
    sys.stdout.write("| " + " | ".join(map(str, cells)) + " |\n")


if __name__ == "__main__":
    main()
