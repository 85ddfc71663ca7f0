"""`fcw evaluate`: what the program is worth, measured against truth."""

from dataclasses import dataclass
from typing import Annotated

import tyro

from fcw_viz.commands.evaluate.detection import EvaluateDetectionCommand, run_evaluate_detection
from fcw_viz.commands.evaluate.distance import EvaluateDistanceCommand, run_evaluate_distance
from fcw_viz.commands.evaluate.motion import EvaluateMotionCommand, run_evaluate_motion
from fcw_viz.commands.evaluate.warning import EvaluateWarningCommand, run_evaluate_warning


@dataclass(frozen=True, slots=True)
class EvaluateCommand:
    """Measure how well the program works."""

    what: Annotated[
        Annotated[EvaluateDetectionCommand, tyro.conf.subcommand("detection")]
        | Annotated[EvaluateDistanceCommand, tyro.conf.subcommand("distance")]
        | Annotated[EvaluateMotionCommand, tyro.conf.subcommand("motion")]
        | Annotated[EvaluateWarningCommand, tyro.conf.subcommand("warning")],
        tyro.conf.arg(name=""),
    ]


def run_evaluate(command: EvaluateCommand) -> int:
    """Run `fcw evaluate ...`; returns the exit code."""
    if isinstance(command.what, EvaluateDetectionCommand):
        return run_evaluate_detection(command.what)
    if isinstance(command.what, EvaluateDistanceCommand):
        return run_evaluate_distance(command.what)
    if isinstance(command.what, EvaluateMotionCommand):
        return run_evaluate_motion(command.what)
    return run_evaluate_warning(command.what)
