"""Detectors on cameras that are new to them: leave-one-camera-out over all labelled sources of the data.

    FCW_DATA=DIR python benchmarks/leave_one_camera_out.py [--detections DIR] [--onnx FILE ...] [--json FILE]

Train and validation splits together: cameras are left out in turn, a model learns from all others, and is
tested on theirs. Beside it stand plain ACF (its cascade alone over the whole picture) and, as --onnx and
--model, detectors that were trained elsewhere. The scores of all folds' models are pooled, and thresholds are
chosen once, over all pictures. With --detections what was found is kept by detector: a run that was stopped
goes on from there, and a finished one is printed again without training.
"""

import argparse
import json
import shutil
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from lines import say, say_row, where_and_with_what
from real_drives import data_folder

from fcw.detection.choice import DetectorModel, load_model
from fcw.detection.model import Model
from fcw.detection.net.model import NetModel
from fcw.detection.training.dataset import TrainingImage
from fcw.detection.training.folders import load_training_set
from fcw.detection.training.own_data import camera_of
from fcw.detection.training.training import TrainingSettings, train
from fcw.errors import UserError
from fcw.evaluation.detection.cameras import (
    GROUPS,
    Fit,
    Fold,
    Found,
    LabelledCameras,
    detect_in,
    detect_left_out,
    folds,
    read_cameras,
)
from fcw.evaluation.detection.detectors import EVERY_SCORE, CalibrationOf, DetectorCase, DetectorOf
from fcw.evaluation.detection.figures import evaluate
from fcw.evaluation.detection.intervals import CONFIDENCE, RESAMPLES
from fcw.evaluation.detection.labels import AnnotatedImage
from fcw.evaluation.detection.strata import (
    STRATA,
    Condition,
    LabelledVehicle,
    StratifiedRates,
    StratumRates,
    stratified_rates,
)
from fcw.files import write_whole
from fcw_viz.jobs.detection_report import write_detection_report

FPPI = (0.046, 0.1)
EACH = "each"
PLAIN = "plain"
PAGES = ("clear", "near", "vans, lorries, buses", "half-hidden", "fog, dusk")
PAGE_RESAMPLES = 100
PARTS = ".parts"


def main() -> None:
    arguments = parsed()
    data = data_folder()
    cv2.setNumThreads(1)
    try:
        run(arguments, data)
    except UserError as error:
        sys.exit(str(error))


def parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument(
        "--groups",
        nargs="+",
        metavar="CAMERA+CAMERA",
        default=["+".join(group) for group in GROUPS],
        help=f"cameras to leave out together; the others are learnt from; {EACH}: every camera by itself",
    )
    parser.add_argument("--detector", choices=("acf", "net"), default="acf", help="which is trained")
    parser.add_argument("--name", help="what it is called in the table; by default as it is")
    parser.add_argument("--seed", type=int, default=0, help="of the trainings")
    parser.add_argument(
        "--more",
        type=Path,
        nargs="+",
        default=[],
        metavar="DIR",
        help="training folders to learn from as well; cameras left out are left out here too",
    )
    parser.add_argument(
        "--detections", type=Path, help="folder where what was found is kept, a file a detector"
    )
    parser.add_argument(
        "--models", type=Path, help="folder where the folds' models are kept, to be used again"
    )
    parser.add_argument("--no-training", action="store_true", help="only kept and given detectors")
    parser.add_argument("--onnx", type=Path, nargs="+", default=[], help="YOLO nets to set beside")
    parser.add_argument("--model", type=Path, nargs="+", default=[], help="trained models to set beside")
    parser.add_argument("--resamples", type=int, default=RESAMPLES, help="for each interval")
    parser.add_argument("--json", type=Path, help="file to write all figures to")
    parser.add_argument(
        "--report", type=Path, help="folder for pages of the worst misses and false positives"
    )
    arguments = parser.parse_args()
    arguments.name = arguments.name or arguments.detector
    return arguments


def run(arguments: argparse.Namespace, data: Path) -> None:
    cameras = read_cameras(data)
    known = sorted(set(cameras.cameras[cameras.complete].tolist()))
    groups = known if arguments.groups == [EACH] else arguments.groups
    parts = folds(cameras, [tuple(group.split("+")) for group in groups])
    found = kept(arguments.detections)
    if not arguments.no_training:
        found = with_left_out(arguments, cameras, parts, found)
    found = with_trained_elsewhere(arguments, cameras, parts, found)
    tested = np.sort(np.concatenate([part.tested for part in parts]))
    images = [cameras.images[index] for index in tested]
    results: dict[str, StratifiedRates] = {}
    for name, each in found.items():
        if not each.has(cameras, tested):
            say(f"{name}: not in all pictures yet, left out of the table")
            continue
        say_progress(f"{name}: figures")
        results[name] = stratified_rates(images, each.on(cameras, tested), FPPI, arguments.resamples)
    print_tables(results, found)
    if arguments.json:
        figures = {
            name: {"groups_left_out": list(found[name].groups), **result.as_json()}
            for name, result in results.items()
        }
        write_whole(arguments.json, json.dumps(figures, indent=2) + "\n")
    if arguments.report:
        for name, result in results.items():
            detections = found[name].on(cameras, tested)
            write_pages(name, cameras, images, detections, result.thresholds[-1], arguments.report / name)


def kept(folder: Path | None) -> dict[str, Found]:
    """What earlier runs found, by detector."""
    if folder is None:
        return {}
    folder.mkdir(parents=True, exist_ok=True)
    return {path.stem: Found.load(path) for path in sorted(folder.glob("*.npz"))}


def keep(folder: Path | None, name: str, found: Found) -> None:
    if folder is not None:
        found.save(folder / f"{name}.npz")


def with_left_out(
    arguments: argparse.Namespace, cameras: LabelledCameras, parts: Sequence[Fold], found: Mapping[str, Found]
) -> dict[str, Found]:
    """Train for each fold that is not done yet, and detect in its pictures."""
    makers: dict[str, Callable[[Any, CalibrationOf], DetectorOf]] = {arguments.name: every_score}
    if arguments.detector == "acf":
        makers[f"{arguments.name} {PLAIN}"] = plain_acf
    names = tuple(makers)
    groups = tuple(part.name for part in parts)
    together = {**{name: Found({}, groups) for name in names}, **found}
    more_images = load_training_set(*arguments.more) if arguments.more else ()
    for name in names:
        if together[name].groups != groups:
            raise UserError(
                f"{arguments.detections}: {name} was found leaving out {', '.join(together[name].groups)}; "
                "give the same --groups, or another --name or folder"
            )
    for number, part in enumerate(parts, start=1):
        if all(together[name].has(cameras, part.tested) for name in names):
            continue
        group = set(cameras.cameras[part.tested][cameras.complete[part.tested]].tolist())
        others = tuple(each for each in more_images if camera_of(each.labelled.clip) not in group)
        learnt = len(part.learnt) + len(others)
        say_progress(f"{number} of {len(parts)}, without {part.name}: {learnt} pictures to learn from")
        fit = trainer(arguments, part.name, others)
        for name, more in detect_left_out(cameras, part, fit, makers).items():
            together[name] = together[name].with_more(more)
            keep(arguments.detections, name, together[name])
    return together


def with_trained_elsewhere(
    arguments: argparse.Namespace, cameras: LabelledCameras, parts: Sequence[Fold], found: Mapping[str, Found]
) -> dict[str, Found]:
    """Detect with the nets and models given, where that is not done yet."""
    together = dict(found)
    given = [(path, f"onnx:{path}", None) for path in arguments.onnx]
    given += [(path, "net" if path.stem.startswith("net") else "acf", path) for path in arguments.model]
    tested = np.sort(np.concatenate([part.tested for part in parts]))
    for path, detector, file in given:
        if path.stem in together and together[path.stem].has(cameras, tested):
            continue
        say_progress(f"{path.stem}: detecting in {len(tested)} pictures")
        case = DetectorCase(detector, load_model(detector, path=file), EVERY_SCORE)
        more = detect_in(cameras, tested, {path.stem: case.detector_of(cameras.calibration_of)})
        together |= more
        keep(arguments.detections, path.stem, more[path.stem])
    return together


def trainer(arguments: argparse.Namespace, fold: str, others: Sequence[TrainingImage]) -> Fit[Any]:
    """The project's trainer, learning from other pictures too.

    With --models a fold's finished model is taken again, a stopped one goes on.
    """

    def fit_the_net(images: Sequence[TrainingImage], /) -> NetModel:
        path = arguments.models and arguments.models / f"{arguments.name}-without-{fold}.npz"
        if path and path.is_file():
            return NetModel.load(path)
        from fcw.detection.net.training.fitting import NetTrainingSettings, fit_net  # needs PyTorch

        model = fit_net((*images, *others), NetTrainingSettings().seeded(arguments.seed), Notes(), 0.0)
        if path:
            path.parent.mkdir(parents=True, exist_ok=True)
            model.save(path)
        return model

    def fit(images: Sequence[TrainingImage], /) -> Model:
        settings = TrainingSettings(seed=arguments.seed)
        if arguments.models is None:
            return train((*images, *others), settings, Notes()).model
        arguments.models.mkdir(parents=True, exist_ok=True)
        path: Path = arguments.models / f"{arguments.name}-without-{fold}.npz"
        if not path.is_file():
            stages = path.with_suffix(PARTS)
            train((*images, *others), settings, Notes(), stages).model.save(path)
            shutil.rmtree(stages)
        return Model.load(path)

    return fit_the_net if arguments.detector == "net" else fit


class Notes:
    """Training's lines on stderr; its steps are not shown."""

    def stage(self, name: str, steps: int) -> None:
        pass

    def advance(self) -> None:
        pass

    def note(self, text: str, **figures: float) -> None:
        say_progress(f"  {text}")


def every_score(model: DetectorModel, calibration_of: CalibrationOf) -> DetectorOf:
    name = "net" if isinstance(model, NetModel) else "acf"
    return DetectorCase(name, model, EVERY_SCORE).detector_of(calibration_of)


def plain_acf(model: Model, calibration_of: CalibrationOf) -> DetectorOf:
    return DetectorCase("acf-full", model.plain(), EVERY_SCORE).detector_of(calibration_of)


def print_tables(results: Mapping[str, StratifiedRates], found: Mapping[str, Found]) -> None:
    say(where_and_with_what())
    for name in results:
        groups = found[name].groups
        say(f"- {name}: " + (f"left out in turn {', '.join(groups)}" if groups else "trained elsewhere"))
    say(
        "\nThresholds are chosen once over all pictures; scores of differently trained models are pooled. "
        f"Intervals: {CONFIDENCE:.0%}, clips and vehicles resampled. The camera level2 stands for single "
        "pictures, not completely labelled, whose like are learnt from; they count in no other row."
    )
    for at, fppi in enumerate(FPPI):
        say(f"\n## Detection rate at {fppi:g} false positives a picture\n")
        say_row(["kind", "boxes", "vehicles", *results], head=True)
        print_rows({name: result.strata for name, result in results.items()}, list(STRATA), at)
        say("\n## Clear vehicles by camera, at that threshold: rate; its own false positives a picture\n")
        say_row(["camera", "pictures", "boxes", *results], head=True)
        for camera in next(iter(results.values())).cameras if results else ():
            rows = [result.cameras[camera] for result in results.values()]
            cells = [f"{interval_text(row.clear, at)}; {number_text(row.fppi[at])}" for row in rows]
            say_row([camera, rows[0].pictures, rows[0].clear.boxes, *cells])


def print_rows(results: Mapping[str, Mapping[str, StratumRates]], names: Sequence[str], at: int) -> None:
    for name in names if results else ():
        rows = [strata[name] for strata in results.values()]
        say_row([name, rows[0].boxes, rows[0].vehicles, *(interval_text(row, at) for row in rows)])


def interval_text(row: StratumRates, at: int) -> str:
    low, high = row.intervals[at]
    return f"{number_text(row.rates[at])} ({number_text(low)} to {number_text(high)})"


def number_text(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.3f}"


def write_pages(
    name: str,
    cameras: LabelledCameras,
    images: Sequence[AnnotatedImage],
    found: Sequence,
    threshold: float,
    folder: Path,
) -> None:
    """A page for each of some kinds: what of it is missed at the pooled threshold, and what is false."""
    for kind in PAGES:
        chosen = [counting_only(image, STRATA[kind]) for image in images]
        evaluation = evaluate(chosen, cameras.calibration_of, found, threshold)
        heading = {"labels": "all cameras/left out", "detector": name, "only": [kind]}
        figures = heading | evaluation.as_json(FPPI, PAGE_RESAMPLES)
        page = write_detection_report(evaluation, figures, folder / kind.replace(", ", "-").replace(" ", "-"))
        say(f"- {page}")


def counting_only(image: AnnotatedImage, condition: Condition) -> AnnotatedImage:
    """A picture in which only vehicles of one kind count."""
    labelled = image.labelled
    others = [not condition(LabelledVehicle.of(image, label)) for label in range(len(labelled.boxes))]
    ignored = labelled.ignored | np.array(others, bool) | (not labelled.complete)
    return replace(image, labelled=replace(labelled, ignored=ignored))


def say_progress(text: str) -> None:
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


if __name__ == "__main__":
    main()
