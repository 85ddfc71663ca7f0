"""`fcw train`: train the vehicle detector."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class TrainCommand:
    """Train the vehicle detector on labelled pictures."""

    data: Path
    """Folder with labels.json (COCO, an annotation may carry "ignore": true), images/, and calibration.yaml
    for all pictures or calibration/<clip>.yaml for each clip; or the project's own data."""

    out: Path
    """Model file to write (.npz)."""

    seed: int = 0
    """Of everything random: the same data and seed give the same model."""

    include_non_commercial: bool = False
    """Of the project's own data, learn also from pictures whose terms forbid commercial use (KITTI)."""


def run_train(command: TrainCommand) -> int:
    """Train, write the model, and log each round on stderr."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from fcw.detection.dataset import load_training_set
    from fcw.detection.training import TrainingSettings, train
    from fcw.errors import UserError

    if not command.data.is_dir():
        raise UserError(f"--data {command.data}: no such folder; expected one with labels.json and images/")
    if not command.out.parent.is_dir():
        raise UserError(
            f"--out {command.out}: the folder {command.out.parent} does not exist; create it first"
        )
    images = load_training_set(command.data, command.include_non_commercial)

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal) as bars:

        class _Bars:
            """One bar, set anew for each stage; the log's lines go above it."""

            task = bars.add_task("reading", total=None)

            def stage(self, name: str, steps: int) -> None:
                bars.reset(self.task, description=name, total=steps)

            def advance(self) -> None:
                bars.advance(self.task)

            def note(self, text: str) -> None:
                console.print(text, highlight=False, soft_wrap=True)

        result = train(images, TrainingSettings(seed=command.seed), _Bars())
    result.model.save(command.out)
    console.print(f"{command.out}: {len(result.model.trees)} trees", highlight=False, soft_wrap=True)
    return 0
