"""Windows without a vehicle in its place: what a glance takes for one, more or less surely."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.cutting import cut_rectangle
from fcw.detection.boxes.overlap import intersection_areas, vehicle_overlap
from fcw.detection.net.bands import USUAL_FINER, bands_of
from fcw.detection.net.detector import NetSettings
from fcw.detection.net.glance import Glance
from fcw.detection.net.look import LOOK_PX
from fcw.detection.net.onnx_layers import Convolution
from fcw.detection.net.training.lottery import Lottery
from fcw.detection.net.training.vehicles import lamp_colour, with_glow
from fcw.detection.net.windows import WINDOW_UNITS, Pyramid, placements_on
from fcw.detection.training.dataset import LabelledImage, TrainingImage
from fcw.detection.training.looks import Looks, vary_looks
from fcw.errors import UserError

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
        self._stored, self._any = stored, Lottery(weights)

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
        width, height = LOOK_PX * step * stretch, LOOK_PX * step
        left, top = (STORED_PX - width) / 2 + shift[0], (STORED_PX - height) / 2 + shift[1]
        return cut_rectangle(picture, left, top, width, height, LOOK_PX)


assert round(STORED_UNITS * LOOK_PX / WINDOW_UNITS) == STORED_PX


@dataclass(frozen=True, slots=True)
class BackgroundSettings:
    """What of a glance is kept as background.

    Attributes:
        least_logit: of it. In pictures that it learnt from a glance is surer than in others, so that this is
            less than what is looked at in use.
        count: most of a picture, best first.
        largest_iou: boxes that overlap more show the same.
        doubt: each is drawn the oftener the more it looks like a vehicle: by the exponential of its logit
            over this.
    """

    least_logit: float = -5.0
    count: int = 24
    largest_iou: float = 0.6
    doubt: float = 4.0


def mined(
    images: Sequence[TrainingImage],
    net: Sequence[Convolution],
    settings: BackgroundSettings,
    looks: Looks,
    advance: Callable[[], None] = lambda: None,
) -> Background:
    """What a glance sees beside vehicles, in pictures as they are and once more as they might look.

    Only pictures in which every vehicle is labelled are used.

    Raises:
        UserError: there is none, or nothing in them is background.
    """
    stored: list[NDArray[np.uint8]] = []
    logits: list[NDArray[np.float64]] = []
    glance, random, used = Glance(net, settings.least_logit), np.random.default_rng(0), NetSettings()
    for image in images:
        if image.labelled.complete:
            calibration, picture = image.calibration, image.labelled.read()
            # Of what the band for wide lenses shows much is far and has no label: it is no background.
            bands = bands_of(
                calibration.image_size, calibration.camera, used.pitch_tolerance_rad, used.largest_scale
            )[: 1 + len(USUAL_FINER)]
            for shown in (picture, vary_looks(picture, looks, random)):
                pyramid = Pyramid(shown)
                seen = glance.at(pyramid, bands).best(
                    settings.count, settings.largest_iou, settings.least_logit
                )
                without = without_vehicle(seen.boxes, image.labelled)
                placements = placements_on(seen.boxes[without])
                stored.extend(pyramid.windows(placements, STORED_PX, STORED_UNITS))
                logits.append(seen.logits[without])
        advance()
    if not stored:
        raise UserError(
            "the labelled pictures show nothing but vehicles; expected some with all vehicles labelled and "
            "road beside them"
        )
    return Background(stored, np.exp(np.concatenate(logits) / settings.doubt))


def without_vehicle(boxes: NDArray[np.float64], labelled: LabelledImage) -> NDArray[np.bool_]:
    """(N,) which boxes hold no vehicle in its place, nor what may be one."""
    overlap = vehicle_overlap(boxes, labelled.boxes, labelled.rear_boxes)
    covered = intersection_areas(boxes, labelled.boxes[labelled.ignored])
    covered /= np.prod(boxes[:, 2:], axis=1)[:, None]
    return ~((overlap >= LARGEST_IOU).any(axis=1) | (covered >= LARGEST_COVERED_PART).any(axis=1))
