"""`fcw evaluate warning --threats` and `--nuisance`: simulated dangers, and warnings that nobody needs."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

    from fcw.evaluation.warning.sights import Sight
    from fcw.simulation.world.scenario import Scenario
    from fcw.warning.types import WarningPolicy


def evaluate_threats(
    make_policy: "Callable[[], WarningPolicy]", seeds: range, detector: str | None, console: "Console"
) -> dict[str, Any]:
    """Print and return how simulated dangers are warned of, from pictures where there is a detector."""
    from rich.table import Table

    from fcw.detection.choice import load_model, make_detector
    from fcw.detection.detector import Detector
    from fcw.evaluation.warning.threats import run_threats
    from fcw.simulation.drive import true_calibration
    from fcw.simulation.world.scenario import load_scenario, threat_names
    from fcw_viz.console import progress

    model = None if detector is None else load_model(detector)

    def detector_of(scenario: "Scenario") -> Detector | None:
        if detector is None or model is None:
            return None
        return make_detector(detector, model, true_calibration(scenario), for_tracker=True)

    scenarios = [(name, load_scenario(name)) for name in threat_names()]
    with progress("runs", len(scenarios) * len(seeds)) as bar:
        results = run_threats(
            scenarios,
            make_policy,
            seeds,
            detector_of,
            bar.advance,
        )
    table = Table("scenario", "danger", "as it should", "false", "before contact", box=None)
    for result in results:
        lead_s = result.lead_s
        table.add_row(
            result.name,
            result.danger or "-",
            f"{result.trials_passed} of {len(result.trials)}",
            str(result.false_warnings),
            "-" if lead_s is None else f"{lead_s:.1f} s",
        )
    console.print(table)
    dangers = [trial for result in results if result.danger for trial in result.trials]
    return {
        "threats": [
            {
                "name": result.name,
                "danger": result.danger,
                "trials": len(result.trials),
                "trials_passed": result.trials_passed,
                "false_warnings": result.false_warnings,
                "warned_before_contact_s": result.lead_s,
            }
            for result in results
        ],
        "dangers_in_window": sum(trial.passed for trial in dangers) / len(dangers),
        "false_alarms": sum(result.false_warnings for result in results),
        "missed": sum(not trial.passed for trial in dangers),
    }


def evaluate_variants(
    make_policy: "Callable[[], WarningPolicy]", seeds: range, console: "Console"
) -> dict[str, Any]:
    """Print and return how vehicles half in the way are warned of, seen well and badly."""
    from fcw.evaluation.warning.sights import SIGHTS
    from fcw.evaluation.warning.variants import half_in_the_way

    return _evaluate_sights(list(half_in_the_way()), SIGHTS, "variants", make_policy, seeds, console)


def evaluate_worse_boxes(
    make_policy: "Callable[[], WarningPolicy]", seeds: range, console: "Console"
) -> dict[str, Any]:
    """Print and return how all scenarios are warned of with the boxes of a worse detector."""
    from fcw.evaluation.warning.sights import WORSE_SIGHTS
    from fcw.simulation.world.scenario import load_scenario, threat_names

    scenarios = [(name, load_scenario(name)) for name in threat_names()]
    return _evaluate_sights(scenarios, WORSE_SIGHTS, "worse_boxes", make_policy, seeds, console)


def _evaluate_sights(
    scenarios: "Sequence[tuple[str, Scenario]]",
    sights: "Sequence[Sight]",
    key: str,
    make_policy: "Callable[[], WarningPolicy]",
    seeds: range,
    console: "Console",
) -> dict[str, Any]:
    from rich.table import Table

    from fcw.evaluation.warning.threats import run_threats
    from fcw_viz.console import progress

    found: dict[str, dict[str, int]] = {name: {} for name, _ in scenarios}
    in_time = false_warnings = dangers = dangers_in_time = 0
    with progress("runs", len(sights) * len(scenarios) * len(seeds)) as bar:
        for sight in sights:
            for result in run_threats(scenarios, make_policy, seeds, on_trial=bar.advance, sight=sight):
                found[result.name][sight.name] = result.trials_passed
                in_time += result.trials_passed
                false_warnings += result.false_warnings
                if result.danger:
                    dangers += len(result.trials)
                    dangers_in_time += result.trials_passed
    table = Table("boxes", "dangers in time", "harmless and silent", "failed", box=None)
    for sight in sights:
        failed = {name: len(seeds) - found[name][sight.name] for name, _ in scenarios}
        cells = []
        for with_danger in (True, False):
            of_kind = [name for name, scenario in scenarios if bool(scenario.danger) == with_danger]
            passed = sum(found[name][sight.name] for name in of_kind)
            cells.append(f"{passed} of {len(seeds) * len(of_kind)}" if of_kind else "-")
        named = ", ".join(
            name if count == 1 else f"{name} x{count}" for name, count in failed.items() if count
        )
        table.add_row(sight.name, *cells, named or "-")
    console.print(table)
    total = len(seeds) * len(scenarios) * len(sights)
    console.print(f"{in_time} of {total} as required", highlight=False)
    return {
        key: [{"name": name, "trials": len(seeds), "passed": each} for name, each in found.items()],
        "dangers_in_window": dangers_in_time / dangers if dangers else None,
        "false_alarms": false_warnings,
        "missed": dangers - dangers_in_time,
    }


def evaluate_nuisance(
    kitti_tracking: Path | None,
    following_hours: float | None,
    box_noise_px: float,
    seed: int,
    console: "Console",
) -> dict[str, Any]:
    """Print and return the warnings an hour of every policy and timing."""
    from rich.table import Table

    from fcw.evaluation.distance.kitti_tracking import sequence_names
    from fcw.evaluation.warning.false_alarms import FOLLOWING_RATE_HZ
    from fcw.evaluation.warning.nuisance import Policy, all_policies, nuisance_following, nuisance_on_kitti
    from fcw.evaluation.warning.scenarios import BoxLevel
    from fcw.warning.types import WarningLevel
    from fcw_viz.console import progress

    policies = all_policies()
    rates: dict[Policy, dict[str, float]] = {policy: {} for policy in policies}
    levels = (WarningLevel.CAUTION, WarningLevel.WARNING)
    if kitti_tracking is not None:
        names = sequence_names(kitti_tracking)
        with progress("drives", len(names)) as bar:
            found = nuisance_on_kitti(kitti_tracking, names, policies, box_noise_px, seed, bar.advance)
        for policy, rate in found.items():
            rates[policy] |= {f"KITTI, {level.name.lower()}": rate[level] for level in levels}
    if following_hours is not None:
        view = BoxLevel(box_noise_px=box_noise_px, frame_rate_hz=FOLLOWING_RATE_HZ)
        with progress("hours", float(following_hours)) as bar:
            found = nuisance_following(policies, view, following_hours, seed, bar.advance)
        for policy, rate in found.items():
            rates[policy] |= {f"following, {level.name.lower()}": rate[level] for level in levels}
    columns = list(next(iter(rates.values())))
    table = Table("policy", "timing", *columns, box=None)
    for policy, each in rates.items():
        table.add_row(policy.name, policy.timing, *(f"{each[column]:.1f}" for column in columns))
    console.print("per hour:", highlight=False)
    console.print(table)
    return {
        "nuisance": [
            {"policy": policy.name, "timing": policy.timing, "per_hour": each}
            for policy, each in rates.items()
        ]
    }
