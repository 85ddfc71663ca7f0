"""The result of a calibration: as JSON has it, and as a person reads it."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from fcw.camera.calibration import Calibration
from fcw.camera.plausibility import FindingKind, plausibility
from fcw.camera.points import PARAMETER_COUNT
from fcw.camera.solve import exact_solution
from fcw.camera.straight import LEVEL
from fcw.camera.uncertainty import TARGET_DISTANCES_M, best_next_click, camera_sigmas
from fcw.logs.overlay import ROW_DISTANCES_M
from fcw.units import FEET_PER_METRE, distance_text, pitch_text

LEAST_RESIDUAL_PX = 0.005
"""That is printed as another number than 0."""


def calibration_summary(
    calibration: Calibration, paced: bool = False, causes: Sequence[str] = ()
) -> dict[str, Any]:
    """The result as JSON has it; unbounded distances are None.

    Args:
        calibration: the result.
        paced: its points are said to be dashes.
        causes: what is known to be wrong; warnings of what comes of it follow.
    """

    def bounded(value: float) -> float | None:
        return value if math.isfinite(value) else None

    rows = []
    for distance_m in ROW_DISTANCES_M:
        row_px = calibration.row_at(distance_m)
        low_m, high_m = calibration.distance_interval(row_px)
        rows.append(
            {
                "distance_m": distance_m,
                "row_px": bounded(row_px),
                "low_m": bounded(low_m),
                "high_m": bounded(high_m),
            }
        )
    findings = plausibility(calibration, paced=paced)
    if causes:  # they need no guess
        findings = tuple(f for f in findings if f.kind is not FindingKind.CAUSE or f.suspicion)
    proposals = [finding.offset for finding in findings if finding.offset]
    next_click = best_next_click(calibration)
    camera = calibration.camera
    return {
        "pitch_rad": camera.pitch_rad,
        "focal_y_px": camera.focal_y_px,
        "principal_row_px": camera.principal_row_px,
        "horizon_row_px": camera.horizon_row_px,
        "principal_column_px": camera.principal_column_px,
        "field_of_view_rad": calibration.field_of_view_rad,
        "height_m": camera.height_m,
        "reference_offset_m": calibration.reference_offset_m,
        "image_size": asdict(calibration.image_size),
        "sigmas": asdict(camera_sigmas(calibration)),
        "rows": rows,
        "points": [asdict(point) for point in calibration.points],
        "rectangles": [asdict(rectangle) for rectangle in calibration.rectangles],
        "residuals_px": list(calibration.residuals_px),
        "warnings": [*causes, *(finding.text for finding in findings)],
        "exact": _exact(calibration),
        "orientation": asdict(calibration.orientation),
        "lens": None if calibration.lens is None else asdict(calibration.lens),
        "tape_error": calibration.tape_error,
        "next_click": next_click and asdict(next_click),
        "proposed_reference_offset": asdict(proposals[0]) if proposals else None,
    }


def _exact(calibration: Calibration) -> dict[str, float] | None:
    """The paper's closed solution of three points; None of more or fewer."""
    exact = exact_solution(calibration)
    if exact is None:
        return None
    camera = exact.camera
    return {
        "pitch_rad": camera.pitch_rad,
        "focal_y_px": camera.focal_y_px,
        "principal_row_px": camera.principal_row_px,
        "horizon_row_px": camera.horizon_row_px,
    }


def print_report(
    calibration: Calibration, saved: Path | None, console: Console, imperial: bool, taped: bool = True
) -> None:
    """Print the result for a person.

    Args:
        calibration: the result.
        saved: its file, where there is one.
        console: where to.
        imperial: distances in feet.
        taped: whether somebody tapes distances, and so is told where one more helps most.
    """

    def line(text: str) -> None:
        console.print(text, highlight=False, soft_wrap=not console.is_terminal)

    for text in _camera_lines(calibration):
        line(text)
    line("Pitch, focal length and principal row trade off against each other; judge by the distances:")
    console.print(_distance_table(calibration, imperial))
    for text in (_fit_line(calibration), _next_click_line(calibration, imperial) if taped else ""):
        if text:
            line(text)
    line(f"saved {saved}" if saved is not None else "not saved; save it with --save FILE")


def _camera_lines(calibration: Calibration) -> Iterator[str]:
    """How the camera looks, and its lens, each with its standard deviation."""
    camera, sigmas = calibration.camera, camera_sigmas(calibration)
    yield (
        f"pitch {pitch_text(camera.pitch_rad, sigmas.pitch_rad)} "
        f"({camera.pitch_rad:.6g} rad), "
        f"focal length {camera.focal_y_px:.6g} ± {sigmas.focal_y_px:.3g} px "
        f"(horizontal field of view {math.degrees(calibration.field_of_view_rad):.1f} degrees)"
    )
    yield (
        f"principal row {camera.principal_row_px:.6g} ± {sigmas.principal_row_px:.3g}, "
        f"horizon row {camera.horizon_row_px:.6g} ± {sigmas.horizon_row_px:.3g}"
    )
    turned = calibration.orientation
    if turned != LEVEL:
        yield (
            f"yaw {_turn_text(turned.yaw_rad, turned.yaw_sigma_rad, 'left', 'right')}, roll "
            f"{_turn_text(turned.roll_rad, turned.roll_sigma_rad, 'right', 'left')}; rows are those of the "
            "straightened picture"
        )


def _distance_table(calibration: Calibration, imperial: bool) -> Table:
    """Rows of some distances, and the interval of each."""

    def length(distance_m: float) -> str:
        return f"{distance_m * FEET_PER_METRE:.0f} ft" if imperial else f"{distance_m:.1f} m"

    table = Table("distance", "row", "two times in three", "±", box=None, pad_edge=False)
    for distance_m in ROW_DISTANCES_M:
        row_px = calibration.row_at(distance_m)
        low_m, high_m = calibration.distance_interval(row_px)
        bounded = math.isfinite(high_m)
        outside = "" if row_px <= calibration.image_size.height - 0.5 else " (below the picture)"
        table.add_row(
            distance_text(distance_m, imperial),
            f"{row_px:.1f}{outside}",
            f"{length(low_m)} to {length(high_m) if bounded else 'unbounded'}",
            f"{(high_m - low_m) / 2 / distance_m:.1%}" if bounded else "",
        )
    return table


def _fit_line(calibration: Calibration) -> str:
    """How well the solution meets the points, or that it must meet them; empty without points."""
    if not calibration.points:
        return ""
    known = len(calibration.points) + calibration.priors.count + calibration.assumed.count
    known += 2 * (calibration.lens is not None)  # its focal length and its principal row
    # What else was told, as lane lines, shows in the residuals alone.
    missed = any(abs(residual) >= LEAST_RESIDUAL_PX for residual in calibration.residuals_px)
    if known <= PARAMETER_COUNT and not missed:
        return (
            "The solution meets the points exactly, as it would any three: that says nothing about its "
            "quality."
        )
    residuals = ", ".join(
        f"{point} {residual:+.2f}"
        for point, residual in zip(calibration.points, calibration.residuals_px, strict=True)
    )
    return f"residuals in px (clicked row minus row of the solution): {residuals}"


def _next_click_line(calibration: Calibration, imperial: bool) -> str:
    """Where one more point helps most; empty where none is proposed."""
    next_click = best_next_click(calibration)
    if next_click is None:
        return ""
    nearest, farthest = (distance_text(TARGET_DISTANCES_M[end], imperial) for end in (0, -1))
    return (
        f"One more point helps most at {distance_text(next_click.distance_m, imperial)}, near row "
        f"{next_click.row_px:.0f}: the error of distances from {nearest} to {farthest} would fall from "
        f"{next_click.error_before:.1%} to {next_click.error_after:.1%}."
    )


def _turn_text(angle_rad: float, sigma_rad: float, side: str, other: str) -> str:
    """An angle, positive to `side`, as people say it."""
    angle, sigma = abs(math.degrees(angle_rad)), math.degrees(sigma_rad)
    return f"{angle:.2f} ± {sigma:.2f} degrees to the {other if angle_rad < 0 else side}"
