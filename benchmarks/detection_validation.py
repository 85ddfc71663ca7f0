"""The detector's whole validation in one run: accuracy, ablation, robustness, bottom rows, time.

    FCW_DATA=DIR python benchmarks/detection_validation.py [--models A.npz B.npz ...] [--report DIR]

The distance prior stands beside plain ACF over the whole picture: the same trees and channels, and with
"all stages" also the same second stage and box regressor. With several models (seeds of the training) each
figure is their mean. "clear": vehicles that nothing hides (`occluded` 0). Validation split.
"""

import argparse
import statistics
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path

import cv2
from lines import say, say_row, where_and_with_what
from real_drives import data_folder
from rich.console import Console
from rich.progress import Progress

from fcw.detection.acf import AcfSettings, FullAcfSettings
from fcw.detection.model import SHIPPED_MODEL_PATH, Model, model_sha256
from fcw.detection.windows.plan import full_levels
from fcw.evaluation.detection.bottom_rows import bottom_rows
from fcw.evaluation.detection.comparison import EqualRate, SeedMean, rate_at
from fcw.evaluation.detection.curve_chart import PlottedCurve
from fcw.evaluation.detection.detectors import (
    EVERY_SCORE,
    CalibrationOf,
    DetectorCase,
    FrameDetections,
    mean_windows,
    median_milliseconds,
    run_detectors,
)
from fcw.evaluation.detection.figures import evaluate
from fcw.evaluation.detection.labels import AnnotatedImage, calibration_source, count_only, read_annotated
from fcw.evaluation.detection.perturbation import CALIBRATION_ERRORS
from fcw_viz.jobs.detection_report import write_detection_report

FPPI = (0.046, 0.1, 1.0)
ENLARGED = AcfSettings().largest_scale
PRIOR, PRIOR_PLAIN = "distance prior, all stages", "distance prior, cascade alone"
WHOLE, PLAIN = "whole picture, all stages", "plain ACF (whole picture, cascade alone)"
WHOLE_ENLARGED = f"whole picture enlarged {ENLARGED:g} times, all stages"
DETECTORS: dict[str, tuple[str, bool, float | None]] = {
    PRIOR: ("acf", False, None),
    WHOLE: ("acf-full", False, None),
    WHOLE_ENLARGED: ("acf-full", False, ENLARGED),
    PRIOR_PLAIN: ("acf", True, None),
    PLAIN: ("acf-full", True, None),
}
"""Detector, whether the cascade alone, how far pictures are enlarged (None: acf as shipped, acf-full not)."""
COMPARISONS = ((PRIOR, PLAIN), (PRIOR, WHOLE), (PRIOR, WHOLE_ENLARGED), (PRIOR_PLAIN, PLAIN))
CURVE_COLORS = {WHOLE: "#c2571a", WHOLE_ENLARGED: "#8a6bbd", PLAIN: "#5a6675"}
PAPER_TABLE_4 = (
    ("DPM", 0.9123, 0.098, 4.0),
    ("And-Or", 0.8908, 0.133, 3.0),
    ("SubCat", 0.9270, 0.087, 0.7),
    ("ACF", 0.9402, 0.065, 0.04),
    ("Ours (distance prior)", 0.9661, 0.046, 0.02),
)
"""As printed: 5,400 pictures of one recorder that are not public, so not comparable with the rows above."""
CHECKED_SOURCES = {"tusimple": ("human",), "labels": ("checked-edited",)}
"""Boxes whose bottom edges people set."""


class Split:
    """A labelled set, and what all detectors found in it."""

    def __init__(self, data: Path, name: str, models: Sequence[Model], progress: Progress) -> None:
        self.name, self.models = name, models
        self.images = read_annotated(data / name / "validation.json", data / name / "images")
        self.calibration_of = calibration_source(data / "calibrations.txt")
        cases: dict[tuple[str, int], tuple[DetectorCase, CalibrationOf]] = {}
        for (number, model), (case, (detector, plain, scale)) in product(
            enumerate(models), DETECTORS.items()
        ):
            used = model.plain() if plain else model
            cases[case, number] = DetectorCase(detector, used, EVERY_SCORE, scale), self.calibration_of
        for (number, model), error in product(enumerate(models), CALIBRATION_ERRORS):
            case = DetectorCase("acf", model, EVERY_SCORE)
            cases[str(error), number] = case, error.on(self.calibration_of)
        task = progress.add_task(name, total=len(self.images))
        names = {key: f"{key[0]} / {key[1]}" for key in cases}
        runs = run_detectors(
            self.images,
            {names[key]: case.detector_of(calibrations) for key, (case, calibrations) in cases.items()},
            lambda: progress.advance(task),
        )
        self.found = {key: runs[names[key]] for key in cases}

    @property
    def subsets(self) -> dict[str, tuple[AnnotatedImage, ...]]:
        """All vehicles, and the clear ones where the labels say which are."""
        if not any("occluded" in fields for image in self.images for fields in image.attributes):
            return {"all": self.images}  # TuSimple: what is overlapped is ignored, so all are clear
        return {"all": self.images, "clear": count_only(self.images, ["occluded=0"])}

    def results(self, case: str, images: Sequence[AnnotatedImage]) -> SeedMean:
        """A detector with each of the models, the vehicles that count as in `images`."""
        wanted = {image.image_id for image in images}
        kept = [index for index, image in enumerate(self.images) if image.image_id in wanted]
        plain = case in DETECTORS and DETECTORS[case][1]
        return SeedMean(
            tuple(
                evaluate(
                    images,
                    self.calibration_of,
                    [self.found[case, number][index] for index in kept],
                    (model.plain() if plain else model).score_threshold,
                )
                for number, model in enumerate(self.models)
            )
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--models", type=Path, nargs="+", default=[SHIPPED_MODEL_PATH])
    parser.add_argument("--report", type=Path, help="folder for the pages of misses and false positives")
    arguments = parser.parse_args()
    data = data_folder()
    models = [Model.load(path) for path in arguments.models]
    cv2.setNumThreads(1)
    say(where_and_with_what())
    say("models: " + ", ".join(f"{path.name} {model_sha256(path)[:12]}" for path in arguments.models))
    console = Console(stderr=True)
    with Progress(console=console, disable=not console.is_terminal) as progress:
        splits = [Split(data, name, models, progress) for name in ("tusimple", "labels")]
        times = measure_times(splits[0], models[0], progress)
    print_rates(splits)
    print_equal_rates(splits)
    print_robustness(splits)
    print_bottom_rows(splits)
    print_clips(splits)
    print_times(splits[0], models[0], times)
    if arguments.report:
        write_pages(splits, arguments.report)


def print_rates(splits: Sequence[Split]) -> None:
    say("\n## Detection rate at false positives per image\n")
    say("95 % intervals: clips and vehicles resampled; then vehicles of these clips. [each model]\n")
    heads = ["set", "vehicles", "boxes", "detector", *(f"at {x:g}" for x in FPPI)]
    say_row([*heads, "AP", "as shipped: rate", "false"], head=True)
    for split, name, images in subsets(splits):
        for case in DETECTORS:
            result = split.results(case, images)
            first = result.evaluations[0]
            points = [evaluation.operating_point for evaluation in result.evaluations]
            say_row(
                [
                    f"{split.name}, {name}",
                    len(set(first.grouping.vehicle.tolist())),
                    len(first.grouping.vehicle),
                    case,
                    *(rate_text(result, x) for x in FPPI),
                    f"{result.mean(lambda curve: curve.average_precision):.3f}",
                    f"{statistics.mean(point.detection_rate for point in points):.3f}",
                    f"{statistics.mean(point.fppi for point in points):.3f}",
                ]
            )
    say("\nThe paper's Table 3, as printed; other pictures, which nobody else has:\n")
    say_row(["method", "detection rate", "FPPI", "s a frame"], head=True)
    for method, rate, fppi, seconds in PAPER_TABLE_4:
        say_row([f"{method} (paper)", f"{rate:.4f}", f"{fppi:.3f}", f"{seconds:g}"])
    say("\n## Distance prior less plain ACF, detection rate in points (95 % interval of the difference)\n")
    say_row(["set", "less", *(f"at {x:g}" for x in FPPI), "at 0.1, in these clips"], head=True)
    for split, name, images in subsets(splits):
        for case, base in COMPARISONS:
            result, other = split.results(case, images), split.results(base, images)
            cells = [
                difference_text(result, other, x, same_clips)
                for x, same_clips in (*((x, False) for x in FPPI), (0.1, True))
            ]
            say_row([f"{split.name}, {name}", f"{case} - {base}", *cells])


def print_equal_rates(splits: Sequence[Split]) -> None:
    say("\n## False positives per image at equal detection rate\n")
    say("Where the second finds its rate at the FPPI of the head: rate, FPPI of the first / of the second.\n")
    say_row(["set", "detectors", *(f"at {x:g}" for x in FPPI)], head=True)
    for split, name, images in subsets(splits):
        for case, base in COMPARISONS:
            result, other = split.results(case, images), split.results(base, images)
            cells = [equal_text(result.at_equal_rate(other, x)) for x in FPPI]
            say_row([f"{split.name}, {name}", f"{case} / {base}", *cells])


def print_robustness(splits: Sequence[Split]) -> None:
    say("\n## Calibration off: detection rate at 0.1 false positives per image, change in points\n")
    say_row(["set", "right", *map(str, CALIBRATION_ERRORS)], head=True)
    for split, name, images in subsets(splits):
        right = split.results(PRIOR, images).mean(rate_at(0.1))
        off = [split.results(str(error), images).mean(rate_at(0.1)) for error in CALIBRATION_ERRORS]
        say_row([f"{split.name}, {name}", f"{right:.3f}", *(f"{100 * (rate - right):+.1f}" for rate in off)])


def print_bottom_rows(splits: Sequence[Split]) -> None:
    say("\n## Bottom row of hits, 20 to 60 px high, as shipped: detected less labelled, px (first model)\n")
    say_row(["set", "boxes", "hits", "vehicles", "bias", "sigma", "median", "robust sigma"], head=True)
    for split in splits:
        clips = sorted({image.labelled.clip for image in split.images})
        parts: dict[str, Sequence[AnnotatedImage]] = {split.name: split.images}
        if len(clips) > 1:
            parts |= {clip: [i for i in split.images if i.labelled.clip == clip] for clip in clips}
        for name, images in parts.items():
            sources = CHECKED_SOURCES[split.name]
            rows = bottom_rows(split.results(PRIOR, images).evaluations[0], sources)
            if rows is not None:
                values = (rows.bias_px, rows.sigma_px, rows.median_px, rows.robust_sigma_px)
                cells = [", ".join(sources), rows.count, rows.vehicles, *(f"{value:.2f}" for value in values)]
                say_row([name, *cells])


def print_clips(splits: Sequence[Split]) -> None:
    say("\n## Cameras that training never saw, by themselves\n")
    heads = ["clip", "pictures", "vehicles", "boxes", *(f"at {x:g}" for x in FPPI)]
    say_row([*heads, "as shipped: rate", "false"], head=True)
    for split, name, images in subsets(splits[1:]):
        for clip in sorted({image.labelled.clip for image in images}):
            own = [image for image in images if image.labelled.clip == clip]
            result = split.results(PRIOR, own)
            first = result.evaluations[0]
            points = [evaluation.operating_point for evaluation in result.evaluations]
            say_row(
                [
                    f"{clip}, {name}",
                    len(own),
                    len(set(first.grouping.vehicle.tolist())),
                    len(first.grouping.vehicle),
                    *(f"{result.mean(rate_at(x)):.3f}{seeds_text(result.values(rate_at(x)))}" for x in FPPI),
                    f"{statistics.mean(point.detection_rate for point in points):.3f}",
                    f"{statistics.mean(point.fppi for point in points):.3f}",
                ]
            )


def write_pages(splits: Sequence[Split], folder: Path) -> None:
    say("\n## Pages of misses and false positives (first model)\n")
    for split, name, images in subsets(splits):
        first = split.results(PRIOR, images).evaluations[0]
        heading = {"labels": f"{split.name}/validation.json", "detector": PRIOR, "only": [name]}
        beside = [
            PlottedCurve(case, color, split.results(case, images).evaluations[0].curve)
            for case, color in CURVE_COLORS.items()
        ]
        figures = heading | first.as_json(FPPI)
        say(f"- {write_detection_report(first, figures, folder / f'{split.name}-{name}', beside)}")


def measure_times(split: Split, model: Model, progress: Progress) -> dict[str, tuple[FrameDetections, ...]]:
    """All stages and plain ACF as shipped, taking turns picture by picture."""
    cases = {
        PRIOR: DetectorCase("acf", model),
        "distance prior, all stages, not enlarging": DetectorCase("acf", model, largest_scale=1.0),
        PRIOR_PLAIN: DetectorCase("acf", model.plain()),
        "plain ACF, not enlarging": DetectorCase("acf-full", model.plain()),
        f"plain ACF, enlarging {ENLARGED:g} times": DetectorCase(
            "acf-full", model.plain(), largest_scale=ENLARGED
        ),
    }
    task = progress.add_task("time", total=len(split.images))
    detectors = {name: case.detector_of(split.calibration_of) for name, case in cases.items()}
    return run_detectors(split.images, detectors, lambda: progress.advance(task))


def print_times(split: Split, model: Model, times: dict[str, tuple[FrameDetections, ...]]) -> None:
    size = split.images[0].labelled.size
    scales = len(full_levels(size, model.window, FullAcfSettings().scales_per_octave, 1.0))
    say(f"\n## Time a picture of {split.name}, {size}: thread's own, median, taking turns\n")
    small, large = list(times)[-2:]
    say_row(["detector", "ms", "windows", f"to {small}", f"to {large}"], head=True)
    for name, frames in times.items():
        ratios = [
            statistics.median(
                mine.milliseconds / other.milliseconds
                for mine, other in zip(frames, times[base], strict=True)
            )
            for base in (small, large)
        ]
        windows = mean_windows(frames) or 0
        say_row(
            [name, f"{median_milliseconds(frames):.2f}", f"{windows:,.0f}", *(f"{r:.2f}" for r in ratios)]
        )
    say(f"\nPlain ACF has {scales} scales when it does not enlarge.")


def subsets(splits: Sequence[Split]) -> Iterator[tuple[Split, str, tuple[AnnotatedImage, ...]]]:
    for split in splits:
        for name, images in split.subsets.items():
            yield split, name, images


def difference_text(result: SeedMean, base: SeedMean, fppi: float, same_clips: bool) -> str:
    figure = rate_at(fppi)
    points = 100 * (result.mean(figure) - base.mean(figure))
    low, high = result.difference_interval(base, figure, same_clips=same_clips)
    return f"{points:+.1f} ({100 * low:+.1f} to {100 * high:+.1f})"


def rate_text(result: SeedMean, fppi: float) -> str:
    figure = rate_at(fppi)
    intervals = (result.interval(figure, same_clips=same_clips) for same_clips in (False, True))
    between = "; ".join(f"{low:.3f} to {high:.3f}" for low, high in intervals)
    return f"{result.mean(figure):.3f} ({between}){seeds_text(result.values(figure))}"


def equal_text(equal: EqualRate) -> str:
    if equal.fppi is None:
        return f"{equal.detection_rate:.3f}: not reached / {equal.base_fppi:.3f}"
    ratio = f" = {equal.fppi / equal.base_fppi:.2f}" if equal.base_fppi else ""
    return f"{equal.detection_rate:.3f}: {equal.fppi:.3f} / {equal.base_fppi:.3f}{ratio}"


def seeds_text(values: Sequence[float]) -> str:
    return f" [{', '.join(f'{value:.3f}' for value in values)}]" if len(values) > 1 else ""


if __name__ == "__main__":
    main()
