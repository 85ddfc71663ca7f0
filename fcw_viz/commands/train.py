"""`fcw train`: train the vehicle detector."""

import json
import shutil
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, TYPE_CHECKING, Annotated, Literal

import tyro

from fcw.errors import UserError

if TYPE_CHECKING:
    from fcw_viz.console import Bar

LOG_START = "training on "


@dataclass(frozen=True)
class TrainCommand:
    """Train the vehicle detector on labelled pictures."""

    data: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="DIR ...")]
    """Folders with labels.json (COCO; an annotation may have "ignore": true), images/, and calibration.yaml
    for all pictures or calibration/<clip>.yaml for each clip. `fcw export --format coco --annotations`
    writes such folders. One of them may be the project's own data."""

    out: Path
    """Model file to write (.npz). Beside it are the log (OUT.log.jsonl) and, until the end, the finished
    stages of acf (OUT.parts). After an interruption, the same command continues from there."""

    detector: Literal["acf", "net"] = "acf"
    """Which detector; net needs PyTorch (pip install 'fcw[train]')."""

    score_threshold: Annotated[float | None, tyro.conf.arg(metavar="SCORE")] = None
    """net: score above which a window counts as a vehicle. Default: chosen on clips that a first training
    leaves out."""

    start_from: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """net: a model to continue training from, such as the shipped one, with a quarter of the steps; the new
    model is three parts newly learnt and one part old. Include the pictures that it was trained on, if you
    have them: it may forget what it is not shown again."""

    seed: Annotated[int, tyro.conf.arg(metavar="N")] = 0
    """Random seed: the same data and seed give the same model."""

    permissive_only: bool = False
    """From the project's own data, leave out pictures that are not clearly free for commercial use."""

    overwrite: bool = False
    """Replace an existing model."""


class _Told:
    """Who is told how a training goes: a bar, the lines above it, and the log.

    The log's file is begun with the first stage of work: a training that is refused before leaves none, and
    an earlier one's stays.
    """

    def __init__(self, bar: "Bar", log_path: Path, goes_on: bool) -> None:
        self._bar, self._path, self._mode = bar, log_path, "a" if goes_on else "w"
        self._waiting: list[str] = []
        self._file: IO[str] | None = None
        self.advance = bar.advance

    def stage(self, name: str, steps: int) -> None:
        """Work of so many steps begins."""
        if self._file is None:
            self._file = _opened(self._path, self._mode)
            self._file.writelines(self._waiting)
        self._bar.begin(name, steps)

    def note(self, text: str, **figures: float) -> None:
        """Something worth keeping: a line."""
        from fcw_viz.console import MESSAGES

        MESSAGES.print(text)
        told = {"time": datetime.now(UTC).isoformat(timespec="seconds"), "text": text} | figures
        line = json.dumps(told) + "\n"
        if self._file is None:
            self._waiting.append(line)
        else:
            self._file.write(line)
            self._file.flush()

    def close(self) -> None:
        """End the log."""
        if self._file is not None:
            self._file.close()


def run_train(command: TrainCommand) -> int:
    """Train, write the model, and log each round on stderr and beside the model; returns the exit code.

    Raises:
        UserError: an option is wrong, or the pictures do not do for a training.
    """
    from fcw.detection.model import model_sha256
    from fcw.detection.net.model import NetModel
    from fcw.detection.training.folders import load_training_set
    from fcw.detection.training.own_pictures import found_of_own
    from fcw.detection.training.training import TrainingSettings, train
    from fcw.files import check_kind, check_place
    from fcw_viz.console import MESSAGES, progress

    _check(command)
    start = None if command.start_from is None else NetModel.load(command.start_from)
    parts = command.out.with_name(command.out.name + ".parts")
    log_path = command.out.with_name(command.out.name + ".log.jsonl")
    check_kind(command.out, "model of this program", (b"first_", b"glance_"))
    check_kind(log_path, "log of a training", (f'"text": "{LOG_START}'.encode(),))
    check_place(log_path)
    # Beside the parts it is of a training that was stopped at its very end, or was to be replaced.
    if command.out.exists() and not command.overwrite and not parts.is_dir():
        raise UserError(f"{command.out}: exists already; choose another name, or replace it with --overwrite")
    images = load_training_set(*command.data, permissive_only=command.permissive_only)
    # A training that goes on from kept stages goes on with its log too.
    with progress("reading", None) as bar, closing(_Told(bar, log_path, goes_on=parts.is_dir())) as told:
        names = ", ".join(map(str, command.data))
        told.note(f"{LOG_START}{len(images)} pictures of {names}, seed {command.seed}")
        if command.detector == "net":
            from fcw.detection.net.training.fitting import NetTrainingSettings, train_net

            settings = NetTrainingSettings().seeded(command.seed)
            if start is not None:
                settings = settings.going_on()
                told.note(f"goes on from {command.start_from}")
            model, held_out = train_net(images, settings, told, command.score_threshold, start), None
        else:
            result = train(images, TrainingSettings(seed=command.seed), told, parts)
            model, held_out = result.model, result.operating_point.detection_rate
        own = found_of_own(command.detector, model, images, told)
    model.save(command.out)
    if command.detector == "acf":  # a net's training keeps nothing there: whatever it is, it stays
        shutil.rmtree(parts, ignore_errors=True)
    MESSAGES.print(f"{command.out}: {model_sha256(command.out)}")
    if useless := _useless(*own, held_out):
        MESSAGES.print(f"warning: {command.out}: {useless}", style="yellow")
    return 0


def _check(command: TrainCommand) -> None:
    """See that the options fit together, and that the folders are there."""
    if command.seed < 0:
        raise UserError(f"--seed {command.seed}: expected a whole number of at least 0")
    if not command.data:
        raise UserError("--data: no folder given; expected one with labels.json and images/")
    for folder in command.data:
        if not folder.is_dir():
            raise UserError(f"--data {folder}: no such folder; expected one with labels.json and images/")
    if not command.out.name:
        raise UserError(f"--out {command.out}: expected the name of a file, such as model.npz")
    if not command.out.parent.is_dir():
        raise UserError(
            f"--out {command.out}: the folder {command.out.parent} does not exist; create it first"
        )
    if command.score_threshold is not None and command.detector != "net":
        raise UserError("--score-threshold: acf chooses its own; leave it out, or add --detector net")
    if command.start_from is not None and command.detector != "net":
        raise UserError("--start-from: acf learns from nothing; leave it out, or add --detector net")


def _useless(found: int, vehicles: int, held_out_rate: float | None) -> str:
    """Why a model is of no use; empty where it may be.

    Args:
        found: vehicles that it finds in pictures that it learnt from,
        vehicles: of so many.
        held_out_rate: part that was found in pictures held out; None where that was not measured.
    """
    mend = (
        "do not use it: check that boxes and calibrations fit the pictures, and label more pictures, of "
        "several drives"
    )
    if vehicles and not found:
        also = ", and none in those held out" if held_out_rate == 0 else ""
        return f"finds none of {vehicles} vehicles in the pictures that it learnt from{also}; {mend}"
    if held_out_rate == 0:
        return f"vehicles were found only in pictures that it learnt from, none in those held out; {mend}"
    return ""


def _opened(path: Path, mode: str) -> IO[str]:
    """The log, to write to."""
    try:
        return path.open(mode, encoding="utf-8")
    except OSError as error:
        raise UserError(
            f"{path}: cannot write the log there ({error.strerror}); "
            "give --out in a folder that can be written"
        ) from error
