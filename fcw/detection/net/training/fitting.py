"""Training all of the detector: the cascade that proposes, then the net on what it proposes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fcw.detection.model import Model
from fcw.detection.net.detector import NetDetector, NetSettings
from fcw.detection.net.model import NetModel
from fcw.detection.net.proposals import ProposalSettings
from fcw.detection.net.training.background import Background
from fcw.detection.net.training.batches import BatchSettings, draw_batch
from fcw.detection.net.training.network import NetworkSettings, learn
from fcw.detection.net.training.vehicles import Circumstances, Vehicles
from fcw.detection.training.checkpoints import Checkpoints
from fcw.detection.training.dataset import TrainingImage, background
from fcw.detection.training.fitting import Fitter
from fcw.detection.training.looks import Looks
from fcw.detection.training.samples import Augmentation
from fcw.detection.training.settings import Progress, TrainingSettings
from fcw.detection.windows.statistics import vehicle_statistics
from fcw.errors import UserError

SIZES_M = (0.9, 5.0)
"""sqrt(w h) searched for: a small car has 1.4 m, a lorry from a corner 4; and calibrations err."""
LEARNING_THRESHOLD = -4.0
"""Of the cascade while it proposes background to learn from."""
REJECTION_THRESHOLD = -1.5
"""Of the cascade in use; lower ones take longer, and on cameras left out find no more."""
LOOKS = Looks()
LEFT_OUT_PART = 0.2
"""Of the pictures, to choose the threshold on."""


@dataclass(frozen=True, slots=True)
class NetTrainingSettings:
    """How the detector is trained.

    Attributes:
        cascade: the trees that propose; their second stage and regressor are not trained.
        proposals: what they propose, in use.
        batches: what the net learns from.
        circumstances: what happens to vehicles.
        network: the net.
    """

    cascade: TrainingSettings = TrainingSettings(  # noqa: RUF009 - frozen
        crops_per_vehicle=3,
        displaced_per_vehicle=0,
        mined_per_image=30,
        max_negatives=22_000,
        whole_image_every=0,
        search=ProposalSettings().search,
        augmentation=Augmentation(looks=LOOKS),
        mined_looks=LOOKS,
    )
    proposals: ProposalSettings = ProposalSettings()  # noqa: RUF009 - frozen
    batches: BatchSettings = BatchSettings(looks=LOOKS)  # noqa: RUF009 - frozen
    circumstances: Circumstances = Circumstances()  # noqa: RUF009 - frozen
    network: NetworkSettings = NetworkSettings()  # noqa: RUF009 - frozen

    def seeded(self, seed: int) -> "NetTrainingSettings":
        """The same with another seed."""
        return replace(
            self, cascade=replace(self.cascade, seed=seed), network=replace(self.network, seed=seed)
        )


def fit_net(
    images: Sequence[TrainingImage],
    settings: NetTrainingSettings,
    progress: Progress,
    score_threshold: float,
) -> NetModel:
    """Train the detector.

    Args:
        images: what to learn from.
        settings: how.
        progress: who is told.
        score_threshold: that the model shall have.

    Raises:
        UserError: PyTorch is not installed.
    """
    # Pictures of one clip stand together, so that each camera is planned for once.
    images = sorted(images, key=lambda image: (image.labelled.clip, str(image.labelled.path)))
    cascade = _cascade(images, settings, progress)
    progress.stage("cutting vehicles for the net", len(images))
    vehicles = Vehicles(images, settings.circumstances, progress.advance)
    progress.stage("proposing background for the net", len(images))
    others = Background(images, cascade, settings.proposals, progress.advance)
    progress.note(
        f"the net learns from {len(vehicles)} vehicles and {len(others)} windows of background",
        vehicles=len(vehicles),
        background=len(others),
    )
    progress.stage("the net learns", settings.network.steps)
    losses: list[float] = []

    def on_step(loss: float) -> None:
        losses.append(loss)
        progress.advance()

    network = learn(
        lambda random: draw_batch(vehicles, others, settings.batches, random), settings.network, on_step
    )
    last = float(np.mean(losses[-100:]))
    progress.note(f"the net's loss over the last steps: {last:.3f}", loss=last)
    return NetModel(replace(cascade, rejection_threshold=REJECTION_THRESHOLD), network, score_threshold)


def _cascade(images: Sequence[TrainingImage], settings: NetTrainingSettings, progress: Progress) -> Model:
    low_m, high_m = SIZES_M
    statistics = replace(vehicle_statistics(images), size_low_m=low_m, size_high_m=high_m)
    fitter = Fitter(images, statistics, settings.cascade, progress, Checkpoints(None, ""))
    model, _ = fitter.cascade(np.arange(len(images)), "the net's cascade")
    return replace(model, rejection_threshold=LEARNING_THRESHOLD)


def train_net(
    images: Sequence[TrainingImage],
    settings: NetTrainingSettings,
    progress: Progress,
    score_threshold: float | None = None,
) -> NetModel:
    """Train the detector, and choose its threshold on clips that a first training leaves out.

    Args:
        images: what to learn from.
        settings: how.
        progress: who is told.
        score_threshold: of the model; None: the lowest with no more than `cascade.fppi` detections of mere
            background for each picture left out.

    Raises:
        UserError: PyTorch is not installed, or there are too few clips to leave one out.
    """
    if score_threshold is None:
        left_out = _some_clips(images, settings.cascade.seed)
        first = fit_net([image for image in images if image not in left_out], settings, progress, 0.0)
        score_threshold = _threshold(first, left_out, settings, progress)
    return fit_net(images, settings, progress, score_threshold)


def _some_clips(images: Sequence[TrainingImage], seed: int) -> list[TrainingImage]:
    """All pictures of some clips, drawn until they are a fifth of all."""
    clips = sorted({image.labelled.clip for image in images if image.labelled.complete})
    if len(clips) < 2:
        raise UserError(
            "the labelled pictures are of one clip, so that none can be left out to choose the threshold on; "
            "label another, or give --score-threshold"
        )
    left_out: list[TrainingImage] = []
    for index in np.random.default_rng(seed).permutation(len(clips))[: len(clips) - 1]:
        if len(left_out) >= LEFT_OUT_PART * len(images):
            break
        left_out += [image for image in images if image.labelled.clip == clips[index]]
    return left_out


def _threshold(
    model: NetModel, images: Sequence[TrainingImage], settings: NetTrainingSettings, progress: Progress
) -> float:
    every = NetSettings(settings.proposals, score_threshold=-np.inf)
    scores: list[float] = []
    progress.stage("choosing the threshold", len(images))
    for image in images:
        found = NetDetector(model, image.calibration, every).detect(image.labelled.read())
        boxes = np.array([(d.box.x, d.box.y, d.box.w, d.box.h) for d in found]).reshape(-1, 4)
        labelled = image.labelled
        false = background(boxes, labelled.boxes, labelled.ignored, labelled.rear_boxes)
        scores += [detection.score for detection, is_false in zip(found, false, strict=True) if is_false]
        progress.advance()
    scores.sort(reverse=True)
    allowed = int(settings.cascade.fppi * len(images))
    threshold = float(np.nextafter(scores[allowed], np.inf)) if len(scores) > allowed else 0.0
    progress.note(f"score threshold {threshold:.2f}, from {len(images)} pictures left out")
    return threshold
