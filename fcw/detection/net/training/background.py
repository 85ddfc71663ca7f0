"""Windows without a vehicle in its place: what the cascade proposes, and what the first look leaves of it."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.cutting import cut_rectangle
from fcw.detection.boxes.overlap import intersection_areas, vehicle_overlap
from fcw.detection.model import Model
from fcw.detection.net.looks import FIRST_PX, SECOND_PX, Look, PickSettings, pick
from fcw.detection.net.proposals import ProposalSettings, Proposer
from fcw.detection.net.training.lottery import Lottery
from fcw.detection.net.training.vehicles import lamp_colour, with_glow
from fcw.detection.net.windows import WINDOW_UNITS, Pyramid, boxes_of
from fcw.detection.training.dataset import LabelledImage, TrainingImage
from fcw.detection.training.looks import Looks, vary_looks

STORED_UNITS, STORED_PX = 84.0, 63
"""More than the window, as many pixels a unit as the net is given, so that it can be moved a little."""
LARGEST_IOU = 0.35
LARGEST_COVERED_PART = 0.4
LIT_PART = 0.1


class Background:
    """Windows that show no vehicle in place, kept with a weight each.

    Args:
        stored: N windows with their surroundings, (63, 63, 3) uint8 each. They are many: none is copied.
        weights: (N,) how often each is drawn beside the others.
    """

    def __init__(self, stored: Sequence[NDArray[np.uint8]], weights: NDArray[np.float64]) -> None:
        self._stored, self._weights = stored, weights
        self._any = Lottery(weights)

    def __len__(self) -> int:
        return len(self._stored)

    def with_more(self, other: "Background", part: float) -> "Background":
        """Together with another, from which this part is drawn."""
        mine, others = (each._weights / each._weights.sum() for each in (self, other))
        weights = np.concatenate([(1 - part) * mine, part * others])
        return Background([*self._stored, *other._stored], weights)

    def draw(self, random: np.random.Generator) -> NDArray[np.uint8]:
        """A window of background, perhaps with a light in it: a lone lamp is no vehicle."""
        picture = self._stored[self._any.draw(random)]
        if random.uniform() < LIT_PART:
            column, row = random.uniform(12, 50, 2)
            picture = with_glow(picture, column, row, random.uniform(1.5, 6.0), lamp_colour(random))
        step, stretch = np.exp(random.uniform(-0.1, 0.1)), np.exp(random.uniform(-0.08, 0.08))
        shift = random.uniform(-3.0, 3.0, 2)
        width, height = SECOND_PX * step * stretch, SECOND_PX * step
        left, top = (STORED_PX - width) / 2 + shift[0], (STORED_PX - height) / 2 + shift[1]
        return cut_rectangle(picture, left, top, width, height, SECOND_PX)


assert round(STORED_UNITS * SECOND_PX / WINDOW_UNITS) == STORED_PX


def proposed(
    images: Sequence[TrainingImage],
    cascade: Model,
    settings: ProposalSettings,
    advance: Callable[[], None] = lambda: None,
) -> Background:
    """What the cascade proposes; the surer it is of a vehicle, the oftener it is drawn."""
    stored: list[NDArray[np.uint8]] = []
    scores: list[NDArray[np.float32]] = []
    settings = replace(settings, lowest_scores=(cascade.rejection_threshold,) * len(settings.counts))
    for image, picture, proposer in _pictures(images, cascade, settings, advance):
        placements, found = proposer.propose(picture)
        square = boxes_of(placements, np.tile([0.0, 0.0, 0.1, -0.1], (len(placements), 1)))
        without = without_vehicle(square, image)
        stored.extend(Pyramid(picture).windows(placements[without], STORED_PX, STORED_UNITS))
        scores.append(found[without])
    return Background(stored, np.exp(np.clip(np.concatenate(scores), -4.0, 12.0) / 12.0))


def picked(
    images: Sequence[TrainingImage],
    cascade: Model,
    first: bytes,
    settings: tuple[ProposalSettings, PickSettings],
    looks: Looks,
    advance: Callable[[], None] = lambda: None,
) -> Background:
    """What the first look takes for vehicles, in pictures as they are and once more as they might look."""
    stored: list[NDArray[np.uint8]] = []
    look, random = Look(first, FIRST_PX), np.random.default_rng(0)
    for image, picture, proposer in _pictures(images, cascade, settings[0], advance):
        for seen in (picture, vary_looks(picture, looks, random)):
            pyramid = Pyramid(seen)
            boxes, logits = look.at(pyramid, proposer.propose(seen)[0])
            without = without_vehicle(boxes, image)
            placements = pick(boxes[without], logits[without], len(picture), settings[1])
            stored.extend(pyramid.windows(placements, STORED_PX, STORED_UNITS))
    return Background(stored, np.ones(len(stored)))


def _pictures(
    images: Sequence[TrainingImage], cascade: Model, settings: ProposalSettings, advance: Callable[[], None]
) -> Iterator[tuple[LabelledImage, NDArray[np.uint8], Proposer]]:
    """Each picture in which all is labelled, and what proposes in it."""
    proposers: dict[int, Proposer] = {}
    for image in images:
        if image.labelled.complete:
            key = id(image.calibration)
            if key not in proposers:
                proposers.clear()  # pictures of a clip follow each other, and each takes much memory
                proposers[key] = Proposer(cascade, image.calibration, settings)
            yield image.labelled, image.labelled.read(), proposers[key]
        advance()


def without_vehicle(boxes: NDArray[np.float64], labelled: LabelledImage) -> NDArray[np.bool_]:
    """(N,) which boxes hold no vehicle in its place, nor what may be one."""
    overlap = vehicle_overlap(boxes, labelled.boxes, labelled.rear_boxes)
    covered = intersection_areas(boxes, labelled.boxes[labelled.ignored])
    covered /= np.prod(boxes[:, 2:], axis=1)[:, None]
    return ~((overlap >= LARGEST_IOU).any(axis=1) | (covered >= LARGEST_COVERED_PART).any(axis=1))
