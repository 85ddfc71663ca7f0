"""The command line: `fcw COMMAND`. The one place that knows every part.

Exit codes: 0 done; 2 the user's input is wrong (one message on stderr); 1 a fault of ours (a traceback);
130 interrupted, with every log closed and readable.
"""

import os
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import redirect_stdout, suppress
from dataclasses import fields, is_dataclass
from functools import partial
from itertools import takewhile
from typing import Annotated, Any, get_args, get_origin

import tyro

from fcw.errors import UserError
from fcw.versions import __version__
from fcw_viz.commands.batch import BatchCommand, run_batch
from fcw_viz.commands.bench import BenchCommand, run_bench
from fcw_viz.commands.calibrate.command import run_calibrate
from fcw_viz.commands.calibrate.options import CalibrateCommand
from fcw_viz.commands.demo import DemoCommand, run_demo
from fcw_viz.commands.evaluate.command import EvaluateCommand, run_evaluate
from fcw_viz.commands.export import ExportCommand, run_export
from fcw_viz.commands.recover import RecoverCommand, run_recover
from fcw_viz.commands.review.command import run_review
from fcw_viz.commands.review.options import ReviewCommand
from fcw_viz.commands.run.command import run_run
from fcw_viz.commands.run.options import RunCommand
from fcw_viz.commands.simulate import SimulateCommand, run_simulate
from fcw_viz.commands.train import TrainCommand, run_train
from fcw_viz.console_text import printable
from fcw_viz.exit_codes import EXIT_INTERRUPTED, EXIT_WRONG_INPUT
from fcw_viz.option_help import registry
from fcw_viz.outputs import check_outputs
from fcw_viz.signals import signals_as_interrupts

DESCRIPTION = """Forward collision warning from one dash camera: calibrate, detect, range, warn, log.

fcw COMMAND --help lists the options of a command, fcw --version prints the version."""


Command = (
    Annotated[DemoCommand, tyro.conf.subcommand("demo")]
    | Annotated[CalibrateCommand, tyro.conf.subcommand("calibrate")]
    | Annotated[RunCommand, tyro.conf.subcommand("run")]
    | Annotated[BatchCommand, tyro.conf.subcommand("batch")]
    | Annotated[ReviewCommand, tyro.conf.subcommand("review")]
    | Annotated[ExportCommand, tyro.conf.subcommand("export")]
    | Annotated[RecoverCommand, tyro.conf.subcommand("recover")]
    | Annotated[EvaluateCommand, tyro.conf.subcommand("evaluate")]
    | Annotated[TrainCommand, tyro.conf.subcommand("train")]
    | Annotated[SimulateCommand, tyro.conf.subcommand("simulate")]
    | Annotated[BenchCommand, tyro.conf.subcommand("bench")]
)


RUNNERS = {
    DemoCommand: run_demo,
    CalibrateCommand: run_calibrate,
    RunCommand: run_run,
    BatchCommand: run_batch,
    ReviewCommand: run_review,
    ExportCommand: run_export,
    RecoverCommand: run_recover,
    EvaluateCommand: run_evaluate,
    TrainCommand: run_train,
    SimulateCommand: run_simulate,
    BenchCommand: run_bench,
}


CHOICES = [], ["evaluate"]
"""What is typed where a command is still to be chosen."""
NO_THREAD = "can't start new thread"
"""Python's only word for it."""


def main(arguments: list[str] | None = None) -> int:
    """Parse the command line, run the command and return its exit code."""
    typed = sys.argv[1:] if arguments is None else arguments
    if typed == ["--version"]:
        sys.stdout.write(f"fcw {__version__}\n")
        return 0
    if typed in CHOICES:  # no mistake of a person who wants to know what there is, but one in a script
        with redirect_stdout(sys.stderr), suppress(SystemExit):
            _parsed([*typed, "--help"])
        return EXIT_WRONG_INPUT
    try:
        _check_given_once(typed)
        command = _parsed(typed)
    except UserError as error:  # of a single option
        return _wrong_input(error)
    if not isinstance(command, TrainCommand):
        # NumPy is not loaded yet. From eleven vehicles on the tracker's matrices are so large that OpenBLAS
        # takes a second thread, and where all cores are busy it waits for it, for up to 35 ms.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # A picture that cannot be decoded is told of in our words; OpenCV has not been loaded yet either.
    os.environ.setdefault("OPENCV_LOG_LEVEL", "OFF")
    # So is a recording that cannot be written: without this rerun's own lines stand around the message.
    os.environ.setdefault("RUST_LOG", "warn,re_log_encoding=off,re_sdk=off")
    try:
        with signals_as_interrupts():
            check_outputs(command)
            return RUNNERS[type(command)](command)
    except UserError as error:
        return _wrong_input(error)
    except MemoryError:
        sys.stderr.write("fcw: not enough memory; close other programs, or raise the limit (ulimit -v)\n")
        return EXIT_WRONG_INPUT
    except RuntimeError as error:
        if str(error) != NO_THREAD:
            raise
        sys.stderr.write(
            "fcw: the system cannot start more threads; close other programs, or raise the limits of "
            "memory (ulimit -v) and of processes (ulimit -u)\n"
        )
        return EXIT_WRONG_INPUT
    except OSError as error:
        sys.stderr.write(f"fcw: {printable(_of_system(error))}\n")
        return EXIT_WRONG_INPUT
    except KeyboardInterrupt:
        sys.stderr.write("fcw: interrupted\n")
        return EXIT_INTERRUPTED


def _parsed(arguments: list[str]) -> Command:
    parse = partial(
        tyro.cli,
        Command,
        prog="fcw",
        description=DESCRIPTION,
        args=arguments,
        config=(tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff),
        registry=registry,
    )
    command, rest = parse(return_unknown_args=True)
    if not rest:
        return command
    _check_one_drive(command, rest)
    return parse()  # which says what it does not know


def _check_one_drive(command: Command, rest: list[str]) -> None:
    """See that not several files were named, as by `DR_*.MP4`, where one drive is expected.

    Raises:
        UserError: they were.
    """
    if isinstance(command, RunCommand | CalibrateCommand) and os.access(rest[0], os.F_OK):
        mend = (
            "`fcw batch` runs several, each for itself, and `fcw run FOLDER` the videos of a folder as one"
            if isinstance(command, RunCommand)
            else "calibrate with one of them"
        )
        raise UserError(f"{rest[0]}: a second drive after {command.source}; expected one drive: {mend}")


def _check_given_once(arguments: list[str]) -> None:
    """See that no option of several values is given twice: of `--data A --data B` only B would be read.

    Of an option of one value the last one counts, as elsewhere: scripts add theirs behind.

    Raises:
        UserError: one is.
    """
    given = [one.partition("=")[0].replace("_", "-") for one in takewhile(lambda one: one != "--", arguments)]
    twice = {one for one, times in Counter(given).items() if times > 1 and one.startswith("--")}
    for option in twice.intersection(_options_of_several(Command)):
        raise UserError(
            f"{option}: given {given.count(option)} times; give it once, with all its values after it"
        )


def _options_of_several(kind: Any) -> Iterator[str]:  # noqa: ANN401 - a class, or a union of them
    """Options of a command, or of commands, that take a tuple."""
    if not is_dataclass(kind):
        for part in get_args(kind):
            yield from _options_of_several(part)
        return
    for option in fields(kind):
        if _takes_several(option.type):
            yield "--" + option.name.replace("_", "-")
        yield from _options_of_several(option.type)


def _takes_several(kind: Any) -> bool:  # noqa: ANN401 - as an option states it
    return get_origin(kind) is tuple or any(map(_takes_several, get_args(kind)))


def _wrong_input(error: UserError) -> int:
    sys.stderr.write(f"fcw: {printable(str(error))}\n")
    return EXIT_WRONG_INPUT


def _of_system(error: OSError) -> str:
    """What the operating system refused, in its own words: a full disk, a name too long, no more files."""
    place = f"{error.filename!s}: " if error.filename else ""
    reason = error.strerror or str(error)
    return (
        f"{place}{reason}; correct that (room on the disk? permission to write? a shorter name?) and run "
        "again"
    )


if __name__ == "__main__":
    sys.exit(main())
