"""`fcw calibrate`: from points of the road at known distances to a calibration.

Without `--points` it opens the page that they are clicked on; the rest of this module needs no browser.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

if TYPE_CHECKING:
    from rich.console import Console

    from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
    from fcw.frame import ImageSize

ROW_DISTANCES_M = (5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 80.0)
FIELD_OF_VIEW_SIGMA_DEG = 3.0
"""Data sheets round, state the diagonal, or ignore what stabilisation crops."""
PRINCIPAL_ROW_SIGMA_HEIGHTS = 0.03
"""How far lens and sensor are off centre in ordinary cameras, in picture heights."""
HORIZON_ROW_SIGMA_PX = 2.0
"""How well two straight lane lines extended by eye meet."""


@dataclass(frozen=True, slots=True)
class CalibrateCommand:
    """Calibrate the camera from points of the road at known distances.

    With a source alone it opens a page in the browser, where the points are clicked. Three points are solved
    exactly; more points, and what else is known of the camera, make it better. One point should be far away:
    three near ones leave the far distances open.
    """

    source: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[SOURCE]")] = None
    """Video or MCAP file, picture, or folder of pictures to click in; the calibration is saved beside it."""
    topic: Annotated[str | None, tyro.conf.arg(metavar="TOPIC")] = None
    """Of an MCAP file: the pictures to click in; needed where it has several topics of pictures."""
    points: Annotated[tuple[str, ...], tyro.conf.arg(metavar="D:V[:U] ...")] = ()
    """Points of the road: distance in metres from the reference, row, and column where known."""
    image_size: Annotated[str | None, tyro.conf.arg(metavar="WxH")] = None
    """Size of the picture that the points were clicked in; not needed with a source."""
    height: Annotated[float | None, tyro.conf.arg(metavar="METRES")] = None
    """Height of the camera above the road in metres."""
    reference_offset: float = 0.0
    """Metres from the camera forward to where the distances start (front bumper); 0 is the camera itself."""
    row_sigma: float = 1.0
    """Standard deviation of a clicked row in pixels."""
    field_of_view: Annotated[str | None, tyro.conf.arg(metavar="DEG[:SIGMA]")] = None
    """Horizontal field of view of the whole picture in degrees, known this well (3 degrees unless said)."""
    principal_row: Annotated[str | None, tyro.conf.arg(metavar="PX[:SIGMA]")] = None
    """Row of the lens's axis, mostly the picture's middle (known to 3 % of its height unless said)."""
    horizon_row: Annotated[str | None, tyro.conf.arg(metavar="PX[:SIGMA]")] = None
    """Row of the horizon, e.g. where straight lane lines meet (known to 2 pixels unless said)."""
    save: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Calibration file to write; with a source by default `<name>.calibration.yaml` beside it."""
    export: Annotated[
        tuple[Literal["camera_info", "kalibr"], Path] | None, tyro.conf.arg(metavar="FORMAT FILE")
    ] = None
    """Also write the intrinsics for other tools: `camera_info FILE` (ROS) or `kalibr FILE`."""
    units: Literal["metric", "imperial"] = "metric"
    """Units of the distances shown; input is in metres always."""
    json: bool = False
    """Print the result as JSON on stdout, alone."""
    port: int = 8080
    """Port of the page; the next free one where it is taken."""
    no_open: bool = False
    """Do not open the page in the browser, only print its address."""
    dark: bool = False
    """Begin with the page's dark colours."""


def run_calibrate(command: CalibrateCommand) -> int:
    """Run `fcw calibrate`, with points, or as a page until it is interrupted; returns the exit code.

    Raises:
        UserError: the input is wrong or determines no camera; nothing is saved then.
    """
    import json
    import sys

    from rich.console import Console

    from fcw.camera.export import export_text
    from fcw.camera.file import default_path
    from fcw.files import write_whole

    if command.source is not None and not command.points:
        from fcw_viz.commands.calibrate_page import run_calibrate_page

        return run_calibrate_page(command, command.source)
    calibration = _calibration(command)
    summary = calibration_summary(calibration)
    save = command.save
    if save is None and command.source is not None:
        save = default_path(command.source)
    if save is not None:
        calibration.save(save)
    if command.export is not None:
        file_format, path = command.export
        write_whole(path, export_text(calibration, file_format))

    messages = Console(stderr=True)
    for warning in summary["warnings"]:
        messages.print(
            f"[yellow]warning:[/yellow] {warning}", highlight=False, soft_wrap=not messages.is_terminal
        )
    if command.json:
        result = summary | {"saved": save and str(save)}
        sys.stdout.write(json.dumps(result, indent=2, allow_nan=False) + "\n")
    else:
        _report(calibration, save, Console(), imperial=command.units == "imperial")
    return 0


def calibration_summary(calibration: "Calibration") -> dict[str, Any]:
    """The result as JSON has it; unbounded distances are None."""
    import math
    from dataclasses import asdict

    from fcw.camera.plausibility import plausibility
    from fcw.camera.uncertainty import best_next_click, camera_sigmas

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
    findings = plausibility(calibration)
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
        "residuals_px": list(calibration.residuals_px),
        "warnings": [finding.text for finding in findings],
        "next_click": next_click and asdict(next_click),
        "proposed_reference_offset": asdict(proposals[0]) if proposals else None,
    }


def _calibration(command: CalibrateCommand) -> "Calibration":
    import math

    from fcw.camera.calibration import Gaussian
    from fcw.camera.solve import calibrate
    from fcw.errors import UserError

    if not command.points:
        raise UserError(
            "no points: name a video or a picture to click them in, or give at least three as --points "
            "DISTANCE:ROW ..., for example --points 8:594 15:513 40:455 --image-size 1280x720 --height 1.2"
        )
    if command.height is None:
        raise UserError("--height is missing: the height of the camera's lens above the road, in metres")
    points = tuple(parse_point(text) for text in command.points)
    size = _image_size(command)
    degrees = parse_gaussian("--field-of-view", command.field_of_view, FIELD_OF_VIEW_SIGMA_DEG)
    return calibrate(
        points,
        size,
        command.height,
        command.reference_offset,
        command.row_sigma,
        degrees and Gaussian(math.radians(degrees.value), math.radians(degrees.sigma)),
        parse_gaussian("--principal-row", command.principal_row, PRINCIPAL_ROW_SIGMA_HEIGHTS * size.height),
        parse_gaussian("--horizon-row", command.horizon_row, HORIZON_ROW_SIGMA_PX),
    )


def _image_size(command: CalibrateCommand) -> "ImageSize":
    from fcw.errors import UserError

    stated = None if command.image_size is None else parse_image_size(command.image_size)
    if command.source is None:
        if stated is None:
            raise UserError(
                "--image-size is missing: width and height of the picture that the points were clicked in, "
                "for example --image-size 1280x720"
            )
        return stated
    from fcw.sources import open_source

    size = open_source(command.source, topic=command.topic).image_size
    if stated is not None and stated != size:
        raise UserError(
            f"--image-size {stated}: the pictures of {command.source} are {size}; "
            "click the points in one of them and leave --image-size out"
        )
    return size


def parse_point(text: str) -> "GroundPoint":
    """A point from `DISTANCE:ROW` or `DISTANCE:ROW:COLUMN`.

    Raises:
        UserError: it is not of that form.
    """
    from fcw.camera.calibration import GroundPoint
    from fcw.errors import UserError

    try:
        distance_m, row_px, *rest = (float(part) for part in text.split(":"))
        (column_px,) = rest or (None,)
    except ValueError:
        raise UserError(
            f"--points {text}: expected DISTANCE:ROW or DISTANCE:ROW:COLUMN, metres and pixels, "
            "for example 8:594 or 8:594:640 (a video or folder is named before --points)"
        ) from None
    return GroundPoint(distance_m, row_px, column_px)


def parse_image_size(text: str) -> "ImageSize":
    """An image size from `WIDTHxHEIGHT`.

    Raises:
        UserError: it is not of that form.
    """
    from fcw.errors import UserError
    from fcw.frame import ImageSize

    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError:
        raise UserError(
            f"--image-size {text}: expected WIDTHxHEIGHT in pixels, for example 1280x720"
        ) from None
    return ImageSize(width, height)


def parse_gaussian(option: str, text: str | None, default_sigma: float) -> "Gaussian | None":
    """A value with its standard deviation from `VALUE` or `VALUE:SIGMA`; None for None.

    Raises:
        UserError: it is not of that form.
    """
    from fcw.camera.calibration import Gaussian
    from fcw.errors import UserError

    if text is None:
        return None
    try:
        value, *rest = (float(part) for part in text.split(":"))
        (sigma,) = rest or (default_sigma,)
    except ValueError:
        raise UserError(f"{option} {text}: expected VALUE or VALUE:SIGMA, for example 65 or 65:3") from None
    return Gaussian(value, sigma)


def _report(calibration: "Calibration", saved: Path | None, console: "Console", imperial: bool) -> None:
    """Print the result for a person."""
    import math

    from rich.table import Table

    from fcw.camera.points import PARAMETER_COUNT
    from fcw.camera.uncertainty import TARGET_DISTANCES_M, best_next_click, camera_sigmas
    from fcw.units import FEET_PER_METRE, distance_text

    camera, sigmas = calibration.camera, camera_sigmas(calibration)

    def length(distance_m: float) -> str:
        return f"{distance_m * FEET_PER_METRE:.0f} ft" if imperial else f"{distance_m:.1f} m"

    def line(text: str) -> None:
        console.print(text, highlight=False, soft_wrap=not console.is_terminal)

    line(
        f"pitch {math.degrees(camera.pitch_rad):.2f} ± {math.degrees(sigmas.pitch_rad):.2f} degrees down "
        f"({camera.pitch_rad:.6g} rad), "
        f"focal length {camera.focal_y_px:.6g} ± {sigmas.focal_y_px:.3g} px "
        f"(horizontal field of view {math.degrees(calibration.field_of_view_rad):.1f} degrees)"
    )
    line(
        f"principal row {camera.principal_row_px:.6g} ± {sigmas.principal_row_px:.3g}, "
        f"horizon row {camera.horizon_row_px:.6g} ± {sigmas.horizon_row_px:.3g}"
    )
    line("Pitch, focal length and principal row trade off against each other; judge by the distances:")

    table = Table("distance", "row", "16th to 84th percentile", "half of it", box=None, pad_edge=False)
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
    console.print(table)

    if len(calibration.points) + calibration.priors.count > PARAMETER_COUNT:
        residuals = ", ".join(
            f"{point} {residual:+.2f}"
            for point, residual in zip(calibration.points, calibration.residuals_px, strict=True)
        )
        line(f"residuals in px (clicked row less row of the solution): {residuals}")
    else:
        line("The solution meets the points exactly, as any three do: that says nothing of its quality.")
    next_click = best_next_click(calibration)
    if next_click is not None:
        nearest, farthest = (distance_text(TARGET_DISTANCES_M[end], imperial) for end in (0, -1))
        line(
            f"One more point helps most at {distance_text(next_click.distance_m, imperial)}, near row "
            f"{next_click.row_px:.0f}: the error of distances from {nearest} to {farthest} would fall from "
            f"{next_click.error_before:.1%} to {next_click.error_after:.1%}."
        )
    line(f"saved {saved}" if saved is not None else "not saved; --save FILE keeps it")
