"""Times of the detector and its parts on one picture, side by side in one run.

    FCW_DATA=... python benchmarks/detector_speed.py

The cases take turns, so that a busy machine slows all of them alike, and the thread's own time is counted,
not that of others which the scheduler lets in between; the ratios are what to hold on to.
"""

import argparse
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable
from datetime import date
from pathlib import Path

import cv2
import llvmlite
import numba
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from fcw.camera.calibration import Calibration
from fcw.detection.acf import AcfDetector, AcfSettings, FullAcfDetector, FullAcfSettings
from fcw.detection.channels import ChannelComputer
from fcw.detection.dataset import read_calibration_table
from fcw.detection.model import SHIPPED_MODEL_PATH, Model, model_sha256
from fcw.sources.frame import ImageSize
from fcw.versions import machine

BASE = "acf-full: plain ACF, whole picture"


def cases(
    image: NDArray[np.uint8], model: Model, calibration: Calibration
) -> dict[str, tuple[Callable[[], object], int | None]]:
    """What is timed, and how many windows it looks at."""
    size = ImageSize(image.shape[1], image.shape[0])
    computer = ChannelComputer(size)
    channels = computer.compute(image)
    full = FullAcfDetector(model)
    enlarging = FullAcfDetector(model, FullAcfSettings(largest_scale=AcfSettings().largest_scale))
    for detector in (full, enlarging):
        detector.detect(image)
    timed: dict[str, tuple[Callable[[], object], int | None]] = {
        "ten channels of the whole picture": (lambda: computer.compute(image, out=channels), None),
        BASE: (lambda: full.detect(image), full.windows_per_frame),
        "acf-full, enlarging as acf does": (lambda: enlarging.detect(image), enlarging.windows_per_frame),
    }
    for name, settings in (
        ("acf: distance prior, 4 to 80 m", AcfSettings()),
        ("acf: 4 to 80 m, not enlarging, as acf-full", AcfSettings(largest_scale=1.0)),
        ("acf: 4 to 41 m", AcfSettings(farthest_m=41.0)),
        ("acf: 4 to 80 m, pitch to 2 degrees", AcfSettings(pitch_tolerance_rad=np.radians(2.0))),
        ("acf: 4 to 80 m, 8 scales an octave", AcfSettings(scales_per_octave=8)),
    ):
        detector = AcfDetector(model, calibration, settings)
        timed[name] = (lambda d=detector: d.detect(image), detector.windows_per_frame)
    return timed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--image", type=Path, help="a picture; default: a TuSimple frame of $FCW_DATA")
    parser.add_argument("--calibration", type=Path, help="its calibration file, with --image")
    parser.add_argument("--model", type=Path, default=SHIPPED_MODEL_PATH)
    parser.add_argument("--rounds", type=int, default=60)
    arguments = parser.parse_args()
    if arguments.image and arguments.calibration:
        path, calibration = arguments.image, Calibration.load(arguments.calibration)
    elif "FCW_DATA" in os.environ and not arguments.image:
        data = Path(os.environ["FCW_DATA"])
        path = min((data / "tusimple" / "images").rglob("*.jpg"))
        calibration = read_calibration_table(data / "calibrations.txt")["tusimple"]
    else:
        sys.exit("set FCW_DATA, or give both --image and --calibration")
    image = np.asarray(cv2.imread(str(path)), np.uint8)
    model = Model.load(arguments.model)

    cv2.setNumThreads(1)
    timed = cases(image, model, calibration)
    milliseconds: dict[str, list[float]] = {name: [] for name in timed}
    for run, _ in timed.values():
        run()
    for _ in range(arguments.rounds):
        for name, (run, _) in timed.items():
            start = time.thread_time()
            run()
            milliseconds[name].append(1e3 * (time.thread_time() - start))

    console = Console()
    console.print(f"{machine()}; {date.today()}; one thread's time, {arguments.rounds} rounds taking turns")
    console.print(
        f"Python {platform.python_version()}, numpy {np.__version__}, numba {numba.__version__}, "
        f"llvmlite {llvmlite.__version__}, OpenCV {cv2.__version__}"
    )
    console.print(
        f"{path.name}, {image.shape[1]}x{image.shape[0]}; {len(model.trees)} trees, "
        f"model {model_sha256(arguments.model)[:12]}"
    )
    table = Table("what", "median ms", "minimum ms", "x acf-full", "windows")
    base = milliseconds[BASE]
    for name, (_, windows) in timed.items():
        values = milliseconds[name]
        ratio = statistics.median(a / b for a, b in zip(values, base, strict=True))
        table.add_row(
            name,
            f"{statistics.median(values):.2f}",
            f"{min(values):.2f}",
            f"{ratio:.2f}",
            "" if windows is None else f"{windows:,}",
        )
    console.print(table)


if __name__ == "__main__":
    main()
