"""A warning and its reason in words."""

from fcw.tracking.types import Track
from fcw.units import distance_text, speed_text
from fcw.warning.driver import RULE_BRAKING_DUE, STANDARD_GRAVITY_MPS2
from fcw.warning.types import WarningLevel, WarningState

REASONS = {
    "ttc": "short time to collision",
    "required_deceleration": "hard braking is required",
    RULE_BRAKING_DUE: "braking is due",
    "headway": "following too closely",
    "rss": "closer than the safe distance",
}
"""Words for the rules by their names."""


def describe(state: WarningState, track: Track | None, imperial: bool = False) -> str:
    """The warning and its reason in words, for logs and viewers.

    Args:
        state: the warning.
        track: the vehicle it is about, where it is still followed.
        imperial: feet and miles per hour.
    """
    if state.level == WarningLevel.NONE:
        return "no warning"
    text = f"{state.level.name.lower()}: {REASONS.get(state.rule, state.rule)}"
    if track is None:
        return f"{text}; vehicle {state.track_id} is no longer seen"
    low, high = (distance_text(d, imperial) for d in (track.distance_low_m, track.distance_high_m))
    high = "unbounded" if high.startswith("inf") else high
    parts = [f"vehicle {track.track_id} at {distance_text(track.distance_m, imperial)} ({low} to {high})"]
    if state.ttc_s is not None:
        parts.append(f"closing at {speed_text(track.closing_speed_mps, imperial)}")
        parts.append(f"collision in {state.ttc_s:.1f} s")
    if state.required_deceleration_mps2 is not None:
        parts.append(f"needs {state.required_deceleration_mps2 / STANDARD_GRAVITY_MPS2:.2f} g")
    if state.headway_s is not None:
        parts.append(f"headway {state.headway_s:.1f} s")
    return f"{text}; {', '.join(parts)}"
