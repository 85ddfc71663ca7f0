"""Training all of the detector: the cascade that proposes, the glance, each look on what is left for it."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from fcw.detection.model import Model
from fcw.detection.net.detector import NetDetector, NetSettings
from fcw.detection.net.looks import FIRST_PX, PickSettings
from fcw.detection.net.model import NetModel
from fcw.detection.net.onnx_layers import Convolution
from fcw.detection.net.proposals import ProposalSettings
from fcw.detection.net.training.background import Background, picked, proposed
from fcw.detection.net.training.batches import BatchSettings, draw_batch
from fcw.detection.net.training.framing import ROUGH
from fcw.detection.net.training.glancing import GlanceSettings, learn_glance
from fcw.detection.net.training.network import FIRST_LOOK, NetworkSettings, learn
from fcw.detection.net.training.scenes import Scenes, SceneSettings
from fcw.detection.net.training.vehicles import Circumstances, Vehicles
from fcw.detection.training.checkpoints import Checkpoints
from fcw.detection.training.dataset import TrainingImage
from fcw.detection.training.dataset import background as is_background
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
NET_LOOKS = Looks(hazy_part=0.3, clearest=0.15, dark_part=0.25)
"""The nets can tell a vehicle in thicker fog than trees can."""
LEFT_OUT_PART = 0.2
"""Of the pictures, to choose the threshold on."""


@dataclass(frozen=True, slots=True)
class NetTrainingSettings:
    """How the detector is trained.

    Attributes:
        cascade: the trees that propose; their second stage and regressor are not trained.
        proposals: what they propose; fewer windows than in use, the likeliest.
        picked: what of it is looked at twice; fewer as well.
        circumstances: what happens to vehicles.
        first: the first look's net.
        first_batches: what it learns from.
        second: the second look's net.
        second_batches: what it learns from.
        scenes: what the glance learns from.
        glance: its net.
        easy_part: of the second look's background, what the cascade proposes, whatever the first look says.
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
    proposals: ProposalSettings = ProposalSettings(counts=(48, 32))  # noqa: RUF009 - frozen
    picked: PickSettings = PickSettings(lowest_logit=-4.0, counts=(10, 8, 8))  # noqa: RUF009 - frozen
    circumstances: Circumstances = Circumstances()  # noqa: RUF009 - frozen
    first: NetworkSettings = FIRST_LOOK
    first_batches: BatchSettings = BatchSettings(  # noqa: RUF009 - frozen
        misplaced_part=0.15, framing=ROUGH, looks=NET_LOOKS, side_px=FIRST_PX
    )
    second: NetworkSettings = NetworkSettings()  # noqa: RUF009 - frozen
    second_batches: BatchSettings = BatchSettings(misplaced_part=0.2, looks=NET_LOOKS)  # noqa: RUF009 - frozen
    scenes: SceneSettings = SceneSettings(looks=NET_LOOKS)  # noqa: RUF009 - frozen
    glance: GlanceSettings = GlanceSettings()  # noqa: RUF009 - frozen
    easy_part: float = 0.3

    def seeded(self, seed: int) -> "NetTrainingSettings":
        """The same with another seed."""
        seeded = {
            name: replace(getattr(self, name), seed=seed) for name in ("cascade", "first", "second", "glance")
        }
        return replace(self, **seeded)


def fit_net(
    images: Sequence[TrainingImage],
    settings: NetTrainingSettings,
    progress: Progress,
    score_threshold: float,
    looks_only: Sequence[TrainingImage] = (),
) -> NetModel:
    """Train the detector.

    Args:
        images: what to learn from.
        settings: how.
        progress: who is told.
        score_threshold: that the model shall have.
        looks_only: what the looks alone learn from as well. Of more kinds of vehicles the looks learn, while
            the cascade, which is small, ranks all of them lower.

    Raises:
        UserError: PyTorch is not installed.
    """
    cascade = _cascade(_by_clip(images), settings, progress)
    images = _by_clip([*images, *looks_only])
    glance = _glance(images, settings, progress)  # its pictures are given back before the looks need memory
    progress.stage("cutting vehicles for the looks", len(images))
    vehicles = Vehicles(images, settings.circumstances, progress.advance)
    progress.stage("proposing background", len(images))
    easy = proposed(images, cascade, settings.proposals, progress.advance)
    first = _look("first", vehicles, easy, settings.first, settings.first_batches, progress)
    cascade = replace(cascade, rejection_threshold=REJECTION_THRESHOLD)
    progress.stage("picking background", len(images))
    hard = picked(images, cascade, first, (settings.proposals, settings.picked), NET_LOOKS, progress.advance)
    others = hard.with_more(easy, settings.easy_part)
    second = _look("second", vehicles, others, settings.second, settings.second_batches, progress)
    return NetModel(cascade, first, second, glance, score_threshold)


def _by_clip(images: Sequence[TrainingImage]) -> list[TrainingImage]:
    """Pictures of one clip together, so that each camera is planned for once."""
    return sorted(images, key=lambda image: (image.labelled.clip, str(image.labelled.path)))


def _glance(
    images: Sequence[TrainingImage], settings: NetTrainingSettings, progress: Progress
) -> tuple[Convolution, ...]:
    progress.stage("reading pictures for the glance", len(images))
    scenes = Scenes(images, settings.scenes, progress.advance)
    progress.note(f"the glance learns from {len(scenes)} vehicles", vehicles=len(scenes))
    with _counted_steps("the glance", settings.glance.steps, progress) as on_step:
        return learn_glance(scenes.draw, settings.glance, on_step)


@contextmanager
def _counted_steps(name: str, steps: int, progress: Progress) -> Iterator[Callable[[float], None]]:
    """Shows how far a net has learnt; to be told the loss after each step."""
    progress.stage(f"{name} learns", steps)
    losses: list[float] = []

    def on_step(loss: float) -> None:
        losses.append(loss)
        progress.advance()

    yield on_step
    last = float(np.mean(losses[-100:]))
    progress.note(f"its loss over the last steps: {last:.3f}", loss=last)


def _look(
    name: str,
    vehicles: Vehicles,
    background: Background,
    settings: NetworkSettings,
    batches: BatchSettings,
    progress: Progress,
) -> bytes:
    progress.note(
        f"the {name} look learns from {len(vehicles)} vehicles and {len(background)} windows of background",
        vehicles=len(vehicles),
        background=len(background),
    )
    with _counted_steps(f"the {name} look", settings.steps, progress) as on_step:
        return learn(lambda random: draw_batch(vehicles, background, batches, random), settings, on_step)


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
    looks_only: Sequence[TrainingImage] = (),
) -> NetModel:
    """Train the detector, and choose its threshold on clips that a first training leaves out.

    Args:
        images: what to learn from.
        settings: how.
        progress: who is told.
        score_threshold: of the model; None: the lowest with no more than `cascade.fppi` detections of mere
            background for each picture left out.
        looks_only: what the looks alone learn from as well; none of it is left out.

    Raises:
        UserError: PyTorch is not installed, or there are too few clips to leave one out.
    """
    if score_threshold is None:
        left_out = _some_clips(images, settings.cascade.seed)
        learnt = [image for image in images if image not in left_out]
        first = fit_net(learnt, settings, progress, 0.0, looks_only)
        score_threshold = _threshold(first, left_out, settings, progress)
    return fit_net(images, settings, progress, score_threshold, looks_only)


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
    every = NetSettings(score_threshold=-np.inf)
    scores: list[float] = []
    progress.stage("choosing the threshold", len(images))
    for image in images:
        found = NetDetector(model, image.calibration, every).detect(image.labelled.read())
        boxes = np.array([(d.box.x, d.box.y, d.box.w, d.box.h) for d in found]).reshape(-1, 4)
        labelled = image.labelled
        false = is_background(boxes, labelled.boxes, labelled.ignored, labelled.rear_boxes)
        scores += [detection.score for detection, is_false in zip(found, false, strict=True) if is_false]
        progress.advance()
    scores.sort(reverse=True)
    allowed = int(settings.cascade.fppi * len(images))
    threshold = float(np.nextafter(scores[allowed], np.inf)) if len(scores) > allowed else 0.0
    progress.note(f"score threshold {threshold:.2f}, from {len(images)} pictures left out")
    return threshold
