"""What soft, dark, faint and overexposed pictures cost, and whether that is said (`fcw.motion.flow.sight`).

    FCW_DATA=DIR python benchmarks/poor_sight.py

Every sixth completely labelled picture of the data, altered in each way. Of each way: how many of the boxes
that the net finds in the picture as it is it finds again (IoU 0.5), by their height in a picture 640 px wide;
how those differ: logarithms of width and height, and lower edge as a part of the height (medians); and what
is said of the pictures. Then, of those blurred, how many sigmas of the blur, as it is measured, a vehicle is
high of which half are lost, leaving out each camera. Last, of the data's clips in some ways, in which part of
their pictures something is said. Lengths are px at a width of 640. Takes about four minutes on one core.
"""

import argparse
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from lines import say, say_row, where_and_with_what
from numpy.typing import NDArray
from real_drives import data_folder
from rich.console import Console
from rich.progress import track
from scipy.optimize import minimize

from fcw.detection.boxes.overlap import intersection_over_union
from fcw.detection.choice import load_model
from fcw.detection.detector import Detector
from fcw.evaluation.detection.cameras import LabelledCameras, read_cameras
from fcw.evaluation.detection.detectors import DetectorCase
from fcw.motion.flow.sight import SightWatch, look_at, poor_sight
from fcw.sources import open_source

STEP, WIDTH = 6, 640
HEIGHTS_PX = (0.0, 15.0, 25.0, 50.0, np.inf)
SOFT_FROM = 1.2
"""Sigma, in px, from which losses are laid to the blur."""
FIRST_S = 5.0
CLIP_STEP = 5
"""One picture of so many is altered and looked at."""
Picture = NDArray[np.uint8]
Way = Callable[[Picture], Picture]


def blurred(sigma: float) -> Way:
    return lambda picture: byte(cv2.GaussianBlur(picture, (0, 0), sigma * picture.shape[1] / WIDTH))


def smeared(length: float) -> Way:
    """By a motion to the side, of so many px."""

    def smear(picture: Picture) -> Picture:
        size = round(length * picture.shape[1] / WIDTH) // 2 * 2 + 1
        return byte(cv2.blur(picture, (size, 1)))

    return smear


def enlarged(width: int) -> Way:
    """From a picture so wide, beside 1280."""

    def enlarge(picture: Picture) -> Picture:
        height, own_width = picture.shape[:2]
        size = round(own_width * width / 1280), round(height * width / 1280)
        small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
        return byte(cv2.resize(small, (own_width, height), interpolation=cv2.INTER_LINEAR))

    return enlarge


def exposed(gain: float, bloom: float = 0.0, noise: float = 0.0) -> Way:
    """With so many times the light; what is too bright shines on its surroundings."""
    light = (np.arange(256, dtype=np.float32) / 255) ** 2.2 * gain

    def expose(picture: Picture) -> Picture:
        seen = light[picture]
        if bloom:
            glare = np.maximum(seen - 0.8, 0)
            for sigma in (2, 8):
                seen += bloom * cv2.GaussianBlur(glare, (0, 0), sigma * picture.shape[1] / WIDTH)
        values = np.clip(seen, 0, 1) ** (1 / 2.2) * 255
        if noise:
            values += noise * np.random.default_rng(0).standard_normal(picture.shape, np.float32)
        return byte(values)

    return expose


def veiled(part: float) -> Way:
    """Behind a bright veil, so that this part of the contrast is left."""
    return lambda picture: byte(picture * part + 200 * (1 - part))


def compressed(quality: int) -> Way:
    def compress(picture: Picture) -> Picture:
        _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
        return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.uint8)

    return compress


def byte(values: NDArray) -> Picture:
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


BLURRED = {f"blurred, sigma {sigma}": blurred(sigma) for sigma in (0.7, 1.0, 1.3, 2.0, 3.0)}
BLURRED |= {f"enlarged from {width} to 1280": enlarged(width) for width in (854, 427, 320)}
WAYS: dict[str, Way] = {
    "as it is": lambda picture: picture,
    **BLURRED,
    "smeared by 8 px": smeared(8),
    **{f"{gain} times the light": exposed(gain) for gain in (2.5, 8.0)},
    "4 times the light, bloom": exposed(4, bloom=0.5),
    **{f"{gain} of the light, noise 4": exposed(gain, noise=4) for gain in (0.05, 0.02, 0.008)},
    **{f"{part} of the contrast": veiled(part) for part in (0.25, 0.12)},
    "JPEG, quality 8": compressed(8),
}
FOR_CLIPS = "as it is", "blurred, sigma 1.3", "0.02 of the light, noise 4", "0.12 of the contrast"


@dataclass(slots=True)
class Tally:
    """What became of boxes in one way.

    Attributes:
        rows: camera, height, whether found again, measured blur in px, differences of width, height and
            lower edge, of each box.
        said: what was said of pictures.
    """

    rows: list[tuple[str, float, bool, float, float, float, float]] = field(default_factory=list)
    said: Counter[str] = field(default_factory=Counter)


def main() -> None:
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    cv2.setNumThreads(1)
    data = data_folder()
    tallies = look_everywhere(read_cameras(data))
    say(where_and_with_what())
    print_ways(tallies)
    print_lost([row for way in BLURRED for row in tallies[way].rows])
    print_clips(sorted((data / "clips").glob("*.mp4")))


def look_everywhere(cameras: LabelledCameras) -> dict[str, Tally]:
    detector_of = DetectorCase("net", load_model("net")).detector_of(cameras.calibration_of)
    tallies = {way: Tally() for way in WAYS}
    images = [image.labelled for image in cameras.images if image.labelled.complete][::STEP]
    for image in track(images, "detecting", console=Console(stderr=True)):
        detector, picture = detector_of(image), image.read()
        before = found(detector, picture)
        for way, alter in WAYS.items():
            altered = alter(picture)
            look, tally, part = look_at(altered), tallies[way], WIDTH / image.size.width
            poor = poor_sight(look)
            tally.said[poor.value if poor else ""] += 1
            after = found(detector, altered)
            overlap = intersection_over_union(before, after) if len(after) else np.zeros((len(before), 1))
            for box, each in zip(before, overlap, strict=True):
                there = bool(each.max() >= 0.5)
                _, y, w, h = after[each.argmax()] if there else np.full(4, np.nan)
                off = np.log(w / box[2]), np.log(h / box[3]), (y + h - box[1] - box[3]) / box[3]
                tally.rows.append((image.camera, box[3] * part, there, look.blur * WIDTH, *off))
    return tallies


def found(detector: Detector, picture: Picture) -> NDArray[np.float64]:
    """(N, 4) boxes."""
    boxes = [(one.box.x, one.box.y, one.box.w, one.box.h) for one in detector.detect(picture)]
    return np.array(boxes, np.float64).reshape(-1, 4)


def print_ways(tallies: dict[str, Tally]) -> None:
    bins = [f"{low:g} to {high:g} px" for low, high in pairwise(HEIGHTS_PX)]
    say("\nFound again, by height; width, height and lower edge of those of 15 px and more; what is said\n")
    say_row(["way", *bins, "width", "height", "lower edge", "blur, px", "said of"], head=True)
    for way, tally in tallies.items():
        values = np.array([row[1:] for row in tally.rows], float)
        again = values[:, 1] > 0
        heights = np.digitize(values[:, 0], HEIGHTS_PX)
        parts = [f"{np.mean(again[heights == number]):.0%}" for number in range(1, len(HEIGHTS_PX))]
        off = [f"{one:+.1%}" for one in np.median(values[again & (heights > 1)][:, 3:], axis=0)]
        count = sum(tally.said.values())
        said = [f"{name.split()[0]} {number / count:.0%}" for name, number in tally.said.items() if name]
        say_row([way, *parts, *off, f"{np.nanmedian(values[:, 2]):.2f}", ", ".join(said) or "-"])


def print_lost(rows: Sequence[tuple]) -> None:
    """Height, over sigma, of which half are lost: a logistic model of both, of pictures that are soft."""
    names = np.array([row[0] for row in rows])
    values = np.array([row[1:4] for row in rows], float)
    soft = values[:, 2] > SOFT_FROM
    say("\nHeight of vehicles of which half are lost, over the sigma of the blur, by sigma\n")
    say_row(["left out", "1.4 px", "2 px", "3 px"], head=True)
    for left_out in ("none", *np.unique(names)):
        kept = soft & (names != left_out)
        inputs = np.column_stack([np.ones(kept.sum()), np.log(values[kept, 0]), np.log(values[kept, 2])])
        again = values[kept, 1]

        def surprise(weights: NDArray[np.float64], inputs: NDArray = inputs, again: NDArray = again) -> float:
            logits = inputs @ weights
            return float(np.sum(np.logaddexp(0.0, logits) - again * logits))

        first, by_height, by_blur = minimize(surprise, np.zeros(3)).x
        sigmas = np.array([1.4, 2.0, 3.0])
        heights = np.exp(-(first + by_blur * np.log(sigmas)) / by_height)
        say_row([left_out, *(f"{one:.1f}" for one in heights / sigmas)])


def print_clips(clips: Sequence[Path]) -> None:
    say(f"\nOf the first {FIRST_S:g} s of clips, in which part of the pictures something is said\n")
    say_row(["clip", *FOR_CLIPS], head=True)
    for path in clips:
        cells = []
        for way in FOR_CLIPS:
            watch, said = SightWatch(), Counter[str]()
            for time_ns, picture in pictures(path):
                said[watch.see(time_ns, WAYS[way](picture)).partition(" ")[0]] += 1
            parts = [f"{name} {said[name] / said.total():.0%}" for name in said if name]
            cells.append(", ".join(parts) or "-")
        say_row([path.stem, *cells])


def pictures(path: Path) -> Iterator[tuple[int, Picture]]:
    for frame in open_source(path).frames():
        if frame.time_ns > FIRST_S * 1e9:
            return
        if frame.index % CLIP_STEP == 0:
            yield frame.time_ns, frame.image


if __name__ == "__main__":
    main()
