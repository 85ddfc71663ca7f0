"""The sentences that the calibration's logic says to people."""

import math
from collections.abc import Sequence

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.plausibility import Finding, FindingKind, OffsetProposal
from fcw.camera.points import FARTHEST_POINT_M, PointsError, PointsFault
from fcw.camera.uncertainty import NextClick
from fcw.camera.verdicts.hypotheses import Fault
from fcw.camera.verdicts.judgement import Suspicion
from fcw.camera.verdicts.words import cause_text
from fcw_viz.calibrate_app.document.document import Document, Mark
from fcw_viz.calibrate_app.document.numbers_text import (
    about_text,
    gain_text,
    in_units,
    interval_text,
    typed_text,
    with_lengths,
)
from fcw_viz.calibrate_app.document.ways.hints import HINTS, hint_plates, hint_rectangle

NUMBER_WORDS = {2: "two", 3: "three"}
POINTS_KEEP_DISTANCES = "The distances still hold; lateral positions and box sizes do not."
FIRST_DASH = "Click the near end of the nearest dash that is fully visible."
NEXT_DASH = "Click the near end of the next dash along the same line."
ROUGH_ERROR = 0.12
"""An error of more than this part at the distance of the quality sentence is called rough."""


def names(marks: Sequence[Mark]) -> str:
    """`A`, `A and B`, `A, B and C`."""
    letters = [mark.name for mark in marks]
    return letters[0] if len(letters) == 1 else f"{', '.join(letters[:-1])} and {letters[-1]}"


def hint_incomplete(document: Document, missing: int) -> str:
    """What to do next while something has still to be said; `missing` is the number of facts still needed."""
    lacks_corners = len(document.whole_rectangles) < len(document.rectangles)
    if lacks_corners or (document.whole_rectangles and not document.has_size and document.height_m is None):
        return hint_rectangle(document)
    if document.plates != document.whole_plates:
        return hint_plates(document)
    if not document.marks and not document.planned_m:
        if document.way == "":
            return "Choose what you have to calibrate with, or click a mark whose distance you know."
        if document.way in HINTS:
            return HINTS[document.way](document)
        return "Click a mark on the road whose distance you know."
    untold = [mark for mark in document.marks if mark.enabled and mark.distance_m is None]
    if untold:
        return f"Type the distance of {untold[0].name}."
    if missing > 0:
        if document.paced and document.next_planned_m is not None:
            return FIRST_DASH if not document.marks else NEXT_DASH
        if document.next_planned_m is not None:
            return f"Click the mark at {typed_text(document.next_planned_m, document.imperial)}."
        if missing == 1:
            return "Click one more mark at another distance, preferably far away."
        return f"Click {NUMBER_WORDS[missing]} more marks at other distances, one of them far away."
    if document.reference_offset_m is None:
        return "Type how far the front bumper is ahead of the camera."
    return "Type the camera's height above the road."


def hint_next_click(next_click: NextClick | None, imperial: bool) -> str:
    """What to do with a good solution."""
    if next_click is None:
        return "Save it."
    return (
        f"Save it, or click one more mark {about_text(next_click.distance_m, imperial)}: "
        f"that {gain_text(next_click.error_before, next_click.error_after)}."
    )


def hint_degenerate() -> str:
    """What to do where no camera follows."""
    return "No camera fits these points yet: fix what is marked."


def hint_implausible() -> str:
    """What to do with a solution that something speaks against."""
    return "Check the warning first: a calibration saved now includes it."


def noise_would_do(tape_error: float) -> str:
    """Why something is asked and not said."""
    return f"If each mark may be off by {tape_error:.0%}, that would explain it as well."


def hint_doubtful() -> str:
    """What to do with a plausible solution that leaves a question open."""
    return "One question is open; the interval allows for it."


def quality(distance_m: float, low_m: float, high_m: float, imperial: bool) -> str:
    """How good a camera is at one distance."""
    unit = "ft" if imperial else "m"
    at = f"{in_units(distance_m, imperial):.3g} {unit}"
    if not math.isfinite(high_m):
        low = f"{max(in_units(low_m, imperial), 0.0):.0f} {unit}"
        return f"A reading of {at} only means farther than {low}. Add a far point."
    rough = (
        ""
        if (high_m - low_m) / 2 <= ROUGH_ERROR * distance_m
        else " Rough: good enough to rank moments, not to measure."
    )
    return f"A reading of {at} means {interval_text(low_m, high_m, imperial, ' to ')} {unit}.{rough}"


def degenerate(error: PointsError, marks: Sequence[Mark], imperial: bool, guess: bool = True) -> str:
    """Why points determine no camera, the points by their letters; `guess` at a cause where none is known."""

    def at(mark: Mark) -> str:
        return f"{mark.name} ({typed_text(mark.distance_m or 0.0, imperial)})"

    if len(marks) == 2:
        near, far = marks
        match error.fault:
            case PointsFault.SAME_DISTANCE:
                return (
                    f"{names(marks)} have the same distance, {typed_text(near.distance_m or 0.0, imperial)}, "
                    "in different places. Correct one of the two."
                )
            case PointsFault.SAME_ROW:
                return (
                    f"{at(near)} and {at(far)} are in the same row. A farther mark stands higher in the "
                    "picture: click one of them again."
                )
            case PointsFault.ORDER:
                text = f"{at(far)} is farther than {at(near)} but lower in the picture."
                cause = "Their distances are probably swapped, or one was clicked on the wrong mark."
                return f"{text} {cause}" if guess else text
            case _:
                pass
    match error.fault:
        case PointsFault.NOT_A_POINT:
            limit = typed_text(FARTHEST_POINT_M, imperial)
            return f"{at(marks[0])} is farther than anyone can measure ({limit}). Correct its distance."
        case PointsFault.ROWS_TOGETHER:
            return (
                f"The rows of {names(marks)} differ by less than the click error. "
                "Use marks whose distances differ more."
            )
        case PointsFault.HORIZON_BELOW_ROAD:
            return (
                f"With distance, the rows of {names(marks)} do not crowd together as they do on a flat "
                "road, so there is no horizon above them. A distance is wrong, or a point is on the wrong "
                "mark."
            )
        case _:
            return str(error)


def camera_trouble(calibration: Calibration, findings: Sequence[Finding]) -> str:
    """What cannot be true of the camera, and why it may have come out so."""
    camera = calibration.camera
    pitch_deg, field_of_view_deg = math.degrees(camera.pitch_rad), math.degrees(calibration.field_of_view_rad)
    facts = {
        FindingKind.PITCH: f"looks {abs(pitch_deg):.0f}° {'down' if pitch_deg > 0 else 'up'}",
        FindingKind.FIELD_OF_VIEW: f"has a field of view of {field_of_view_deg:.0f}°",
        FindingKind.PRINCIPAL_ROW: f"has its axis at row {camera.principal_row_px:.0f}, "
        f"not near the picture's middle, row {(calibration.image_size.height - 1) / 2:.0f}",
        FindingKind.HORIZON: f"has the horizon at row {camera.horizon_row_px:.0f}, outside the picture",
    }
    kinds = {finding.kind for finding in findings}
    found = [fact for kind, fact in facts.items() if kind in kinds]
    if not found:
        return "These points do not fit a camera behind a windscreen well."
    text = found[0] if len(found) == 1 else f"{', '.join(found[:-1])} and {found[-1]}"
    return f"This cannot be a camera behind a windscreen: it {text}. {POINTS_KEEP_DISTANCES}"


def offset_cause(document: Document, proposal: OffsetProposal) -> str:
    """Why an offset is likely."""
    imperial = document.imperial
    offset, unit = typed_offset(proposal.offset_m, imperial), "ft" if imperial else "m"
    low, high = (f"{in_units(value, imperial):.1f}" for value in (proposal.low_m, proposal.high_m))
    if document.from_bumper:
        return (
            f"Likely cause: the bumper is {offset} ahead of the camera, not "
            f"{typed_offset(document.bumper_offset_m or 0.0, imperial)} ({low} to {high} {unit} would fit)."
        )
    return (
        f"Likely cause: the distances were measured from the front bumper, {offset} ahead of the camera "
        f"({low} to {high} {unit} would fit). Measure it if you can."
    )


def typed_offset(offset_m: float, imperial: bool) -> str:
    """An offset as somebody would type it."""
    return f"{in_units(offset_m, imperial):.2f} {'ft' if imperial else 'm'}"


def offset_label(document: Document, offset_m: float) -> str:
    """The button that sets the offset."""
    offset = typed_offset(offset_m, document.imperial)
    if document.from_bumper:
        return f"Set the bumper offset to {offset}"
    return f"Distances were measured from the bumper: set the offset to {offset}"


def residual_trouble(mark: Mark, residual_px: float, sigma_px: float) -> str:
    """A point off the curve."""
    return (
        f"{mark.name} lies {abs(residual_px):.1f} px {'below' if residual_px > 0 else 'above'} the row "
        f"that everything else gives, {abs(residual_px) / sigma_px:.0f} times the click error. "
        "Check its distance, or click it again."
    )


def sky_trouble(mark: Mark) -> str:
    """A point above the horizon."""
    return f"{mark.name} lies above the horizon, in the sky. Click a mark on the road."


def delete_label(mark: Mark) -> str:
    """The button that deletes a mark."""
    return f"Delete {mark.name}"


def outside_trouble(mark: Mark) -> str:
    """A point that is not in the picture."""
    return f"{mark.name} lies outside the picture. Drag it to its mark, or leave it out."


def prior_trouble(name: str, prior: Gaussian, value: float, unit: float, unit_name: str) -> str:
    """A belief that the rest contradicts."""
    return (
        f"The {name} of {prior.value * unit:.4g} ± {prior.sigma * unit:.2g}{unit_name} contradicts the rest, "
        f"with which it comes out as {value * unit:.4g}. Check it, the distances and the camera's height."
    )


def horizons_disagree(dragged: Gaussian, lanes: Gaussian) -> str:
    """A dragged horizon that the lane lines contradict."""
    return (
        f"The lane lines meet at row {lanes.value:.0f} ± {lanes.sigma:.1f}, but the horizon is set to row "
        f"{dragged.value:.0f} ± {dragged.sigma:.1f}: one of the two is wrong."
    )


EXCHANGE_LABEL = "Swap the sides of the rectangle"
FIT_LENS_LABEL = "Fit the lens's distortion with the rest"
LENS_WAY_OUT = (
    "It is best to import the lens under “Lens and horizon”: `fcw calibrate PICTURES --chessboard 9x6` "
    "makes that file. Without a chessboard, the distortion is fitted with the rest; the more edges you "
    "click, the better."
)
CONTRADICTION = "The inputs contradict each other, so no interval here can be trusted."
SORT_LABEL = "Sort the distances by row, nearest at the bottom"
UNKNOWN_CAUSE = "Likely cause: a wrong distance or camera height, or a road that is not flat. Measure again."


def verdict_cause(document: Document, marks: Sequence[Mark], named: Suspicion) -> str:
    """Why a camera came out badly, the points by their letters."""
    imperial = document.imperial
    wrong = [marks[k] for k in named.points]
    match named.fault:
        case Fault.SWAPPED:
            return f"Likely cause: the distances of {names(wrong)} are swapped."
        case Fault.SLIP_OF_TEN:
            meant = typed_text(named.distances_m[named.points[0]], imperial)
            said = typed_text(wrong[0].distance_m or 0.0, imperial)
            return f"Likely cause: {wrong[0].name} is {meant} away, not {said}: a slip of the decimal point."
        case Fault.FEET:
            typed, really = ("feet", "metres") if imperial else ("metres", "feet")
            return f"Likely cause: the distances were typed as {typed}, but are in {really}."
        case Fault.POINT:
            return (
                f"Likely cause: {wrong[0].name} is on the wrong mark or has a wrong distance; without it, "
                "all others agree."
            )
        case _:
            offset_m = document.reference_offset_m or 0.0
            points = [mark.ground_point for mark in marks if mark.ground_point is not None]
            return with_lengths(f"Likely cause: {cause_text(named, points, offset_m)}.", imperial)


def distance_label(mark: Mark, distance_m: float, imperial: bool) -> str:
    """The button that corrects one distance."""
    return f"Set the distance of {mark.name} to {typed_text(distance_m, imperial)}"


def unit_label(imperial: bool) -> str:
    """The button that takes the distances for those of the other unit."""
    return f"Read the distances as {'metres' if imperial else 'feet'}"


def height_trouble(document: Document, height_m: float) -> str:
    """A height that no windscreen has."""
    return (
        f"A lens {typed_text(height_m, document.imperial)} above the road cannot be behind a windscreen. "
        "Measure from the road up to the lens."
    )


def height_label(typed: float, unit: str) -> str:
    """The button that takes the height's number for one of another unit."""
    return f"Read the height as {typed:.4g} {unit}"


def switch_off_label(name: str) -> str:
    """The button that switches a belief off."""
    return f"Switch the {name} off"


def swap_label(first: Mark, second: Mark) -> str:
    """The button that swaps two distances."""
    return f"Swap the distances of {first.name} and {second.name}"


def leave_out_label(mark: Mark) -> str:
    """The button that switches a mark off."""
    return f"Leave {mark.name} out"
