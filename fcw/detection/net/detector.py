"""The detector: the cascade proposes, the net decides and places."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.detection.boxes.overlap import intersection_over_union
from fcw.detection.boxes.suppression import suppress
from fcw.detection.detector import Detection
from fcw.detection.net.model import NetModel
from fcw.detection.net.proposals import ProposalSettings, Proposer
from fcw.detection.net.windows import INPUT_PX, boxes_of, cut_window

MEAN, SCALE = 127.5, 1 / 127.5


@dataclass(frozen=True, slots=True)
class NetSettings:
    """What the detector does with the net's verdicts.

    Attributes:
        proposals: which windows it is asked about.
        largest_overlap: of two boxes overlapping more (intersection over the smaller area) the better stays.
        near_part: height of a box, as a part of the picture's, from which it is trusted sooner.
        near_bonus: added to the logit for each doubling of the height beyond that. The net does not know how
            large a window is; windows of near vehicles are few, and so are false ones among them: on cameras
            left out a fifth to a tenth as many at the same logit.
        agreeing_iou: windows whose boxes are this near to the best one's have a say in where it is.
        score_threshold: logit from which a window counts as a vehicle; None: the model's.
    """

    proposals: ProposalSettings = ProposalSettings()  # noqa: RUF009 - frozen
    largest_overlap: float = 0.5
    near_part: float = 0.15
    near_bonus: float = 1.6
    agreeing_iou: float = 0.6
    score_threshold: float | None = None


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
        self._proposer = Proposer(model.cascade, calibration, settings.proposals)
        self._net = cv2.dnn.readNetFromONNX(np.frombuffer(model.network, np.uint8))
        given = settings.score_threshold
        self._threshold = model.score_threshold if given is None else given

    @property
    def name(self) -> str:
        """`net`."""
        return "net"

    @property
    def windows_per_frame(self) -> int:
        """Number of windows that the cascade looks at in each picture."""
        return self._proposer.windows_per_frame

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first.

        Raises:
            ValueError: the picture has another size than the calibration.
        """
        if image.shape != (self._size.height, self._size.width, 3) or image.dtype != np.uint8:
            raise ValueError(
                f"the detector expects uint8 BGR pictures of {self._size}, got {image.dtype} of shape "
                f"{image.shape}"
            )
        placements, _ = self._proposer.propose(image)
        if not len(placements):
            return ()
        windows = [cut_window(image, placement) for placement in placements]
        self._net.setInput(cv2.dnn.blobFromImages(windows, SCALE, (INPUT_PX, INPUT_PX), (MEAN,) * 3))
        verdicts = np.asarray(self._net.forward(), np.float64).reshape(-1, 5)
        boxes = self._inside(boxes_of(placements, verdicts[:, 1:]))
        parts = np.maximum(boxes[:, 3] / (self._settings.near_part * self._size.height), 1.0)
        scores = verdicts[:, 0] + self._settings.near_bonus * np.log2(parts)
        sure = (scores >= self._threshold) & np.all(boxes[:, 2:] > 1.0, axis=1)
        return tuple(
            Detection(Box(*box), score)
            for box, score in zip(*self._agreed(boxes[sure], scores[sure]), strict=True)
        )

    def _inside(self, boxes: NDArray[np.float64]) -> NDArray[np.float64]:
        """The boxes cut to the picture."""
        first = np.maximum(boxes[:, :2], -0.5)
        last = np.minimum(boxes[:, :2] + boxes[:, 2:], [self._size.width - 0.5, self._size.height - 0.5])
        return np.hstack([first, last - first])

    def _agreed(
        self, boxes: NDArray[np.float64], scores: NDArray[np.float64]
    ) -> tuple[list[list[float]], list[float]]:
        """The best of those that overlap, each where those that agree with it have it on average."""
        kept = suppress(boxes, scores, self._settings.largest_overlap)
        weights = (intersection_over_union(boxes[kept], boxes) >= self._settings.agreeing_iou) / (
            1.0 + np.exp(-scores)
        )
        weights[np.arange(len(kept)), kept] += 1e-9
        merged = weights @ boxes / weights.sum(axis=1, keepdims=True)
        return merged.tolist(), scores[kept].tolist()
