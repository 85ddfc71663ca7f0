"""`fcw evaluate warning`: whether warnings come in time, and never for nothing."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from fcw.errors import UserError
from fcw_viz.commands.evaluate.threats import (
    evaluate_nuisance,
    evaluate_threats,
    evaluate_variants,
    evaluate_worse_boxes,
)

if TYPE_CHECKING:
    from rich.console import Console

    from fcw.evaluation.warning.false_alarms import FollowingResult
    from fcw.evaluation.warning.scenarios import ScenarioResult

MOUNT_TRIALS = 24
MOUNT_ASKED_S = 120.0
"""A turned mount should be said in two minutes."""


MOST_HOURS = 1000.0
"""Simulated: they take days."""
MOST_SEEDS = 1000
THREAT_SEEDS, KITTI_SEEDS = 7, 1
MOST_NOISE_PX = 100


@dataclass(frozen=True, slots=True)
class EvaluateWarningCommand:
    """Measure warnings: in standard scenarios, on real drives, in steady following, on labelled events."""

    ncap: bool = False
    """The scenarios of NHTSA and Euro NCAP, simulated as boxes: exact motion, noisy boxes, the tracker."""
    kitti_tracking: Annotated[Path | None, tyro.conf.arg(metavar="FOLDER")] = None
    """List every `warning` on the drives in this folder (label_02/, calib/, poses/ of KITTI tracking)."""
    no_own_motion: bool = False
    """With --kitti-tracking: do not use the own yaw rate, as with `fcw run --no-own-motion`."""
    no_own_speed: bool = False
    """With --ncap, --kitti-tracking or --following-hours: treat the own speed as unknown, as it often is when
    estimated from pictures."""
    mount_hours: Annotated[float | None, tyro.conf.arg(metavar="HOURS")] = None
    """Simulate 24 drives in which the camera turns by half a degree, and this many hours in which it does
    not."""
    following_hours: Annotated[float | None, tyro.conf.arg(metavar="HOURS")] = None
    """Follow at constant gaps for this many simulated hours."""
    events: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Labelled events as CSV or JSON: start_s, end_s from the drive's first frame, level. Or a reviewed
    drive, another run of the same source: the verdicts on its warnings are the labels. Needs --log."""
    log: Annotated[Path | None, tyro.conf.arg(metavar="DRIVE")] = None
    """The drive.mcap, or its folder, to compare with --events. Without --events it is compared with the
    verdicts on its own warnings in `fcw review`."""
    warning_policy: Annotated[str, tyro.conf.arg(metavar="NAME")] = "timely-braking"
    """The policy, as in `fcw run`. Not for --log: a log keeps the policy of its run."""
    warning_timing: Literal["early", "normal", "late"] = "normal"
    """How early to warn, as in `fcw run`."""
    threats: bool = False
    """Simulated dangers (partial overlaps, cut-ins, a car that pulls out or crosses ...) and harmless scenes
    that look alike: is each danger warned of within its window?"""
    pixels: bool = False
    """With --threats: use rendered pictures and --detector instead of noisy boxes."""
    variants: bool = False
    """With --threats: variants of vehicles partly in the way, with other lateral speeds and overlaps, each
    also with more noise, detected late, and lost in some of the frames."""
    worse: bool = False
    """With --threats: use the boxes of a worse detector (vehicles lost, detected late, boxed in part, cut
    off) and no own motion."""
    nuisance: bool = False
    """Warnings per hour in ordinary traffic, by policy and timing: on the drives of --kitti-tracking and in
    --following-hours of steady following."""
    detector: Annotated[str, tyro.conf.arg(metavar="net|acf|onnx:FILE")] = "net"
    """With --pixels: detector to use."""
    seeds: Annotated[int | None, tyro.conf.arg(metavar="N")] = None
    """With --threats: runs of each scenario (default 7). With --kitti-tracking: runs of each drive (default
    1). The seed of the first run is --seed."""
    box_noise: Annotated[float, tyro.conf.arg(metavar="PX")] = 2.0
    """Standard deviation of the noise on the sides of the boxes, in pixels; at the lower edge 1.5 times as
    much."""
    sight: Annotated[float, tyro.conf.arg(metavar="M")] = 120.0
    """In the scenarios: distance up to which vehicles are detected, in metres from the camera."""
    seed: Annotated[int, tyro.conf.arg(metavar="N")] = 0
    """Random seed of the noise of boxes and clicks."""
    json: bool = False
    """Print the result as JSON, and nothing else on stdout."""

    def seeds_of(self, default: int) -> range:
        """The seeds that were asked for; so many where no number was given."""
        return range(self.seed, self.seed + (default if self.seeds is None else self.seeds))


def run_evaluate_warning(command: EvaluateWarningCommand) -> int:
    """Run `fcw evaluate warning`; returns the exit code."""
    from rich.console import Console

    from fcw_viz.console import RESULTS, SILENT, print_json

    _check(command)
    console = SILENT if command.json else RESULTS
    result: dict[str, Any] = {"false_alarms": 0, "missed": 0}
    parts: tuple[tuple[bool, Callable[[EvaluateWarningCommand, Console], dict[str, Any]]], ...] = (
        (command.ncap, _scenarios),
        (command.threats, _threats),
        (command.nuisance, _nuisance),
        (command.kitti_tracking is not None and not command.nuisance, _real_drives),
        (command.following_hours is not None and not command.nuisance, _following),
        (command.mount_hours is not None, _mounts),
        (command.log is not None, _events),
    )
    for asked_for, part in parts:
        if asked_for:
            found = part(command, console)
            for name in ("false_alarms", "missed"):
                result[name] += found.pop(name, 0)
            result |= found
    if command.json:
        print_json(result)
    return 0


def _check(command: EvaluateWarningCommand) -> None:

    from fcw.warning.policies import make_policy

    make_policy(command.warning_policy, command.warning_timing)
    if command.events is not None and command.log is None:
        raise UserError("--events needs --log: give the drive.mcap that the labels belong to")
    parts = {command.kitti_tracking, command.following_hours, command.mount_hours, command.log}
    if command.pixels and not command.threats:
        raise UserError("--pixels needs --threats; add it, or leave out --pixels")
    driven = command.kitti_tracking is not None or command.following_hours is not None
    if command.no_own_speed and (command.nuisance or not (command.ncap or driven)):
        raise UserError(
            "--no-own-speed needs --ncap, --kitti-tracking FOLDER or --following-hours HOURS, and cannot be "
            "combined with --nuisance"
        )
    if command.no_own_motion and (command.nuisance or command.kitti_tracking is None):
        raise UserError(
            "--no-own-motion needs --kitti-tracking FOLDER, and cannot be combined with --nuisance"
        )
    if command.nuisance and not driven:
        raise UserError("--nuisance needs --kitti-tracking FOLDER or --following-hours HOURS, or both")
    for option, chosen in (("--variants", command.variants), ("--worse", command.worse)):
        if chosen and (command.pixels or not command.threats):
            raise UserError(f"{option} needs --threats, and cannot be combined with --pixels")
    if command.variants and command.worse:
        raise UserError("--variants and --worse cannot be combined; choose one of them")
    if command.seeds is not None and not 1 <= command.seeds <= MOST_SEEDS:
        raise UserError(
            f"--seeds {command.seeds}: expected a whole number of at least 1, at most {MOST_SEEDS}"
        )
    if not command.ncap and not command.threats and parts == {None}:
        raise UserError(
            "fcw evaluate warning: nothing to evaluate; give --ncap, --threats, --kitti-tracking FOLDER, "
            "--following-hours HOURS, --mount-hours HOURS, --events FILE --log DRIVE, or --log DRIVE for a "
            "drive that was reviewed"
        )
    if not 0 <= command.box_noise <= MOST_NOISE_PX:
        raise UserError(
            f"--box-noise {command.box_noise:g}: expected pixels, 0 or more, at most {MOST_NOISE_PX}"
        )
    if not command.sight > 0:
        raise UserError(f"--sight {command.sight:g}: expected metres, more than 0")
    for option, hours in (
        ("--following-hours", command.following_hours),
        ("--mount-hours", command.mount_hours),
    ):
        if hours is not None and not 0 < hours <= MOST_HOURS:
            raise UserError(f"{option} {hours:g}: expected hours, more than 0 and at most {MOST_HOURS:g}")
    if command.seed < 0:
        raise UserError(f"--seed {command.seed}: expected a whole number of at least 0")


def _threats(command: EvaluateWarningCommand, console: "Console") -> dict[str, Any]:
    from fcw.warning.policies import make_policy

    seeds = command.seeds_of(THREAT_SEEDS)
    make = partial(make_policy, command.warning_policy, command.warning_timing)
    if command.variants:
        return evaluate_variants(make, seeds, console)
    if command.worse:
        return evaluate_worse_boxes(make, seeds, console)
    return evaluate_threats(make, seeds, command.detector if command.pixels else None, console)


def _nuisance(command: EvaluateWarningCommand, console: "Console") -> dict[str, Any]:
    return evaluate_nuisance(
        command.kitti_tracking, command.following_hours, command.box_noise, command.seed, console
    )


def _scenarios(command: EvaluateWarningCommand, console: "Console") -> dict[str, Any]:
    from fcw.evaluation.warning.ncap import TRIALS, euro_ncap_scenarios, nhtsa_scenarios
    from fcw.evaluation.warning.scenarios import BoxLevel, run_scenarios
    from fcw.warning.policies import make_policy
    from fcw_viz.console import progress

    scenarios = (*nhtsa_scenarios(), *euro_ncap_scenarios())
    view = BoxLevel(
        box_noise_px=command.box_noise, sight_m=command.sight, own_speed_known=not command.no_own_speed
    )
    with progress("trials", len(scenarios) * TRIALS) as bar:
        results = run_scenarios(
            scenarios,
            lambda: make_policy(command.warning_policy, command.warning_timing),
            view,
            command.seed,
            bar.advance,
        )
    print_scenarios(results, console)
    return scenarios_as_json(results)


def scenarios_as_json(results: "Sequence[ScenarioResult]") -> dict[str, Any]:
    """The scenarios with the keys that scripts rely on; medians over the trials that were warned."""
    from fcw.evaluation.warning.ncap import NHTSA_PASSES

    scenarios = []
    for result in results:
        scenario = result.scenario
        entry: dict[str, Any] = {
            "name": scenario.name,
            "speed_mps": scenario.own_mps,
            "trials": len(result.trials),
            "trials_passed": result.trials_passed,
            "ttc_at_warning_s": result.median("ttc_s"),
            "distance_at_warning_m": result.median("gap_m"),
            "impact_mps": result.median("impact_mps"),
            "preventable": scenario.preventable,
            "passed": result.trials_passed == len(result.trials),
            "passed_5_of_7": result.trials_passed >= NHTSA_PASSES,
        }
        if scenario.required_ttc_s is not None:
            entry["required_ttc_s"] = scenario.required_ttc_s
        else:
            entry["required_distance_m"] = scenario.required_gap_m
        scenarios.append(entry)
    trials = [trial for result in results for trial in result.trials]
    return {
        "scenarios": scenarios,
        "false_alarms": sum(trial.needless for trial in trials),
        "missed": sum(trial.warned_s is None for trial in trials),
    }


def print_scenarios(results: "Sequence[ScenarioResult]", console: "Console") -> None:
    """Print the scenarios as a table."""
    from rich.table import Table

    from fcw.units import KMH_PER_MPS

    table = Table("scenario", "in time", "TTC", "gap", "asked for", "worst impact", "needless", box=None)
    for result in results:
        scenario, ttc_s, gap_m = result.scenario, result.median("ttc_s"), result.median("gap_m")
        if scenario.required_ttc_s is not None:
            asked = f"TTC {scenario.required_ttc_s:.1f} s"
        elif scenario.required_gap_m is None:
            asked = "cannot avoid it"
        else:
            asked = f"{scenario.required_gap_m:.1f} m"
        worst_mps = max(trial.impact_mps for trial in result.trials)
        table.add_row(
            scenario.name,
            f"{result.trials_passed} of {len(result.trials)}",
            "-" if ttc_s is None else f"{ttc_s:.1f} s",
            "-" if gap_m is None else f"{gap_m:.1f} m",
            asked,
            "none" if worst_mps == 0 else f"{worst_mps * KMH_PER_MPS:.0f} km/h",
            str(sum(trial.needless for trial in result.trials)),
        )
    console.print(table)


def _real_drives(command: EvaluateWarningCommand, console: "Console") -> dict[str, Any]:
    from fcw.warning.policies import make_policy
    from fcw_viz.commands.evaluate.real_drives import evaluate_real_drives

    assert command.kitti_tracking is not None
    return evaluate_real_drives(
        command.kitti_tracking,
        partial(make_policy, command.warning_policy, command.warning_timing),
        command.box_noise,
        command.seeds_of(KITTI_SEEDS),
        not command.no_own_motion,
        not command.no_own_speed,
        console,
    )


def _following(command: EvaluateWarningCommand, console: "Console") -> dict[str, Any]:
    from fcw.evaluation.warning.false_alarms import FOLLOWING_RATE_HZ, run_following
    from fcw.evaluation.warning.scenarios import BoxLevel
    from fcw.warning.policies import make_policy
    from fcw_viz.console import progress

    hours = command.following_hours or 0.0
    view = BoxLevel(
        box_noise_px=command.box_noise,
        sight_m=command.sight,
        frame_rate_hz=FOLLOWING_RATE_HZ,
        own_speed_known=not command.no_own_speed,
    )
    with progress("hours", float(hours)) as bar:
        results = run_following(
            lambda: make_policy(command.warning_policy, command.warning_timing),
            view,
            hours,
            command.seed,
            bar.advance,
        )
    print_following(results, console)
    return {
        "following": [
            asdict(result.following)
            | {"hours": result.hours, "warnings": result.warnings, "cautions": result.cautions}
            for result in results
        ],
        "warnings_per_hour": sum(result.warnings for result in results) / hours,
        "false_alarms": sum(result.warnings for result in results),
    }


def print_following(results: "Sequence[FollowingResult]", console: "Console") -> None:
    """Print what was shown while following."""
    from rich.table import Table

    table = Table("following at", "gap", "hours", "warnings", "cautions", box=None)
    for result in results:
        table.add_row(
            f"{result.following.own_mps:g} m/s",
            f"{result.following.gap_m:g} m",
            f"{result.hours:g}",
            str(result.warnings),
            str(result.cautions),
        )
    console.print(table)


def _mounts(command: EvaluateWarningCommand, console: "Console") -> dict[str, Any]:
    from fcw.evaluation.distance.mount import AFTER_S, BEFORE_S, watch_mounts
    from fcw_viz.console import progress

    hours = command.mount_hours or 0.0
    with progress("hours", hours + MOUNT_TRIALS * (BEFORE_S + AFTER_S) / 3600) as bar:
        result = watch_mounts(MOUNT_TRIALS, hours, command.box_noise, command.seed, bar.advance)
    delays_s = sorted(delay_s for delay_s in result.delays_s if delay_s is not None)
    in_time = sum(delay_s <= MOUNT_ASKED_S for delay_s in delays_s)
    console.print(
        f"mount turned by 0.5 degrees in {len(result.delays_s)} drives: reported within "
        f"{MOUNT_ASKED_S:.0f} s in {in_time}, within {AFTER_S:.0f} s in {len(delays_s)}, too early in "
        f"{result.said_too_early}\n"
        f"delays: {', '.join(f'{delay_s:.0f}' for delay_s in delays_s)} s\n"
        f"not turned: reported in {result.false_alarms} drives of {result.silent_hours:g} hours",
        highlight=False,
    )
    return {"mount": asdict(result), "false_alarms": result.false_alarms + result.said_too_early}


def _events(command: EvaluateWarningCommand, console: "Console") -> dict[str, Any]:
    from fcw_viz.commands.evaluate.events import evaluate_events

    assert command.log is not None
    return evaluate_events(command.log, command.events, console)
