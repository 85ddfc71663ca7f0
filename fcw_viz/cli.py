"""The command line: `fcw COMMAND`. The one place that knows every part.

Exit codes: 0 done; 2 the user's input is wrong (one message on stderr); 1 a fault of ours (a traceback);
130 interrupted, with every log closed and readable.
"""

import sys
from dataclasses import dataclass
from typing import Annotated

import tyro

from fcw.errors import UserError
from fcw_viz.commands.bench import BenchCommand, run_bench
from fcw_viz.commands.calibrate import CalibrateCommand, run_calibrate
from fcw_viz.commands.demo import DemoCommand, run_demo
from fcw_viz.commands.evaluate_distance import EvaluateDistanceCommand, run_evaluate_distance
from fcw_viz.commands.evaluate_warning import EvaluateWarningCommand, run_evaluate_warning
from fcw_viz.commands.run import RunCommand, run_run
from fcw_viz.commands.simulate import SimulateCommand, run_simulate
from fcw_viz.commands.train import TrainCommand, run_train

EXIT_WRONG_INPUT = 2
EXIT_INTERRUPTED = 130


@dataclass(frozen=True, slots=True)
class EvaluateCommand:
    """Measure what the program is worth."""

    what: Annotated[
        Annotated[EvaluateDistanceCommand, tyro.conf.subcommand("distance")]
        | Annotated[EvaluateWarningCommand, tyro.conf.subcommand("warning")],
        tyro.conf.arg(name=""),
    ]


def run_evaluate(command: EvaluateCommand) -> int:
    """Run `fcw evaluate ...`; returns the exit code."""
    if isinstance(command.what, EvaluateDistanceCommand):
        return run_evaluate_distance(command.what)
    return run_evaluate_warning(command.what)


Command = (
    Annotated[DemoCommand, tyro.conf.subcommand("demo")]
    | Annotated[CalibrateCommand, tyro.conf.subcommand("calibrate")]
    | Annotated[RunCommand, tyro.conf.subcommand("run")]
    | Annotated[TrainCommand, tyro.conf.subcommand("train")]
    | Annotated[SimulateCommand, tyro.conf.subcommand("simulate")]
    | Annotated[EvaluateCommand, tyro.conf.subcommand("evaluate")]
    | Annotated[BenchCommand, tyro.conf.subcommand("bench")]
)


RUNNERS = {
    DemoCommand: run_demo,
    CalibrateCommand: run_calibrate,
    RunCommand: run_run,
    TrainCommand: run_train,
    SimulateCommand: run_simulate,
    EvaluateCommand: run_evaluate,
    BenchCommand: run_bench,
}


def main(arguments: list[str] | None = None) -> int:
    """Parse the command line, run the command and return its exit code."""
    command = tyro.cli(
        Command,  # pyright: ignore[reportArgumentType] - tyro takes unions, its annotation says type
        prog="fcw",
        description="Forward collision warning from one dash camera: calibrate, detect, range, warn, log.",
        args=arguments,
        config=(tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff),
    )
    try:
        return RUNNERS[type(command)](command)
    except UserError as error:
        sys.stderr.write(f"fcw: {error}\n")
        return EXIT_WRONG_INPUT
    except KeyboardInterrupt:
        sys.stderr.write("fcw: interrupted\n")
        return EXIT_INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
