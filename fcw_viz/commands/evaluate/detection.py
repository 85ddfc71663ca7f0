"""`fcw evaluate detection`: what the detector finds, measured against labels."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

if TYPE_CHECKING:
    from rich.console import Console


STRATA = {
    "by_distance": "distance, m",
    "by_height": "height, px",
    "by_height_part": "part of the picture's height",
    "by_view": "view",
    "by_kind": "kind",
    "by_clip": "clip",
}
"""What the tables are by, and their heads."""


@dataclass(frozen=True, slots=True)
class EvaluateDetectionCommand:
    """Compare detections with labels: detection rate, false positives per image (FPPI), average precision."""

    labels: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="LABELS")]
    """COCO JSON. Annotations with "ignore": true or "iscrowd", and those of two-wheelers, count neither as
    hits nor as misses. People, animals and signs are not vehicles."""
    images: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Folder to which the file names in the labels are relative."""
    calibration: Annotated[Path, tyro.conf.arg(metavar="FILE|DIR")]
    """Calibration file for all pictures, or a folder with <clip>.yaml for each clip."""
    detector: Annotated[str, tyro.conf.arg(metavar="net|acf|acf-full|onnx:FILE")] = "net"
    """net, acf, acf-full or a YOLO net, as for `fcw run`."""
    detector_classes: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME|NUMBER ...")] = ()
    """Classes of the ONNX model that count as vehicles. Default: cars, vans, trucks and buses."""
    model: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Model file written by `fcw train`. Default: the shipped one."""
    at_fppi: Annotated[tuple[float, ...], tyro.conf.arg(metavar="X ...")] = ()
    """Also print the detection rate at these numbers of false positives per image."""
    only: Annotated[tuple[str, ...], tyro.conf.arg(metavar="ATTRIBUTE=VALUE ...")] = ()
    """Count only vehicles whose annotation has this value, e.g. occluded=0; the others are ignored."""
    detections: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Write all detections, with any score, as COCO results."""
    report: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Write report.html to this folder: the curve, and pictures of the worst misses and false positives."""
    json: bool = False
    """Print the figures as JSON, and nothing else on stdout."""


def run_evaluate_detection(command: EvaluateDetectionCommand) -> int:
    """Run `fcw evaluate detection`; returns the exit code."""
    from fcw.detection.choice import load_model
    from fcw.errors import UserError
    from fcw.evaluation.detection.coco import write_coco_results
    from fcw.evaluation.detection.detectors import EVERY_SCORE, DetectorCase, run_detectors
    from fcw.evaluation.detection.figures import evaluate
    from fcw.evaluation.detection.labels import calibration_source, count_only, read_annotated, read_category
    from fcw.files import check_kind
    from fcw_viz.console import MESSAGES, RESULTS, print_json, progress
    from fcw_viz.jobs.detection_report import PAGE_START, REPORT_NAME, write_detection_report

    if not all(x >= 0 for x in command.at_fppi):
        raise UserError(f"--at-fppi {' '.join(map(str, command.at_fppi))}: expected numbers of at least 0")
    if command.detections and not command.detections.parent.is_dir():
        raise UserError(
            f"--detections {command.detections}: the folder {command.detections.parent} does not exist; "
            "create it first"
        )
    if command.report and command.report.exists() and not command.report.is_dir():
        raise UserError(
            f"--report {command.report}: this is a file; expected a folder to write report.html to"
        )
    if command.report:
        check_kind(command.report / REPORT_NAME, "report of this command", (PAGE_START.encode(),))
    images = count_only(read_annotated(command.labels, command.images), command.only)
    calibration_of = calibration_source(command.calibration)
    for image in images:
        calibration_of(image.labelled)  # one that is missing is better told now than halfway
    model = load_model(command.detector, command.detector_classes, command.model)
    cases = {
        "shipped": DetectorCase(command.detector, model),
        "every score": DetectorCase(command.detector, model, EVERY_SCORE),
    }
    detectors = {name: case.detector_of(calibration_of) for name, case in cases.items()}
    with progress("detecting", len(images)) as bar:
        runs = run_detectors(images, detectors, bar.advance)
    found = runs["every score"]
    evaluation = evaluate(images, calibration_of, found, model.score_threshold, runs["shipped"])
    figures = {
        "labels": str(command.labels),
        "detector": command.detector,
        "only": list(command.only),
        **evaluation.as_json(command.at_fppi),
    }
    if command.detections:
        write_coco_results(images, found, read_category(command.labels), command.detections)
    if command.report:
        page = write_detection_report(evaluation, figures, command.report)
        MESSAGES.print(f"{page}: open it in a browser")
    if command.json:
        print_json(figures)
    else:
        report_figures(figures, RESULTS)
    return 0


def report_figures(figures: dict[str, Any], console: "Console") -> None:
    """Print the figures for a person."""
    from rich.table import Table

    def rate(value: float | None, interval: list[float | None]) -> str:
        ends = " to ".join("-" if end is None else f"{end:.3f}" for end in interval)
        return "-" if value is None else f"{value:.3f} ({ends})"

    windows = figures["windows_per_frame"]
    console.print(
        f"{figures['labels']}, {figures['detector']}: {figures['frames']} pictures, "
        f"{figures['vehicles']} boxes of {figures['distinct_vehicles']} vehicles"
        + (f", only {', '.join(figures['only'])}" if figures["only"] else ""),
        highlight=False,
    )
    table = Table("", f"value ({figures['confidence']:.0%} interval)", box=None)
    table.add_row("detection rate", rate(figures["detection_rate"], figures["detection_rate_interval"]))
    table.add_row("false positives a picture", rate(figures["fppi"], figures["fppi_interval"]))
    table.add_row(
        "average precision", rate(figures["average_precision"], figures["average_precision_interval"])
    )
    for point in figures.get("at_fppi", ()):
        table.add_row(
            f"detection rate at {point['fppi']:g} FPPI",
            rate(point["detection_rate"], point["detection_rate_interval"]),
        )
    table.add_row(
        "detector's time a picture",
        f"{figures['ms_per_frame']:.2f} ms" + (f", {windows:,.0f} windows" if windows is not None else ""),
    )
    console.print(table, highlight=False)
    for name, head in STRATA.items():
        if not figures[name]:
            continue
        table = Table(head, "boxes", "vehicles", "detection rate", "false positives a picture", box=None)
        for kind, row in figures[name].items():
            if row["vehicles"] or row["fppi"]:
                table.add_row(
                    kind,
                    str(row["vehicles"]),
                    str(row["distinct_vehicles"]),
                    rate(row["detection_rate"], row["detection_rate_interval"]),
                    "-" if row["fppi"] is None else f"{row['fppi']:.3f}",
                )
        console.print()
        console.print(table, highlight=False)
