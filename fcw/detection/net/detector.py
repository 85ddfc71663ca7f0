"""The detector: a glance at the picture and its bands proposes, a closer look places, both decide."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.uncertainty import camera_sigmas
from fcw.detection.boxes.overlap import intersection_over_union
from fcw.detection.boxes.plausible import CUT_MARGIN
from fcw.detection.boxes.suppression import suppress
from fcw.detection.detector import Aim, Detection
from fcw.detection.net.bands import bands_of
from fcw.detection.net.glance import CELL_PX, Glance, Glanced
from fcw.detection.net.look import Look
from fcw.detection.net.model import NetModel
from fcw.detection.net.windows import Pyramid, placements_on

LOOKED_AGAIN = 0.88, 1.12
"""Sizes of the vehicle that the net expects where it looks again, beside the one that it found."""

GLANCE_AGREES = 0.5
"""IoU from which a box of the glance shows the vehicle that a box of the look shows."""


@dataclass(frozen=True, slots=True)
class NetSettings:
    """What is looked at, and what the detector does with the verdicts.

    Attributes:
        pitch_tolerance_rad: by how much the calibration's pitch may be off.
        largest_scale: how far bands may enlarge the picture.
        glance_from: logit from which a cell of the glance says something; where none agrees with a box it
            counts as this.
        looked_from: logit of the glance from which what it sees is looked at.
        looked_at: most of that, best first.
        looked_iou: boxes of the glance that overlap more show the same.
        looked_size: size of the vehicle that the look expects, beside the glance's: boxes of the look err to
            what it expects, and with this they are as wide as those that people drew.
        glance_share: what the glance counts for near vehicles, beside the look: in what they are, and where.
        glance_parts: height of a box, as a part of the picture's, up to which the glance has no say, and
            from which it has its share.
        again_from: logit from which the look is taken again. On cameras left out it does not matter
            whether it is below.
        sizes_m: sqrt(w h) that a vehicle may have where its box stands on the road: motorcycle to bus.
            On cameras left out a tenth of the false boxes are larger, houses and trees, and no vehicle; 3.7 m
            would lose lorries.
        size_tolerances: by so many tolerances the pitch may be off before a box is too small, and too large.
            Having no limit at all costs nothing on the drives kept for judging, on which this was chosen
            (`benchmarks/more_vehicles/wrong_pitch.py`).
        largest_overlap: of two boxes overlapping more (intersection over the smaller area) the better stays.
        near_part: height of a box, as a part of the picture's, from which it is trusted sooner.
        nearest_part: height, likewise, beyond which it is trusted no sooner still: houses are that high too.
        near_bonus: added to the logit for each doubling of the height between. The net does not know how
            large a window is; windows of near vehicles are few, and so are false ones among them: on cameras
            left out a fifth to a tenth as many at the same logit. Chosen there, of 1.0, 1.2 and 1.3.
        wide_aspect: width over height from which a box is trusted sooner: so wide are vehicles that stand
            across or pass the other way, and little else.
        widest_aspect: from which it is trusted no sooner still.
        wide_bonus: added to the logit for each doubling between. The net learnt rears, and gives sides and
            fronts less than they deserve. Of 0 to 6, 4 to 6 foretell best which boxes are vehicles on
            cameras left out (`benchmarks/wide_boxes.py`, with a net that learnt from most of them); with 5,
            one of ten rendered cars that stop beside our way was warned of.
        agreeing_iou: windows whose boxes are this near to the best one's have a say in where it is, and bear
            it out.
        borne_out: added to the logit for each e-fold of the number of windows that bear it out, each counted
            by how sure it is. A vehicle lights up several, chance few: on cameras left out this finds more
            at the same false boxes. Chosen there and on Cityscapes, of 0.5, 1.0 and 2.0.
        score_threshold: logit from which a window counts as a vehicle; None: the model's.
        faint_margin: windows up to so much below it are handed on as faint.
    """

    pitch_tolerance_rad: float = math.radians(1.0)
    largest_scale: float = 2.0
    glance_from: float = -3.0
    looked_from: float = 0.0
    looked_at: int = 24
    looked_iou: float = 0.75
    looked_size: float = 0.92
    glance_share: float = 0.5
    glance_parts: tuple[float, float] = (0.08, 0.13)
    again_from: float = 0.0
    sizes_m: tuple[float, float] = (1.0, 4.0)
    size_tolerances: tuple[float, float] = (6.0, 6.0)
    largest_overlap: float = 0.5
    near_part: float = 0.1
    nearest_part: float = 0.4
    near_bonus: float = 1.2
    wide_aspect: float = 1.5
    widest_aspect: float = 2.1
    wide_bonus: float = 4.0
    agreeing_iou: float = 0.6
    borne_out: float = 0.5
    score_threshold: float | None = None
    faint_margin: float = 0.0


class NetDetector:
    """Vehicles seen from behind: their whole visible body, the box that ranging expects.

    An instance owns scratch memory: use one for each thread.

    Raises:
        UserError: by the calibration the road is not in the picture.
    """

    def __init__(
        self, model: NetModel, calibration: Calibration, settings: NetSettings = NetSettings()
    ) -> None:
        self._settings, self._size = settings, calibration.image_size
        self._calibrated, self._height_m = calibration.camera, calibration.camera.height_m
        self._focal_sigma_px = camera_sigmas(calibration).focal_y_px
        self._aim: Aim | None = None
        self.aim(Aim(calibration.camera.pitch_rad, settings.pitch_tolerance_rad))
        self._glance, self._look = Glance(model.glance, settings.glance_from), Look(model.look)
        given, self._usual_threshold = settings.score_threshold, model.score_threshold
        self._threshold = self._usual_threshold if given is None else given

    @property
    def name(self) -> str:
        """`net`."""
        return "net"

    def aim(self, aim: Aim) -> None:
        """See `fcw.detection.detector.AimedDetector`."""
        if aim == self._aim:
            return
        camera = replace(self._calibrated, pitch_rad=aim.pitch_rad)
        tolerance_rad = max(aim.tolerance_rad, self._settings.pitch_tolerance_rad)
        self._bands = bands_of(
            self._size, camera, tolerance_rad, self._settings.largest_scale, self._focal_sigma_px
        )
        self._horizon_row_px = camera.horizon_row_px
        self._tolerance_px = camera.focal_y_px * math.tan(tolerance_rad)
        self._aim = aim

    @property
    def windows_per_frame(self) -> int:
        """Number of cells in which the glance looks for vehicles."""
        return sum(band.shown.width * band.shown.height for band in self._bands) // CELL_PX**2

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first.

        Raises:
            ValueError: the picture has another size than the calibration.
        """
        pyramid = self.pyramid(image)
        seen = self.glance(pyramid)
        boxes, logits = self.look(pyramid, seen)
        return self.decide(*self.with_glance(seen, boxes, logits))

    def pyramid(self, image: NDArray[np.uint8]) -> Pyramid:
        """A (height, width, 3) BGR picture and its halves.

        Raises:
            ValueError: it has another size than the calibration.
        """
        if image.shape != (self._size.height, self._size.width, 3) or image.dtype != np.uint8:
            raise ValueError(
                f"the detector expects uint8 BGR pictures of {self._size}, got {image.dtype} of shape "
                f"{image.shape}"
            )
        return Pyramid(image)

    def glance(self, pyramid: Pyramid) -> Glanced:
        """What the net that sees the picture and its bands takes for vehicles."""
        return self._glance.at(pyramid, self._bands)

    def look(self, pyramid: Pyramid, seen: Glanced) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(M, 4) boxes and (M,) logits of the best of what a glance saw, by the net that sees it alone.

        Where it may be a vehicle the net looks twice more, at the mirror images of windows in which it would
        stand, a little nearer and further away: the net errs otherwise there, and the mean of all errs less.
        """
        settings = self._settings
        best = seen.best(settings.looked_at, settings.looked_iou, settings.looked_from)
        boxes, logits = self._look.at(pyramid, placements_on(best.boxes) * (1.0, 1.0, settings.looked_size))
        maybe = np.flatnonzero(logits >= settings.again_from)
        found = placements_on(boxes[maybe])
        again = np.concatenate([found * (1.0, 1.0, part) for part in LOOKED_AGAIN])
        more_boxes, more_logits = self._look.at(pyramid, again, mirrored=True)
        boxes[maybe] = np.mean([boxes[maybe], *more_boxes.reshape(len(LOOKED_AGAIN), -1, 4)], axis=0)
        logits[maybe] = np.mean([logits[maybe], *more_logits.reshape(len(LOOKED_AGAIN), -1)], axis=0)
        return boxes, logits

    def with_glance(
        self, seen: Glanced, boxes: NDArray[np.float64], logits: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(M, 4) boxes and (M,) logits by the look, those of near vehicles in part by the glance."""
        settings, (low, high) = self._settings, self._settings.glance_parts
        near = np.clip((boxes[:, 3] / self._size.height - low) / (high - low), 0.0, 1.0)
        share = settings.glance_share * near
        glanced = seen.logits_of(boxes, GLANCE_AGREES, settings.glance_from)
        placed = seen.boxes_of(boxes, settings.agreeing_iou)
        return boxes + share[:, None] * (placed - boxes), logits + share * (glanced - logits)

    def decide(self, boxes: NDArray[np.float64], logits: NDArray[np.float64]) -> tuple[Detection, ...]:
        """Vehicles, best score first, of the (M, 4) boxes and (M,) logits of the look."""
        settings, boxes = self._settings, self._inside(boxes)
        possible = np.all(boxes[:, 2:] > 1.0, axis=1) & self._has_size(boxes)
        boxes, scores = boxes[possible], logits[possible]
        parts, aspects = boxes[:, 3] / self._size.height, boxes[:, 2] / boxes[:, 3]
        scores = scores + settings.near_bonus * doublings(parts, settings.near_part, settings.nearest_part)
        scores += settings.wide_bonus * doublings(aspects, settings.wide_aspect, settings.widest_aspect)
        agreeing = intersection_over_union(boxes, boxes) >= settings.agreeing_iou
        np.fill_diagonal(agreeing, True)  # else one may miss it by a hair
        scores += settings.borne_out * np.log(agreeing @ _probability(scores))
        heard = scores >= min(self._threshold, self._usual_threshold) - settings.faint_margin
        return tuple(
            Detection(Box(*box), score, faint=score < self._threshold)
            for box, score in zip(*self._agreed(boxes[heard], scores[heard]), strict=True)
            if score >= self._threshold - settings.faint_margin
        )

    def _has_size(self, boxes: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(N,) which are as large as a vehicle, for some pitch of the camera.

        What ends at the picture's bottom may be nearer, and so smaller, than it looks. The pitch may be far
        off: a lead that is never found cannot correct it.
        """
        low_m, high_m = self._settings.sizes_m
        bottoms = boxes[:, 1] + boxes[:, 3]
        sizes = np.sqrt(np.maximum(boxes[:, 2] * boxes[:, 3], 0.0)) * self._height_m
        rows = bottoms - self._horizon_row_px
        cut = bottoms >= self._size.height - 1 - CUT_MARGIN * self._size.height
        lower_px, higher_px = (each * self._tolerance_px for each in self._settings.size_tolerances)
        small_enough = cut | (sizes <= high_m * (rows + higher_px))
        return small_enough & (sizes >= low_m * (rows - lower_px))

    def _inside(self, boxes: NDArray[np.float64]) -> NDArray[np.float64]:
        """The boxes cut to the picture."""
        first = np.maximum(boxes[:, :2], -0.5)
        last = np.minimum(boxes[:, :2] + boxes[:, 2:], [self._size.width - 0.5, self._size.height - 0.5])
        return np.hstack([first, last - first])

    def _agreed(
        self, boxes: NDArray[np.float64], scores: NDArray[np.float64]
    ) -> tuple[list[list[float]], list[float]]:
        """The best of those that overlap, each where those that agree with it have it on average.

        Windows below the threshold, the detector's or the model's, have no say in where the vehicle of one
        above it is: asked for all scores the detector puts a vehicle where it puts it otherwise.
        """
        kept = suppress(boxes, scores, self._settings.largest_overlap)
        heard_from = np.where(scores >= self._threshold, self._threshold, -np.inf)
        heard_from[scores >= self._usual_threshold] = self._usual_threshold
        agreeing = intersection_over_union(boxes[kept], boxes) >= self._settings.agreeing_iou
        weights = (agreeing & (scores >= heard_from[kept, None])) * _probability(scores)
        weights[np.arange(len(kept)), kept] += 1e-9
        merged = weights @ boxes / weights.sum(axis=1, keepdims=True)
        return merged.tolist(), scores[kept].tolist()


def doublings(values: NDArray[np.float64], first: float, last: float) -> NDArray[np.float64]:
    """How often each of the values has doubled since `first`, no further than to `last`."""
    return np.log2(np.clip(values, first, last) / first)


def _probability(logits: NDArray[np.float64]) -> NDArray[np.float64]:
    return 1.0 / (1.0 + np.exp(-logits))
