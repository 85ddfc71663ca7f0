"""Training all of the detector: the glance, and the look at what it takes for vehicles."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from fcw.detection.net.model import NetModel
from fcw.detection.net.onnx_layers import Convolution, read_layers
from fcw.detection.net.training.background import BackgroundSettings, mined
from fcw.detection.net.training.batches import BatchSettings, draw_batch
from fcw.detection.net.training.glancing import GlanceSettings, learn_glance
from fcw.detection.net.training.left_out import chosen_threshold, some_clips
from fcw.detection.net.training.network import NetworkSettings, learn
from fcw.detection.net.training.scenes import Scenes, SceneSettings
from fcw.detection.net.training.vehicles import Circumstances, Vehicles
from fcw.detection.training.dataset import TrainingImage
from fcw.detection.training.looks import Looks
from fcw.detection.training.settings import PAPERS_FPPI, Progress

LOOKS = Looks(hazy_part=0.3, clearest=0.15, dark_part=0.25)
"""The nets can tell a vehicle in thicker fog than trees can."""
GOING_ON_STEPS, GOING_ON_RATE = 0.25, 0.2
"""Parts of the steps and of the learning rate that it takes to go on from what was learnt before."""


@dataclass(frozen=True, slots=True)
class NetTrainingSettings:
    """How the detector is trained.

    Attributes:
        scenes: what the glance learns from.
        glance: its net.
        circumstances: what happens to vehicles that the look learns from.
        background: what it learns from beside them.
        batches: how it is shown both.
        look: its net.
        fppi: detections of mere background for each picture left out, by which the threshold is chosen.
        seed: of what is drawn, and of the pictures left out.
    """

    scenes: SceneSettings = SceneSettings(looks=LOOKS)  # noqa: RUF009 - frozen
    glance: GlanceSettings = GlanceSettings()  # noqa: RUF009 - frozen
    circumstances: Circumstances = Circumstances()  # noqa: RUF009 - frozen
    background: BackgroundSettings = BackgroundSettings()  # noqa: RUF009 - frozen
    batches: BatchSettings = BatchSettings(looks=LOOKS)  # noqa: RUF009 - frozen
    look: NetworkSettings = NetworkSettings()  # noqa: RUF009 - frozen
    fppi: float = PAPERS_FPPI
    seed: int = 0

    def seeded(self, seed: int) -> "NetTrainingSettings":
        """The same with another seed."""
        glance, look = replace(self.glance, seed=seed), replace(self.look, seed=seed)
        return replace(self, glance=glance, look=look, seed=seed)

    def going_on(self) -> "NetTrainingSettings":
        """The same for nets that have learnt before: fewer and smaller steps."""
        glance, look = (
            replace(
                each,
                steps=max(round(GOING_ON_STEPS * each.steps), 1),
                learning_rate=GOING_ON_RATE * each.learning_rate,
            )
            for each in (self.glance, self.look)
        )
        return replace(self, glance=glance, look=look)


def fit_net(
    images: Sequence[TrainingImage],
    settings: NetTrainingSettings,
    progress: Progress,
    score_threshold: float,
    start: NetModel | None = None,
) -> NetModel:
    """Train the detector.

    Args:
        images: what to learn from.
        settings: how.
        progress: who is told.
        score_threshold: that the model shall have.
        start: a model to go on from; None: nothing was learnt before.

    Raises:
        UserError: PyTorch is not installed, or no background is in the pictures.
    """
    images = _by_clip(images)
    # Its pictures are given back before the look needs memory.
    glance = _glance(images, settings, progress, start)
    return NetModel(glance, _look(images, glance, settings, progress, start), score_threshold)


def _by_clip(images: Sequence[TrainingImage]) -> list[TrainingImage]:
    """Pictures of one clip together: in the same order, whichever folder they came from first."""
    return sorted(images, key=lambda image: (image.labelled.clip, str(image.labelled.path)))


def _glance(
    images: Sequence[TrainingImage],
    settings: NetTrainingSettings,
    progress: Progress,
    start: NetModel | None,
) -> tuple[Convolution, ...]:
    progress.stage("reading pictures for the glance", len(images))
    scenes = Scenes(images, settings.scenes, progress.advance)
    progress.note(f"the glance learns from {len(scenes)} vehicles", vehicles=len(scenes))
    with _counted_steps("the glance", settings.glance.steps, progress) as on_step:
        return learn_glance(scenes.draw, settings.glance, on_step, None if start is None else start.glance)


def _look(
    images: Sequence[TrainingImage],
    glance: Sequence[Convolution],
    settings: NetTrainingSettings,
    progress: Progress,
    start: NetModel | None,
) -> bytes:
    progress.stage("cutting vehicles for the look", len(images))
    vehicles = Vehicles(images, settings.circumstances, progress.advance)
    progress.stage("cutting background", len(images))
    background = mined(images, glance, settings.background, LOOKS, progress.advance)
    progress.note(
        f"the look learns from {len(vehicles)} vehicles and {len(background)} windows of background",
        vehicles=len(vehicles),
        background=len(background),
    )
    with _counted_steps("the look", settings.look.steps, progress) as on_step:
        return learn(
            lambda random: draw_batch(vehicles, background, settings.batches, random),
            settings.look,
            on_step,
            None if start is None else read_layers(start.look),
        )


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


def train_net(
    images: Sequence[TrainingImage],
    settings: NetTrainingSettings,
    progress: Progress,
    score_threshold: float | None = None,
    start: NetModel | None = None,
) -> NetModel:
    """Train the detector, and choose its threshold on clips that a first training leaves out.

    Args:
        images: what to learn from.
        settings: how.
        progress: who is told.
        score_threshold: of the model; None: the lowest with no more than `fppi` detections of mere
            background for each picture left out.
        start: a model to go on from; None: nothing was learnt before.

    Raises:
        UserError: PyTorch is not installed, or there are too few clips to leave one out.
    """
    if score_threshold is None:
        left_out = some_clips(images, settings.seed)
        learnt = [image for image in images if image not in left_out]
        first = fit_net(learnt, settings, progress, 0.0, start)
        score_threshold = chosen_threshold(first, left_out, settings.fppi, progress)
    return fit_net(images, settings, progress, score_threshold, start)
