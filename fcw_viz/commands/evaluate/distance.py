"""`fcw evaluate distance`: distances and closing speeds against measured ones."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from fcw.evaluation.distance.cues import Cue

if TYPE_CHECKING:
    from fcw.evaluation.distance.kitti import DistanceEvaluation
    from fcw.evaluation.distance.simulation import SimulatedCoverage
    from fcw.evaluation.distance.tusimple_velocity import SingleBoxEvaluation


@dataclass(frozen=True, slots=True)
class EvaluateDistanceCommand:
    """Measure the errors of distance and closing speed on KITTI tracking, beside two simple methods."""

    kitti_tracking: Annotated[Path, tyro.conf.arg(metavar="FOLDER")]
    """Folder with label_02/, calib/ and poses/ of KITTI tracking."""
    tusimple_velocity: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """gt.json of the TuSimple velocity challenge, as a second data set: single boxes with lidar range."""
    simulated_tracks: Annotated[int, tyro.conf.arg(metavar="N")] = 0
    """Also simulate N tracks, and print the share whose last interval contains the truth (ideal: 68 %)."""
    sequences: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME ...")] = ()
    """Names of the sequences, e.g. 0000 0004. Default: all in the folder."""
    box_noise: Annotated[float, tyro.conf.arg(metavar="PX")] = 2.0
    """Standard deviation of the noise added to the sides of the labelled boxes, in pixels; 1.5 times as much
    at the lower edge. With 0 the boxes are exact projections, which flatters every method based on widths."""
    without: tuple[Cue, ...] = ()
    """Cues that the tracker must not use, to see what each contributes."""
    pitch_error: Annotated[float, tyro.conf.arg(metavar="DEG")] = 0.0
    """Assume that during calibration the camera pointed farther down by this angle than in the drives, as on
    a ramp or with a different load."""
    leave_one_out: bool = False
    """Choose the tracker's constants on all sequences but one, measure on that one, and repeat for each."""
    seed: Annotated[int, tyro.conf.arg(metavar="N")] = 0
    """Random seed of the noise of boxes and clicks."""
    samples: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """CSV file to write, with every measured vehicle in every frame."""
    report: Annotated[Path | None, tyro.conf.arg(metavar="FOLDER")] = None
    """Folder for charts (SVG): errors and intervals over distance, TTC over time."""
    json: bool = False
    """Print the result as JSON, and nothing else on stdout."""


METHODS = {"tracker": "estimated_m", "row alone": "row_m", "width 1.70 m": "width_m"}


def run_evaluate_distance(command: EvaluateDistanceCommand) -> int:
    """Run `fcw evaluate distance`; returns the exit code.

    Raises:
        UserError: an option is out of its range, or the data cannot be read.
    """
    from fcw.evaluation.distance.kitti_tracking import sequence_names
    from fcw.evaluation.distance.report import write_report
    from fcw.evaluation.distance.tusimple_velocity import evaluate_single_boxes
    from fcw_viz.console import print_json

    _check_numbers(command)
    names = sequence_names(command.kitti_tracking, command.sequences)
    _check_report(command)
    result, chosen = _evaluate_kitti(command, names)
    single_boxes = (
        evaluate_single_boxes(command.tusimple_velocity, command.seed) if command.tusimple_velocity else None
    )
    simulated = _simulate(command)
    if command.samples is not None:
        write_samples(result, command.samples)
    if command.report is not None:
        write_report(result, command.report)
    if command.json:
        print_json(_all_figures(command, result, chosen, single_boxes, simulated))
    else:
        print_tables(result)
        _print_besides(chosen, single_boxes, simulated)
    return 0


def _check_numbers(command: EvaluateDistanceCommand) -> None:
    """Raise a UserError for a number that is out of its range."""
    from fcw.errors import UserError

    if not (math.isfinite(command.box_noise) and command.box_noise >= 0):
        raise UserError(f"--box-noise {command.box_noise:g}: expected pixels, 0 or more")
    if command.seed < 0:
        raise UserError(f"--seed {command.seed}: expected a whole number of at least 0")
    if not abs(command.pitch_error) <= 5:
        raise UserError(f"--pitch-error {command.pitch_error:g}: expected degrees between -5 and 5")
    if command.simulated_tracks < 0:
        raise UserError(f"--simulated-tracks {command.simulated_tracks}: expected 0 or more")


def _check_report(command: EvaluateDistanceCommand) -> None:
    """Raise a UserError, before the long run, where the report could not be written after it."""
    from fcw.errors import UserError
    from fcw.evaluation.distance.report import check_report_folder

    if command.report is None:
        return
    if not command.report.is_dir():
        raise UserError(f"--report {command.report}: no such folder; create it first")
    check_report_folder(command.report)


def _evaluate_kitti(
    command: EvaluateDistanceCommand, names: Sequence[str]
) -> "tuple[DistanceEvaluation, dict[str, str]]":
    """The errors on KITTI tracking, and which constants were chosen for each sequence that was left out."""
    from fcw.errors import UserError
    from fcw.evaluation.distance.kitti import evaluate_distance
    from fcw.evaluation.distance.leave_one_out import evaluate_left_out

    pitch_error_rad = math.radians(command.pitch_error)
    folder, noise_px, seed = command.kitti_tracking, command.box_noise, command.seed
    if not command.leave_one_out:
        return evaluate_distance(folder, names, noise_px, seed, command.without, pitch_error_rad), {}
    if len(names) < 2:
        raise UserError("--leave-one-out: expected at least two sequences; name more with --sequences")
    if command.without:
        raise UserError("--leave-one-out uses all cues; leave out --without")
    return evaluate_left_out(folder, names, noise_px, seed, pitch_error_rad)


def _simulate(command: EvaluateDistanceCommand) -> "SimulatedCoverage | None":
    """How often the intervals of simulated tracks contain the truth; None where no tracks were asked for."""
    from fcw.evaluation.distance.kitti import tracker_settings
    from fcw.evaluation.distance.simulation import simulate_coverage

    if not command.simulated_tracks:
        return None
    settings = tracker_settings(command.box_noise, at_tyres=True)
    return simulate_coverage(command.simulated_tracks, command.seed, settings, command.box_noise)


def _all_figures(
    command: EvaluateDistanceCommand,
    result: "DistanceEvaluation",
    chosen: dict[str, str],
    single_boxes: "SingleBoxEvaluation | None",
    simulated: "SimulatedCoverage | None",
) -> dict[str, Any]:
    """All that was measured, with the keys that scripts rely on."""
    figures = as_json(result) | {"pitch_error_deg": command.pitch_error}
    if chosen:
        figures["chosen"] = chosen
    if single_boxes is not None:
        figures["tusimple"] = {name: asdict(errors) for name, errors in single_boxes.errors.items()}
    if simulated is not None:
        figures["simulated"] = asdict(simulated)
    return figures


def _print_besides(
    chosen: dict[str, str], single_boxes: "SingleBoxEvaluation | None", simulated: "SimulatedCoverage | None"
) -> None:
    """Print, below the tables, the chosen constants and the results on the other data."""
    from fcw_viz.console import RESULTS

    for name, text in chosen.items():
        RESULTS.print(f"{name}: {text}")
    if single_boxes is not None:
        texts = (f"{name} {errors.median:.1%}" for name, errors in single_boxes.errors.items())
        count = single_boxes.errors["tracker"].n
        RESULTS.print(f"TuSimple, {count} single boxes, median error: {', '.join(texts)}")
    if simulated is not None:
        RESULTS.print(
            f"{simulated.tracks} simulated tracks: {simulated.part:.1%} end inside their 1-sigma interval, "
            f"median error {simulated.median_error:.1%}",
        )


def as_json(result: "DistanceEvaluation") -> dict[str, Any]:
    """The result with the keys that scripts rely on; what is not known is NaN."""
    coverage, low, high = result.coverage()
    figures = {name: asdict(errors) for name, errors in result.errors().items()}
    figures |= {
        "closing_speed_mae_mps": result.closing_speed_mae_mps(),
        "closing_speed_mae_by_sample_mps": result.closing_speed_mae_mps(by_track=False),
        "box_noise_px": result.box_noise_px,
        "seed": result.seed,
        "measured": result.measured,
        "followed": len(result.samples),
        "coverage": {"part": coverage, "low": low, "high": high},
    }
    for key, method in (("row", "row_m"), ("width", "width_m")):
        figures[key] = {name: asdict(errors) for name, errors in result.errors(method).items()}
    return figures


def _figure(value: float, form: str) -> str:
    """A figure as `form` has it; `-` where there was no sample."""
    return "-" if value != value else f"{value:{form}}"  # NaN alone is not itself


def _percent(*values: float) -> str:
    """A relative error, or both ends of its interval."""
    return "-".join(_figure(value, ".1%") for value in dict.fromkeys(values))


def print_tables(result: "DistanceEvaluation") -> None:
    """Print the methods side by side."""
    from rich.table import Table

    from fcw.evaluation.distance.kitti import RANGES_M
    from fcw_viz.console import RESULTS

    table = Table("relative error", *(f"{name} m" if name != "all" else name for name in RANGES_M), box=None)
    for name, method in METHODS.items():
        errors = result.errors(method).values()
        table.add_row(f"{name}: median", *(_percent(e.median) for e in errors))
        if method == "estimated_m":
            table.add_row("  95 % over tracks", *(_percent(e.median_low, e.median_high) for e in errors))
        table.add_row("  mean", *(_percent(e.mean) for e in errors))
        table.add_row("  9 of 10", *(_percent(e.p90) for e in errors))
    counted = result.errors().values()
    table.add_row("samples (tracks)", *(f"{e.n} ({e.tracks})" for e in counted))
    RESULTS.print(table)
    coverage, low, high = (_figure(part, ".0%") for part in result.coverage())
    by_track, by_sample = (
        _figure(result.closing_speed_mae_mps(by_track=one), ".2f") for one in (True, False)
    )
    RESULTS.print(
        f"{len(result.samples)} of {result.measured} measured vehicles were followed, box noise "
        f"{result.box_noise_px:g} px, seed {result.seed}.\n"
        f"closing speed, mean absolute error after 1 s: {by_track} m/s by track, {by_sample} m/s by sample\n"
        f"inside the 1-sigma interval: {coverage} ({low} to {high})",
    )


def write_samples(result: "DistanceEvaluation", path: Path) -> None:
    """Write every sample as a line of a CSV file."""
    from fcw.evaluation.distance.kitti import DistanceSample
    from fcw.files import write_whole

    names = [field.name for field in fields(DistanceSample)]
    lines = [",".join(names)]
    for sample in result.samples:
        values = (getattr(sample, name) for name in names)
        lines.append(",".join(f"{value:.4f}" if isinstance(value, float) else str(value) for value in values))
    write_whole(path, "\n".join(lines) + "\n")
