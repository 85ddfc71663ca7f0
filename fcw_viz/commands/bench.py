"""`fcw bench`: the whole job beside decoding alone, the distance prior beside plain ACF, in one run."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True, slots=True)
class BenchCommand:
    """Measure the speed of every part side by side. Each round runs each case once, so that other load on the
    computer affects all cases alike."""

    source: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[SOURCE]")] = None
    """Video to measure on. Default: the shipped drive."""
    calibration: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Calibration file of the video. Default: `<name>.calibration.yaml` beside it."""
    rounds: Annotated[int, tyro.conf.arg(metavar="N")] = 3
    """Number of runs of each case. Medians and minima are reported."""
    detector_frames: Annotated[int, tyro.conf.arg(metavar="N")] = 60
    """Number of pictures for the detectors in each round, in one thread."""
    shortest: Annotated[float, tyro.conf.arg(metavar="SECONDS")] = 40.0
    """For whole drives: a video shorter than this many seconds is repeated until it is as long."""
    onnx: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """A YOLO net to measure beside the built-in detectors."""
    detector_classes: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME|NUMBER ...")] = ()
    """Classes of the ONNX model that count as vehicles. Default: cars, vans, trucks and buses."""
    report: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder for bench.txt, bench.json, and charts of time by stage, by windows and by pitch tolerance."""
    against: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """bench.json or the JSON output of an earlier run: print each ratio beside the earlier one."""
    json: bool = False
    """Print the figures as JSON, and nothing else on stdout."""


def run_bench(command: BenchCommand) -> int:
    """Run `fcw bench`; returns the exit code."""
    from fcw.detection.choice import ONNX_PREFIX, load_model
    from fcw.errors import UserError
    from fcw.files import is_same_file
    from fcw_viz.benchmark.against import EarlierFigures
    from fcw_viz.benchmark.measure import measure
    from fcw_viz.benchmark.report import JSON_NAME, print_figures, report_folder, write_report
    from fcw_viz.commands.demo import demo_folder
    from fcw_viz.console import MESSAGES, RESULTS, print_json

    if command.rounds < 1 or command.detector_frames < 1:
        raise UserError("--rounds and --detector-frames: expected at least 1")
    if not 0 <= command.shortest < math.inf:
        raise UserError(f"--shortest {command.shortest:g}: expected seconds, 0 or more")
    if command.detector_classes and not command.onnx:
        raise UserError(f"--detector-classes {' '.join(command.detector_classes)}: expected only with --onnx")
    if command.report and command.against and is_same_file(command.report / JSON_NAME, command.against):
        raise UserError(
            f"--report {command.report}: its new {JSON_NAME} would replace --against {command.against}; "
            "name another folder"
        )
    if command.report:
        report_folder(command.report)  # before all the measuring
    earlier = None if command.against is None else EarlierFigures.load(command.against)
    plugged_in = None
    if command.onnx:
        name = f"{ONNX_PREFIX}{command.onnx}"
        plugged_in = name, load_model(name, command.detector_classes)
    source = command.source or demo_folder() / "drive.mp4"
    figures = measure(
        source,
        command.calibration,
        command.rounds,
        command.detector_frames,
        MESSAGES,
        plugged_in,
        command.shortest,
    )
    if command.report:
        for path in write_report(figures, command.report, earlier):
            MESSAGES.print(str(path))
    if command.json:
        changes = {} if earlier is None else {"against": earlier.as_json(figures)}
        print_json(figures.as_json() | changes)
    else:
        print_figures(figures, RESULTS, earlier)
    return 0
