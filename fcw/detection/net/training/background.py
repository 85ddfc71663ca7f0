"""Windows without a vehicle that the cascade proposes all the same."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.cutting import cut_rectangle
from fcw.detection.boxes.overlap import intersection_areas, vehicle_overlap
from fcw.detection.model import Model
from fcw.detection.net.proposals import ProposalSettings, Proposer
from fcw.detection.net.training.lottery import Lottery
from fcw.detection.net.training.vehicles import lamp_colour, with_glow
from fcw.detection.net.windows import INPUT_PX, WINDOW_UNITS, boxes_of, cut_window
from fcw.detection.training.dataset import LabelledImage, TrainingImage

STORED_UNITS, STORED_PX = 84.0, 63
"""More than the window, as many pixels a unit as the net is given, so that it can be moved a little."""
LARGEST_IOU = 0.35
LARGEST_COVERED_PART = 0.4
LIT_PART = 0.1
MORE_NEAR, MORE_FAR = 2, 3
"""So many times as many windows as in use, however little the cascade thinks of them: to learn from."""


class Background:
    """Proposals that show no vehicle in place; the surer the cascade is of one, the oftener it is drawn."""

    def __init__(
        self,
        images: Sequence[TrainingImage],
        cascade: Model,
        settings: ProposalSettings,
        advance: Callable[[], None] = lambda: None,
    ) -> None:
        settings = replace(
            settings,
            near_count=MORE_NEAR * settings.near_count,
            far_count=MORE_FAR * settings.far_count,
            lowest_score=cascade.rejection_threshold,
        )
        stored: list[NDArray[np.uint8]] = []
        scores: list[float] = []
        proposers: dict[int, Proposer] = {}
        for image in images:
            if image.labelled.complete:
                key = id(image.calibration)
                if key not in proposers:
                    proposers.clear()  # pictures of a clip follow each other, and each takes much memory
                    proposers[key] = Proposer(cascade, image.calibration, settings)
                picture = image.labelled.read()
                placements, found = proposers[key].propose(picture)
                for index in np.flatnonzero(without_vehicle(placements, image.labelled)):
                    stored.append(cut_window(picture, placements[index], STORED_UNITS, STORED_PX))
                    scores.append(float(found[index]))
            advance()
        self._stored = np.array(stored, np.uint8).reshape(-1, STORED_PX, STORED_PX, 3)
        self._any = Lottery(np.exp(np.clip(scores, -4.0, 12.0) / 12.0))

    def __len__(self) -> int:
        return len(self._stored)

    def draw(self, random: np.random.Generator) -> NDArray[np.uint8]:
        """A window of background, perhaps with a light in it: a lone lamp is no vehicle."""
        picture = self._stored[self._any.draw(random)]
        if random.uniform() < LIT_PART:
            column, row = random.uniform(12, 50, 2)
            picture = with_glow(picture, column, row, random.uniform(1.5, 6.0), lamp_colour(random))
        step, stretch = np.exp(random.uniform(-0.1, 0.1)), np.exp(random.uniform(-0.08, 0.08))
        shift = random.uniform(-3.0, 3.0, 2)
        sides = INPUT_PX * step * np.array([stretch, 1.0])
        left, top = (STORED_PX - sides) / 2 + shift
        return cut_rectangle(picture, left, top, sides[0], sides[1], INPUT_PX)


assert round(STORED_UNITS * INPUT_PX / WINDOW_UNITS) == STORED_PX


def without_vehicle(placements: NDArray[np.float64], labelled: LabelledImage) -> NDArray[np.bool_]:
    """(N,) which windows show no vehicle in its place, nor what may be one."""
    square = boxes_of(placements, np.tile([0.0, 0.0, 0.1, -0.1], (len(placements), 1)))
    overlap = vehicle_overlap(square, labelled.boxes, labelled.rear_boxes)
    covered = intersection_areas(square, labelled.boxes[labelled.ignored])
    covered /= np.prod(square[:, 2:], axis=1)[:, None]
    return ~((overlap >= LARGEST_IOU).any(axis=1) | (covered >= LARGEST_COVERED_PART).any(axis=1))
