"""`fcw evaluate warning`: whether warnings come in time, and never for nothing."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import tyro

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fcw.evaluation.warning import ScenarioResult


@dataclass(frozen=True, slots=True)
class EvaluateWarningCommand:
    """Measure warnings in the scenarios of NHTSA and Euro NCAP."""

    ncap: bool = False
    """Run the scenarios, at the level of boxes: exact motion, noisy boxes, tracker and policy."""
    box_noise: Annotated[float, tyro.conf.arg(metavar="PX")] = 2.0
    """1-sigma of the noise on the sides of the boxes, in pixels; 1.5 times as much at the lower edge."""
    sight: Annotated[float, tyro.conf.arg(metavar="M")] = 120.0
    """The farthest vehicle that is detected, metres from the camera."""
    seed: int = 0
    """Of the noise of boxes and clicks."""
    json: bool = False
    """Print the result as JSON on stdout, alone."""


def run_evaluate_warning(command: EvaluateWarningCommand) -> int:
    """Run `fcw evaluate warning`; returns the exit code."""
    import json
    import math
    import sys

    from rich.console import Console
    from rich.progress import Progress

    from fcw.errors import UserError
    from fcw.evaluation.ncap import TRIALS, euro_ncap_scenarios, nhtsa_scenarios
    from fcw.evaluation.warning import BoxLevel, run_scenarios
    from fcw.warning.ttc_policy import TtcPolicy

    if not command.ncap:
        raise UserError("fcw evaluate warning: nothing to evaluate; give --ncap")
    if not (math.isfinite(command.box_noise) and command.box_noise >= 0):
        raise UserError(f"--box-noise {command.box_noise:g}: expected pixels, 0 or more")
    if not command.sight > 0:
        raise UserError(f"--sight {command.sight:g}: expected metres, more than 0")
    if command.seed < 0:
        raise UserError(f"--seed {command.seed}: expected a whole number of at least 0")
    scenarios = (*nhtsa_scenarios(), *euro_ncap_scenarios())
    view = BoxLevel(box_noise_px=command.box_noise, sight_m=command.sight)
    messages = Console(stderr=True)
    with Progress(console=messages, disable=not messages.is_terminal, transient=True) as progress:
        task = progress.add_task("trials", total=len(scenarios) * TRIALS)
        results = run_scenarios(
            scenarios, TtcPolicy, view, command.seed, lambda: progress.update(task, advance=1)
        )
    if command.json:
        sys.stdout.write(json.dumps(scenarios_as_json(results), indent=2) + "\n")
    else:
        print_scenarios(results)
    return 0


def scenarios_as_json(results: "Sequence[ScenarioResult]") -> dict[str, Any]:
    """The scenarios with the keys that scripts rely on; medians over the trials that were warned."""
    from fcw.evaluation.ncap import NHTSA_PASSES

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


def print_scenarios(results: "Sequence[ScenarioResult]") -> None:
    """Print the scenarios as a table."""
    from rich.console import Console
    from rich.table import Table

    from fcw.units import KMH_PER_MPS

    table = Table("scenario", "in time", "TTC", "gap", "asked for", "impact left", box=None)
    for result in results:
        scenario, ttc_s, gap_m = result.scenario, result.median("ttc_s"), result.median("gap_m")
        if scenario.required_ttc_s is not None:
            asked = f"TTC {scenario.required_ttc_s:.1f} s"
        elif scenario.required_gap_m is None:
            asked = "cannot be avoided"
        else:
            asked = f"{scenario.required_gap_m:.1f} m" + ("" if scenario.preventable else " (reported)")
        worst_mps = max(trial.impact_mps for trial in result.trials)
        table.add_row(
            scenario.name,
            f"{result.trials_passed} of {len(result.trials)}",
            "-" if ttc_s is None else f"{ttc_s:.1f} s",
            "-" if gap_m is None else f"{gap_m:.1f} m",
            asked,
            "none" if worst_mps == 0 else f"up to {worst_mps * KMH_PER_MPS:.0f} km/h",
        )
    console = Console()
    console.print(table)
    trials = [trial for result in results for trial in result.trials]
    console.print(
        f"needless warnings: {sum(trial.needless for trial in trials)}, "
        f"never warned: {sum(trial.warned_s is None for trial in trials)} of {len(trials)} trials",
        highlight=False,
    )
