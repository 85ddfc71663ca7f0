"""`fcw evaluate warning --threats` and `--nuisance`: simulated dangers, and warnings that nobody needs."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

    from fcw_viz.commands.evaluate.warning import EvaluateWarningCommand


def evaluate_threats(command: "EvaluateWarningCommand", console: "Console") -> dict[str, Any]:
    """Print and return how simulated dangers, or the variants of them, are warned of."""
    from rich.table import Table

    from fcw.detection.choice import load_model, make_detector
    from fcw.detection.detector import Detector
    from fcw.evaluation.warning.threats import run_threats
    from fcw.simulation.drive import true_calibration
    from fcw.simulation.world.scenario import Scenario, load_scenario, threat_names
    from fcw.warning.policies import make_policy
    from fcw_viz.console import progress

    if command.variants:
        return _variants(command, console)
    model = load_model(command.detector) if command.pixels else None

    def detector_of(scenario: Scenario) -> Detector | None:
        return None if model is None else make_detector(command.detector, model, true_calibration(scenario))

    scenarios = [(name, load_scenario(name)) for name in threat_names()]
    seeds = range(command.seed, command.seed + command.seeds)
    with progress("runs", len(scenarios) * len(seeds)) as bar:
        results = run_threats(
            scenarios,
            lambda: make_policy(command.warning_policy, command.warning_timing),
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


def _variants(command: "EvaluateWarningCommand", console: "Console") -> dict[str, Any]:
    from rich.table import Table

    from fcw.evaluation.warning.threats import run_threats
    from fcw.evaluation.warning.variants import SIGHTS, half_in_the_way
    from fcw.warning.policies import make_policy
    from fcw_viz.console import progress

    scenarios = list(half_in_the_way())
    seeds = range(command.seed, command.seed + command.seeds)
    found: dict[str, dict[str, int]] = {name: {} for name, _ in scenarios}
    false_warnings = 0
    with progress("runs", len(SIGHTS) * len(scenarios) * len(seeds)) as bar:
        for sight in SIGHTS:
            results = run_threats(
                scenarios,
                lambda: make_policy(command.warning_policy, command.warning_timing),
                seeds,
                on_trial=bar.advance,
                sight=sight,
            )
            for result in results:
                found[result.name][sight.name] = result.trials_passed
                false_warnings += result.false_warnings
    table = Table("variant", *(sight.name for sight in SIGHTS), box=None)
    for name, passed in found.items():
        table.add_row(name, *(f"{passed[sight.name]} of {len(seeds)}" for sight in SIGHTS))
    console.print(table)
    total = len(seeds) * len(scenarios) * len(SIGHTS)
    in_time = sum(sum(passed.values()) for passed in found.values())
    console.print(f"{in_time} of {total} as they should", highlight=False)
    return {
        "variants": [{"name": name, "trials": len(seeds), "passed": each} for name, each in found.items()],
        "dangers_in_window": in_time / total,
        "false_alarms": false_warnings,
        "missed": total - in_time,
    }


def evaluate_nuisance(command: "EvaluateWarningCommand", console: "Console") -> dict[str, Any]:
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
    if command.kitti_tracking is not None:
        names = sequence_names(command.kitti_tracking)
        with progress("drives", len(names)) as bar:
            found = nuisance_on_kitti(
                command.kitti_tracking, names, policies, command.box_noise, command.seed, bar.advance
            )
        for policy, rate in found.items():
            rates[policy] |= {f"KITTI, {level.name.lower()}": rate[level] for level in levels}
    if command.following_hours is not None:
        view = BoxLevel(
            box_noise_px=command.box_noise, sight_m=command.sight, frame_rate_hz=FOLLOWING_RATE_HZ
        )
        with progress("hours", float(command.following_hours)) as bar:
            found = nuisance_following(policies, view, command.following_hours, command.seed, bar.advance)
        for policy, rate in found.items():
            rates[policy] |= {f"following, {level.name.lower()}": rate[level] for level in levels}
    columns = list(next(iter(rates.values())))
    table = Table("policy", "timing", *columns, box=None)
    for policy, each in rates.items():
        table.add_row(policy.name, policy.timing, *(f"{each[column]:.1f}" for column in columns))
    console.print("an hour:", highlight=False)
    console.print(table)
    return {
        "nuisance": [
            {"policy": policy.name, "timing": policy.timing, "per_hour": each}
            for policy, each in rates.items()
        ]
    }
