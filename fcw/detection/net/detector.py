"""The detector: a glance at the picture and its bands proposes boxes, and a closer look refines them."""

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
"""Where the net looks again, its windows expect vehicles of these sizes, relative to the one that it
found."""

GLANCE_AGREES = 0.5
"""IoU from which a box of the glance and one of the look are of the same vehicle."""


@dataclass(frozen=True, slots=True)
class NetSettings:
    """What is looked at, and how scores and boxes are combined.

    "Cameras left out" are those that a net was not trained on.

    Attributes:
        pitch_tolerance_rad: largest error of the calibration's pitch.
        largest_scale: largest factor by which bands may enlarge the picture.
        glance_from: least logit of a cell of the glance; also the logit that counts if no cell agrees with a
            box.
        looked_from: least logit of the glance's boxes that are looked at.
        looked_at: the largest number of these, best first.
        looked_iou: of two boxes of the glance with a larger IoU, only the better is looked at.
        looked_size: size of the vehicle that the look's window expects, relative to the glance's box. Boxes
            of the look are biased towards the expected size; with this, they are as wide as boxes drawn by
            hand.
        glance_share: weight of the glance, beside the look, in logit and box of near vehicles.
        glance_parts: height of a box, as a fraction of the picture's, up to which the glance has no weight,
            and from which it has its full share.
        again_from: least logit of the look for looking again. On cameras left out, a lower one makes no
            difference.
        sizes_m: smallest and largest sqrt(w h) of a vehicle at its place on the road: motorcycle to bus. On
            cameras left out, a tenth of the false boxes are larger, houses and trees, and no vehicle is; 3.7
            m would lose lorries.
        size_tolerances: error of the pitch, in tolerances, that is allowed for before a box counts as too
            small, and as too large. Having no limit at all costs nothing on the drives kept for judging, on
            which this was chosen (`benchmarks/more_vehicles/wrong_pitch.py`).
        largest_overlap: of two boxes with more overlap (intersection over the smaller area), the better is
            kept.
        near_part: height of a box, as a fraction of the picture's, from which it gets a bonus.
        nearest_part: height from which the bonus grows no further, as houses are that high, too.
        near_bonus: bonus to the logit for each doubling of the height in between. The net does not know how
            large a window is. There are few windows for near vehicles, and so few false ones among them: on
            cameras left out, a fifth to a tenth as many at the same logit. Chosen there, of 1.0, 1.2 and 1.3.
        wide_aspect: width over height of a box from which it gets a bonus. Vehicles that stand across, or are
            passed in the other direction, are so wide, and little else is.
        widest_aspect: width over height from which this bonus grows no further.
        wide_bonus: bonus to the logit for each doubling of width over height in between. The net was trained
            on rears, and scores sides and fronts too low. Of 0 to 6, 4 to 6 predict best which boxes are
            vehicles on cameras left out (`benchmarks/wide_boxes.py`, with a net trained on most of them);
            with 5, one of ten rendered cars that stop beside our path was warned of.
        agreeing_iou: IoU from which the boxes of two windows agree. Agreeing windows are averaged, and
            support each other.
        borne_out: bonus to the logit for each e-fold of the number of agreeing windows, each weighted by its
            probability. A vehicle raises several windows, chance only a few: on cameras left out, this finds
            more vehicles with as many false boxes. Chosen there and on Cityscapes, of 0.5, 1.0 and 2.0.
        score_threshold: least logit of a detection; None for the model's.
        faint_margin: boxes with a logit up to this much below the threshold are returned as faint.
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
    """Detects vehicles seen from behind. Boxes enclose the whole visible body, as ranging expects.

    An instance owns working memory, so each thread needs its own.

    Raises:
        UserError: the calibration puts the road outside the picture.
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
        np.fill_diagonal(agreeing, True)  # a box's IoU with itself may be rounded to less than 1
        scores += settings.borne_out * np.log(agreeing @ _probability(scores))
        heard = scores >= min(self._threshold, self._usual_threshold) - settings.faint_margin
        return tuple(
            Detection(Box(*box), score, faint=score < self._threshold)
            for box, score in zip(*self._agreed(boxes[heard], scores[heard]), strict=True)
            if score >= self._threshold - settings.faint_margin
        )

    def _has_size(self, boxes: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(N,) which boxes have the size of a vehicle, for some pitch of the camera.

        A box that ends at the picture's bottom may be nearer, and so smaller, than it looks. A large error of
        the pitch is allowed for, because only vehicles that are found can correct it.
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
        """Non-maximum suppression; each box that is kept is averaged with those that agree with it.

        Boxes below the threshold (the detector's or the model's) do not change the average of one above it.
        So the boxes of vehicles are the same if the detector is asked for boxes of all scores.
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
    """Base-2 logarithm of each value over `first`, between 0 and that of `last`."""
    return np.log2(np.clip(values, first, last) / first)


def _probability(logits: NDArray[np.float64]) -> NDArray[np.float64]:
    return 1.0 / (1.0 + np.exp(-logits))
