"""How long it takes to label two vehicles in 60 frames on the review page, and how good the labels are.

    FCW_DATA=DIR PYTHONPATH=benchmarks python benchmarks/review/labelling.py [--seed 0] [--step 5] [--all]

The truth are the boxes that people drew in every frame of KITTI tracking (`kitti-tracking/label_02`). The
clip and its two vehicles are drawn by lot, by the seed, from all stretches of 60 frames in which two vehicles
are labelled throughout, mostly in sight and at least 25 pixels high. The data has no pictures of it: the page
shows grey ones with the vehicles as darker patches, and the log has no track that could help.

A script does on the page in Chromium what a person would: E; for each vehicle Home and a box drawn with the
mouse, then again and again some frames on (right arrow), the box drawn anew, and I, which
interpolates. The hand misses each edge by 1.5 pixels (normal, by the seed). Every key and drag is counted,
and costs what the Keystroke-Level Model says (Card, Moran and Newell 1980): a key 0.28 s, pointing 1.1 s,
pressing or letting go 0.1 s, the hand from keyboard to mouse or back 0.4 s, and 1.35 s of thought before each
box.
`--all` prints what the same drawing and interpolating gives on every such clip, without the page.
"""

import argparse
import random
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from chromium import WINDOW, chromium, option_parser
from numpy.typing import NDArray
from playwright.sync_api import Page
from real_drives import data_folder

from fcw.annotation.box_motion import interpolated
from fcw.annotation.records import LabelledBox
from fcw.annotation.store import read_review
from fcw.box import Box
from fcw.detection.boxes.overlap import intersection_over_union
from fcw.evaluation.distance.kitti_tracking import KittiSequence, read_sequence
from fcw.frame import Frame, ImageSize
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader, FrameResult
from fcw.warning.types import WarningLevel, WarningState
from fcw_viz.review_app.server import ReviewPage

FRAMES, RATE_HZ = 60, 10
LEAST_HEIGHT_PX, MOST_OCCLUDED = 25.0, 1
WANTED_IOU = 0.85
HAND_SIGMA_PX = 1.5
KEY_S, POINT_S, PRESS_S, HAND_S, THOUGHT_S = 0.28, 1.1, 0.1, 0.4, 1.35
DRAG_S = 2 * POINT_S + 2 * PRESS_S
PATIENCE_MS = 180_000
SETTLE_MS = 250

_ON_SCREEN = """([column, row]) => {
  const viewer = window.__viserMutable;
  let picture = null;
  viewer.nodeRefFromName["/picture"].traverse((node) => {
    if (node.isMesh && node.material.map) picture = picture ?? node;
  });
  const { width, height } = picture.geometry.parameters;
  const { image } = picture.material.map;
  const point = viewer.camera.position.clone().set(
    ((column + 0.5) / image.width - 0.5) * width, (0.5 - (row + 0.5) / image.height) * height, 0);
  picture.updateWorldMatrix(true, false);
  viewer.camera.updateMatrixWorld();
  point.applyMatrix4(picture.matrixWorld).project(viewer.camera);
  const canvas = viewer.canvas.getBoundingClientRect();
  return [canvas.left + (point.x + 1) / 2 * canvas.width, canvas.top + (1 - point.y) / 2 * canvas.height];
}"""


@dataclass(frozen=True, slots=True)
class Clip:
    """What is labelled.

    Attributes:
        sequence: of KITTI tracking.
        first: its first frame.
        vehicles: numbers of the two.
        boxes: of each vehicle in each frame.
        image_size: of the pictures.
    """

    sequence: str
    first: int
    vehicles: tuple[int, int]
    boxes: tuple[tuple[Box, ...], tuple[Box, ...]]
    image_size: ImageSize


@dataclass(slots=True)
class Person:
    """Counts what is done, and the time it takes."""

    actions: int = 0
    time_s: float = 0.0
    edits: dict[str, int] = field(default_factory=dict)

    def does(self, what: str, cost_s: float) -> None:
        """One key or one drag."""
        self.actions += 1
        self.time_s += cost_s
        self.edits[what] = self.edits.get(what, 0) + 1


def clips(sequences: Sequence[KittiSequence]) -> Iterator[Clip]:
    """All clips that the lot is drawn from: every tenth frame begins one, with each pair of vehicles."""
    for sequence in sequences:
        for first in range(0, len(sequence.frames) - FRAMES + 1, 10):
            tracks: dict[int, list[Box]] = {}
            for frame in sequence.frames[first : first + FRAMES]:
                for one in frame:
                    if one.occluded <= MOST_OCCLUDED and one.box.h >= LEAST_HEIGHT_PX:
                        tracks.setdefault(one.track_id, []).append(one.box)
            whole = sorted(number for number, boxes in tracks.items() if len(boxes) == FRAMES)
            for k, one in enumerate(whole):
                for other in whole[k + 1 :]:
                    boxes = tuple(tracks[one]), tuple(tracks[other])
                    yield Clip(sequence.name, first, (one, other), boxes, sequence.image_size)


def drawn(box: Box, hand: np.random.Generator) -> Box:
    """A box as a hand draws it."""
    left, top, right, bottom = hand.normal((box.x, box.y, box.right, box.bottom), HAND_SIGMA_PX)
    return Box(left, top, max(right - left, 4.0), max(bottom - top, 4.0))


def key_frames(step: int) -> list[int]:
    """Frames in which a box is drawn."""
    return [*range(0, FRAMES - 1, step), FRAMES - 1]


def overlaps(labels: Sequence[Box], truth: Sequence[Box]) -> NDArray[np.float64]:
    """Intersection over union in each frame."""
    a, b = (np.array([[box.x, box.y, box.w, box.h] for box in boxes]) for boxes in (labels, truth))
    return np.diagonal(intersection_over_union(a, b))


def without_page(clip: Clip, step: int, seed: int) -> NDArray[np.float64]:
    """The overlaps that drawing and interpolating give, by the page's own function."""
    hand = np.random.default_rng(seed)
    found = []
    for truth in clip.boxes:
        keys = key_frames(step)
        hands = {k: LabelledBox(drawn(truth[k], hand)) for k in keys}
        labels = []
        for k in range(FRAMES):
            before = max(key for key in keys if key <= k)
            after = min(key for key in keys if key >= k)
            part = (k - before) / (after - before) if after > before else 0.0
            labels.append(interpolated(hands[before], hands[after], part).box)
        found.append(overlaps(labels, truth))
    return np.concatenate(found)


def write_log(clip: Clip, sequence: KittiSequence, path: Path) -> None:
    """A log of the clip in which no vehicle was found."""
    size = ImageSize(clip.image_size.width // 2 * 2, clip.image_size.height // 2 * 2)
    calibration = sequence.calibration(np.random.default_rng(0))
    header = DriveHeader(
        f"kitti-tracking-{clip.sequence}", size, RATE_HZ, calibration, False, "none", "", {"fcw": "benchmark"}
    )
    sink, encoder = McapSink(path), VideoEncoder(size, RATE_HZ)
    sink.open(header)
    for index in range(FRAMES):
        image = np.full((size.height, size.width, 3), 150, np.uint8)
        for boxes in clip.boxes:
            box = boxes[index]
            image[round(box.y) : round(box.bottom), round(box.x) : round(box.right)] = 80
        time_ns = index * 1_000_000_000 // RATE_HZ
        result = FrameResult(index, time_ns, (), (), None, WarningState(WarningLevel.NONE), None)
        sink.write(result, encoder.encode(Frame(index, time_ns, image)))
    encoder.close()
    sink.close()


class Labeller:
    """Somebody at the page."""

    def __init__(self, page: Page, log: Path, seed: int) -> None:
        self._page, self._log = page, log
        self._hand = np.random.default_rng(seed)
        self.person = Person()

    def key(self, name: str) -> None:
        """Press a key."""
        self._page.keyboard.press(name)
        self.person.does(f"key {name}", KEY_S)

    def at(self, row: int) -> None:
        """Wait until the page shows a frame."""
        self._page.wait_for_function(
            "row => document.querySelector('.fcw-clock')?.dataset.row == row", arg=str(row)
        )
        self._page.wait_for_timeout(SETTLE_MS)

    def label(self, truth: Sequence[Box], step: int) -> None:
        """Label a vehicle: boxes drawn in some frames, and interpolated between."""
        before = 0
        for k in key_frames(step):
            if k == 0:
                self.key("Home")
            elif k == FRAMES - 1:
                self.key("End")
            else:
                for _ in range(step):
                    self.key("ArrowRight")
            self.at(k)
            box = drawn(truth[k], self._hand)
            self._draw(box)
            self._wait_for(k)
            if k > 0:
                self.key("i")
                self._wait_for(*range(before, k + 1))
            before = k
        self.key("Escape")
        self.key("e")

    def _draw(self, box: Box) -> None:
        """Draw a box, which has its number of edits afterwards."""
        page = self._page
        places = ((box.x, box.y), (box.right, box.bottom))
        start, end = (page.evaluate(_ON_SCREEN, place) for place in places)
        page.keyboard.down("Shift")
        page.mouse.move(*start)
        page.mouse.down()
        page.mouse.move((start[0] + end[0]) / 2, (start[1] + end[1]) / 2, steps=3)
        page.mouse.move(*end, steps=3)
        page.mouse.up()
        page.keyboard.up("Shift")
        self.person.does("drag", THOUGHT_S + HAND_S + DRAG_S + HAND_S)

    def _wait_for(self, *frames: int) -> None:
        """Wait until as many boxes are kept of the frames as vehicles were worked on."""
        wanted = self.vehicles
        for _ in range(PATIENCE_MS // SETTLE_MS):
            labels = read_review(DriveLog(self._log))[0].frames
            if all(k in labels and len(labels[k].labels) == wanted for k in frames):
                return
            self._page.wait_for_timeout(SETTLE_MS)
        raise SystemExit(f"frames {frames}: the page did not keep {wanted} boxes")

    vehicles = 1
    """How many have been worked on, this one included."""


def label_on_page(clip: Clip, sequence: KittiSequence, options: argparse.Namespace) -> None:
    """Label the clip in Chromium, and print what it took and how good it is."""
    with tempfile.TemporaryDirectory() as folder, chromium(options) as browser:
        log = Path(folder) / "drive.mcap"
        write_log(clip, sequence, log)
        served = ReviewPage({"clip": log}, "clip", "anna")
        try:
            page = browser.new_context(viewport=WINDOW).new_page()
            page.set_default_timeout(PATIENCE_MS)
            page.goto(f"{served.url}/?fixedDpr=1&at=clip@0")
            page.wait_for_selector(".fcw-clock")
            page.wait_for_timeout(10 * SETTLE_MS)
            labeller = Labeller(page, log, options.seed)
            labeller.key("e")
            for number, truth in enumerate(clip.boxes, 1):
                labeller.vehicles = number
                labeller.label(truth, options.step)
        finally:
            served.stop()
        frames = read_review(DriveLog(log))[0].frames
        found = []
        for truth in clip.boxes:
            labels = [
                max(
                    (label.box for label in frames[k].labels.values() if label is not None),
                    key=lambda box, k=k: overlaps([box], [truth[k]])[0],
                )
                for k in range(FRAMES)
            ]
            found.append(overlaps(labels, truth))
    person = labeller.person
    say(f"actions: {person.actions} ({', '.join(f'{n} {what}' for what, n in person.edits.items())})")
    say(f"time by the keystroke-level model: {person.time_s:.0f} s ({person.time_s / 60:.1f} min)")
    report("IoU on the page", np.concatenate(found))


def say(text: str) -> None:
    """Print a line."""
    sys.stdout.write(f"{text}\n")


def report(name: str, values: NDArray[np.float64]) -> None:
    """Print mean, tenth percentile and share of a set of overlaps."""
    low, share = np.quantile(values, 0.1), (values >= WANTED_IOU).mean()
    say(f"{name}: mean {values.mean():.3f}, 10th percentile {low:.3f}, >= {WANTED_IOU} in {share:.0%}")


def main() -> None:
    """Read the command line, draw the lot and label."""
    parser = option_parser(__doc__)
    parser.add_argument("--seed", type=int, default=0, help="of the lot and of the hand")
    parser.add_argument("--step", type=int, default=5, help="frames from a drawn box to the next")
    parser.add_argument("--all", action="store_true", help="all clips, without the page")
    options = parser.parse_args()
    folder = data_folder() / "kitti-tracking"
    names = sorted(path.stem for path in (folder / "label_02").glob("*.txt"))
    sequences = {name: read_sequence(folder, name) for name in names}
    candidates = list(clips(list(sequences.values())))
    if options.all:
        means = np.array([without_page(clip, options.step, options.seed).mean() for clip in candidates])
        report(f"mean IoU of each of {len(candidates)} clips, step {options.step}", means)
        return
    clip = random.Random(options.seed).choice(candidates)
    say(
        f"sequence {clip.sequence}, frames {clip.first} to {clip.first + FRAMES - 1}, vehicles "
        f"{clip.vehicles[0]} and {clip.vehicles[1]}: one of {len(candidates)} by seed {options.seed}"
    )
    report("IoU by the same hand without the page", without_page(clip, options.step, options.seed))
    label_on_page(clip, sequences[clip.sequence], options)


if __name__ == "__main__":
    main()
