"""How a model is trained, and who is told how it goes."""

from dataclasses import dataclass
from typing import Protocol

from fcw.detection.acf import AcfSettings
from fcw.detection.training.samples import Augmentation

PAPERS_FPPI = 0.046
"""Where the paper works (Table 3)."""


@dataclass(frozen=True, slots=True)
class TrainingSettings:
    """How a model is trained.

    Attributes:
        tree_counts: trees of each round; before each but the first, hard negatives are mined.
        second_tree_count: trees of each run of the second stage.
        second_runs: independent runs whose mean is the second stage: what one run says of a vehicle unlike
            those it learnt from is a matter of luck.
        crops_per_vehicle: jittered windows of each vehicle, and as many mirrored ones.
        displaced_per_vehicle: windows of each vehicle, and as many mirrored ones, for the box regressor.
        random_per_image: windows from anywhere on the road, the first round's negatives.
        mined_per_image: largest number of hard negatives that a round takes from a picture.
        whole_image_every: one picture in so many is also mined without the distance prior, so that the trees
            know what lies off the road as well, where plain ACF looks; 0: none.
        search: where hard negatives are looked for.
        max_negatives: largest number of negatives in a round; the newest go first.
        rejection_threshold: constant soft cascade while mining.
        lowest_rejection_threshold: of the model; vehicles unlike those learnt from pass a lower one.
        folds: parts of the pictures held out in turn to choose the thresholds.
        fppi: detections of mere background per held-out picture at the shipped score threshold.
        augmentation: of windows.
        displacement: of the box regressor's windows.
        ridge: the box regressor's penalty.
        seed: of everything random.
    """

    tree_counts: tuple[int, ...] = (64, 256, 512)
    second_tree_count: int = 256
    second_runs: int = 4
    crops_per_vehicle: int = 8
    displaced_per_vehicle: int = 6
    random_per_image: int = 15
    mined_per_image: int = 40
    whole_image_every: int = 4
    search: AcfSettings = AcfSettings()  # noqa: RUF009 - frozen
    max_negatives: int = 30_000
    rejection_threshold: float = -3.0
    lowest_rejection_threshold: float = -6.0
    folds: int = 3
    fppi: float = PAPERS_FPPI
    augmentation: Augmentation = Augmentation()  # noqa: RUF009 - frozen
    displacement: Augmentation = Augmentation(shift=0.12, scale=0.18, stretch=0.12)  # noqa: RUF009 - frozen
    ridge: float = 1.0
    seed: int = 0


class Progress(Protocol):
    """Who is told how training goes."""

    def stage(self, name: str, steps: int) -> None:
        """Work of so many steps begins."""
        ...

    def advance(self) -> None:
        """A step is done."""
        ...

    def note(self, text: str, **figures: float) -> None:
        """Something worth keeping, for a reader and as figures by name: a line of the log."""
        ...
