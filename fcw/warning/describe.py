"""A warning and its reason in words."""

from fcw.units import STANDARD_GRAVITY_MPS2, distance_text, speed_text
from fcw.warning.driver import RULE_BRAKING_DUE
from fcw.warning.types import WarningLevel, WarningState

REASONS = {
    "ttc": "short time to collision",
    "required_deceleration": "hard braking is required",
    RULE_BRAKING_DUE: "braking is due",
    "headway": "following too closely",
    "rss": "closer than the safe distance",
}
"""Words for the rules by their names."""
MOST_BRAKING_G = 2
"""Twice what a car can do."""


def describe(state: WarningState, imperial: bool = False) -> str:
    """The warning and its reason in words, for logs and viewers.

    Args:
        state: the warning.
        imperial: feet and miles per hour instead of metric units.
    """
    if state.level == WarningLevel.NONE:
        return "no warning"
    parts = [f"{state.level.name.lower()}: {reason(state, imperial)}"]
    if state.distance_m is None:
        return f"{parts[0]}; vehicle {state.track_id}"
    high_m = state.distance_high_m
    high = "unbounded" if high_m is None or high_m == float("inf") else distance_text(high_m, imperial)
    low = distance_text(state.distance_low_m or 0.0, imperial)
    vehicle = f"vehicle {state.track_id}{', not seen any more,' if state.extrapolated else ''}"
    figures = [f"{vehicle} at {distance_text(state.distance_m, imperial)} ({low} to {high})"]
    if state.ttc_s is not None:
        if state.closing_speed_mps is not None:
            figures.append(f"closing at {speed_text(state.closing_speed_mps, imperial)}")
        figures.append(f"collision in {state.ttc_s:.1f} s")
    if state.required_deceleration_mps2 is not None:
        figures.append(f"needs {braking_text(state.required_deceleration_mps2)}")
    if state.headway_s is not None:
        figures.append(f"headway {state.headway_s:.1f} s")
    return f"{parts[0]}; {', '.join(figures)}"


def reason(state: WarningState, imperial: bool = False) -> str:
    """The rule behind the level, its threshold and what it assumes, in words.

    Args:
        state: a warning; its level is not NONE.
        imperial: feet instead of metres.
    """
    text, assumes = REASONS.get(state.rule, state.rule), state.assumes
    needed_m = state.needed_distance_m
    if not assumes:
        return text
    if state.rule == RULE_BRAKING_DUE and needed_m is not None and state.distance_m is not None:
        spare_m = state.distance_m - needed_m
        end = f"would stay only {distance_text(spare_m, imperial)} clear"
        if spare_m < 0:
            end = f"are {distance_text(-spare_m, imperial)} too close"
        return f"{text}, because with {assumes} you {end}"
    if state.rule == "rss" and needed_m is not None:
        return f"{text} of {distance_text(needed_m, imperial)}, for {assumes}"
    limit = "more than" if state.rule == "required_deceleration" else "less than"
    if needed_m is not None and state.distance_m is not None and state.distance_m > needed_m:
        # The means do not break the limit: they did a moment ago, or the values within the uncertainty do.
        limit = f"{'recently' if state.rule == 'headway' else 'perhaps'} {limit}"
    return f"{text}, {limit} {assumes}"


def braking_text(deceleration_mps2: float) -> str:
    """A deceleration in g; "over 2 g" for one that no car reaches (at contact it is infinite)."""
    braking_g = deceleration_mps2 / STANDARD_GRAVITY_MPS2
    return f"over {MOST_BRAKING_G} g" if braking_g > MOST_BRAKING_G else f"{braking_g:.2f} g"
