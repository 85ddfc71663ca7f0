"""Words on the page for events and for what people said."""

import math
from collections.abc import Iterable
from datetime import UTC, datetime

from fcw.annotation.records import Entry, Judgement, LabelledBox, Verdict
from fcw.annotation.review import JudgedEvent
from fcw.logs.events import DriveEvent
from fcw.logs.overlay import own_speed_text
from fcw.logs.records import FrameResult
from fcw.tracking.types import Track
from fcw.units import distance_text, speed_text
from fcw.warning.describe import braking_text, reason
from fcw.warning.types import WarningLevel, WarningState

NEAR_MISS, MOUNT_MOVED, NOTHING_SEEN, CUT = "near miss", "mount moved", "nothing seen", "cut"
POOR_SIGHT = "poor sight"
KIND_TITLES = {
    "warning": "Warning",
    "caution": "Caution",
    "advisory": "Advisory",
    NEAR_MISS: "Near miss",
    MOUNT_MOVED: "Mount moved",
    NOTHING_SEEN: "Nothing seen",
    CUT: "Cut",
    POOR_SIGHT: "Poor sight",
}
"""Names of the kinds of events."""
KIND_MEANINGS = {
    "warning": "the driver must act now",
    "caution": "the driver should get ready",
    "advisory": "following too closely",
    NEAR_MISS: "close, but no warning",
    MOUNT_MOVED: "the camera has moved",
    NOTHING_SEEN: "black picture, or none at all",
    CUT: "an edited clip, another camera or a damaged picture",
    POOR_SIGHT: "a soft, dark, faint or overexposed picture",
}
"""Short explanations of the kinds of events."""
JUDGEMENT_SIGNS = {
    Judgement.RIGHT: "✓",
    Judgement.TOO_EARLY: "◂",
    Judgement.TOO_LATE: "▸",
    Judgement.FALSE: "✗",
}
JUDGEMENT_KEYS = {
    Judgement.RIGHT: "1",
    Judgement.TOO_EARLY: "2",
    Judgement.TOO_LATE: "3",
    Judgement.FALSE: "4",
}
DISAGREEMENT_SIGN = "≠"
DISAGREEMENT = "judged differently"
LEVEL_NAMES = {
    WarningLevel.NONE: "no warning",
    WarningLevel.ADVISORY: "advisory: following too closely",
    WarningLevel.CAUTION: "caution: get ready",
    WarningLevel.WARNING: "warning: act now",
}


def kind_title(kind: str) -> str:
    """The name of a kind of event."""
    return KIND_TITLES.get(kind, kind.capitalize())


def event_line(event: DriveEvent, imperial: bool) -> str:
    """The figures of an event in one short line."""
    parts = []
    if event.min_distance_m is not None:
        parts.append(distance_text(event.min_distance_m, imperial))
    if event.min_ttc_s is not None:
        parts.append(f"TTC {event.min_ttc_s:.1f} s")
    if event.max_required_deceleration_mps2:
        parts.append(braking_text(event.max_required_deceleration_mps2))
    return " · ".join(parts)


def why(result: FrameResult, imperial: bool) -> list[tuple[str, str]]:
    """Why there is a warning at a frame, or none, as pairs of a quantity and its value."""
    warning = result.told_warning
    rows = [("Level", LEVEL_NAMES[warning.level])]
    if warning.rule:
        rows.append(("Rule", reason(warning, imperial)))
    track = result.warned or result.lead
    if warning.extrapolated:
        rows += _lost_rows(warning, imperial)
    elif track is None:
        rows.append(("Ahead", "no vehicle in our path" if warning.track_id is None else "not seen any more"))
        return rows
    else:
        rows += _vehicle_rows(track, track.track_id == result.lead_id, imperial)
    if warning.required_deceleration_mps2 is not None:
        rows.append(("Braking needed", braking_text(warning.required_deceleration_mps2)))
    if warning.collision_probability is not None and warning.overlap_m is not None:
        rows.append(("Overlap", _overlap_words(warning.overlap_m, imperial)))
        rows.append(("Collision", f"{warning.collision_probability:.0%} likely if nobody reacts"))
    if warning.headway_s is not None:
        rows.append(("Headway", f"{warning.headway_s:.1f} s"))
    if result.ego_speed_mps is not None:
        rows.append(("Own speed", own_speed_text(result, imperial).replace("+-", "±")))
    return rows


def _vehicle_rows(track: Track, is_lead: bool, imperial: bool) -> list[tuple[str, str]]:
    rows = [("Vehicle", f"#{track.track_id}{', the lead' if is_lead else ''}")]
    distance = f"{distance_text(track.distance_m, imperial)}, {interval_words(track, imperial)}"
    rows.append(("Distance", distance))
    sigma_mps = track.closing_speed_sigma_mps
    closing = f"{speed_text(abs(track.closing_speed_mps), imperial)} ± {speed_text(sigma_mps, imperial)}"
    rows.append(("Closing" if track.closing_speed_mps >= 0 else "Opening", closing))
    if track.ttc_s is not None:
        rows.append(("Collision in", f"{track.ttc_s:.1f} s"))
    return rows


def _lost_rows(warning: WarningState, imperial: bool) -> list[tuple[str, str]]:
    """The figures of a vehicle that is no longer tracked, extrapolated to now."""
    rows = [("Vehicle", f"#{warning.track_id}, not seen any more; extrapolated figures")]
    if warning.distance_m is not None:
        rows.append(("Distance", distance_text(warning.distance_m, imperial)))
    if warning.closing_speed_mps is not None:
        rows.append(("Closing", speed_text(warning.closing_speed_mps, imperial)))
    if warning.ttc_s is not None:
        rows.append(("Collision in", f"{warning.ttc_s:.1f} s"))
    return rows


def _overlap_words(overlap_m: float, imperial: bool) -> str:
    """How much of its width and ours will overlap; words are used if it rounds to zero."""
    text = distance_text(abs(overlap_m), imperial)
    if text == distance_text(0.0, imperial):
        return "next to none"
    return text if overlap_m > 0 else f"none, {text} apart"


def moment_words(warning: WarningState, imperial: bool) -> str:
    """The warning at a time with its reason, without the figures that are beside the plots."""
    level = warning.level.name.capitalize()
    return f"{level}: {reason(warning, imperial)}" if warning.level is not WarningLevel.NONE else "No warning"


def interval_words(track: Track, imperial: bool) -> str:
    """The interval that contains a distance two times out of three."""
    low = distance_text(track.distance_low_m, imperial)
    if not math.isfinite(track.distance_high_m):
        return f"more than {low}"
    return f"{low} to {distance_text(track.distance_high_m, imperial)}"


def verdict_words(entry: Entry[Verdict]) -> str:
    """A verdict in words: who, what and why."""
    verdict = entry.said
    parts = [verdict.judgement.value]
    if verdict.reason is not None:
        parts.append(verdict.reason.value)
    if verdict.text:
        parts.append(verdict.text)
    return f"{entry.person}: {', '.join(parts)}"


def verdict_sign(judged: JudgedEvent) -> str:
    """The sign for the common judgement of an event, or for disagreement; empty if nobody judged it."""
    if judged.judgement is not None:
        return JUDGEMENT_SIGNS[judged.judgement]
    return DISAGREEMENT_SIGN if judged.disagreement else ""


def verdict_counts(events: Iterable[JudgedEvent]) -> str:
    """How many events are judged, counted as by `fcw review --summary`; empty if none is."""
    events = tuple(events)
    judgements = [one.judgement for one in events if one.judgement is not None]
    disagreed = sum(one.disagreement for one in events)
    parts = []
    if judgements:
        parts.append(f"{len(judgements)} judged")
    if Judgement.FALSE in judgements:
        parts.append(f"{judgements.count(Judgement.FALSE)} of them false")
    if disagreed:
        parts.append(f"{disagreed} {DISAGREEMENT}")
    return ", ".join(parts)


def when_words(time: str) -> str:
    """The date and time of an entry, in local time."""
    moment = datetime.strptime(time, "%Y-%m-%dT%H:%M:%S.%fZ").replace(tzinfo=UTC).astimezone()
    return moment.strftime("%Y-%m-%d %H:%M")


def box_words(label: LabelledBox, edited: bool, missing: bool) -> str:
    """The words for a box while boxes are corrected.

    Args:
        label: the present box.
        edited: whether somebody has edited it.
        missing: whether the frame has no box for it.
    """
    parts = [f"#{label.track_id}" if label.track_id is not None else "added"]
    parts += ["not in this frame yet"] * missing
    parts += ["corrected"] * (edited and label.track_id is not None)
    parts += [one.value for one in (label.view, label.kind) if one is not None]
    parts += [f"hidden {label.occluded}"] * bool(label.occluded)
    parts += ["ignored"] * label.ignore
    return "  ".join(parts)
