"""The calibration file: versioned YAML that a person can read, written whole or not at all."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import yaml

from fcw.bounded.files import MalformedError, read_text
from fcw.bounded.formats import MOST_YAML_BYTES, yaml_value
from fcw.bounded.pictures import LONGEST_SIDE_PX
from fcw.camera.calibration import Calibration, GroundRectangle, NumberPlate, Priors
from fcw.camera.file_fields import PRIOR_FIELDS, Fields
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.lens.model import Lens
from fcw.camera.plausibility import plausibility
from fcw.camera.points import LARGEST_TAPE_ERROR, LEAST_HEIGHT_M, MOST_M
from fcw.camera.straight import LEVEL, Undone
from fcw.errors import UserError
from fcw.files import CALIBRATION, check_kind, is_kind, write_whole
from fcw.frame import ImageSize
from fcw.units import pitch_text

FORMAT_VERSION, STRAIGHT_VERSION = 3, 4
"""The second is that of a log: its calibration is of straight pictures and says what was undone of them."""
READABLE_VERSIONS = (1, 2, 3, 4)
"""1 knew neither an error of the tape nor what every lens has, 2 no rectangles and plates; all stays so."""
VERSION_FIELD = "fcw_calibration_version"
RESIDUAL_TOLERANCE_PX = 1e-6
"""Points, camera and residuals of one calibration agree far better; a file edited by hand does not."""


class _Dumper(yaml.SafeDumper):
    """Takes NumPy's scalars for the numbers that they are."""


_Dumper.add_multi_representer(float, lambda dumper, value: dumper.represent_float(float(value)))
_Dumper.add_multi_representer(np.integer, lambda dumper, value: dumper.represent_int(int(value)))

CALIBRATION_SUFFIX = ".calibration.yaml"
"""Of a drive's own calibration, after the drive's name."""
FOLDER_CALIBRATION = "calibration.yaml"
"""Of all drives of a folder that have none of their own."""


def default_path(source: Path) -> Path:
    """`<name>.calibration.yaml` beside a video or folder: where it is saved by default."""
    name = source.stem if source.is_file() else source.resolve().name
    return source.parent / f"{name}{CALIBRATION_SUFFIX}"


def calibration_path(source: Path) -> Path:
    """Where the calibration of a video or folder is, if nobody names one.

    The first of these that exists: its own (`default_path`), `calibration.yaml` in the folder, and
    `calibration.yaml` beside the source; others than this program's, as ROS has them, do not count. If there
    is none, its own.
    """
    own = default_path(source)
    if own.is_file():
        return own
    shared = (source / FOLDER_CALIBRATION, source.parent / FOLDER_CALIBRATION)
    return next((path for path in shared if is_kind(path, CALIBRATION[1])), own)


def calibration_text(calibration: Calibration, warnings: Sequence[str] | None = None) -> str:
    """The file's text; numbers keep all their digits.

    Args:
        calibration: to be written.
        warnings: what speaks against it, where more is known than the calibration itself tells.
    """
    camera = calibration.camera
    comment = (
        "# Camera calibration of fcw. Distances in metres along the ground, from the reference;\n"
        "# rows and columns in pixels, the centre of the top-left pixel being (0, 0).\n"
        f"# Pitch {pitch_text(camera.pitch_rad)}, horizontal field of view "
        f"{math.degrees(calibration.field_of_view_rad):.1f} degrees, "
        f"horizon at row {camera.horizon_row_px:.1f}.\n"
    )
    # Whoever opens an implausible calibration later is told as whoever made it was.
    if warnings is None:
        warnings = [finding.text for finding in plausibility(calibration)]
    comment += "".join(f"# Warning: {' '.join(warning.split())}\n" for warning in warnings)
    document = {
        VERSION_FIELD: FORMAT_VERSION if calibration.undone is None else STRAIGHT_VERSION,
        "image_size": {"width": calibration.image_size.width, "height": calibration.image_size.height},
        "height_m": camera.height_m,
        "reference_offset_m": calibration.reference_offset_m,
        "row_sigma_px": calibration.row_sigma_px,
        "tape_error": calibration.tape_error,
        "points": [
            {"distance_m": point.distance_m, "row_px": point.row_px, "column_px": point.column_px}
            for point in calibration.points
        ],
        "residuals_px": list(calibration.residuals_px),
        "rectangles": [_rectangle_section(rectangle) for rectangle in calibration.rectangles],
        "plates": [_plate_section(plate) for plate in calibration.plates],
        "priors": _priors_section(calibration.priors),
        "assumed": _priors_section(calibration.assumed),
        "camera": {
            "pitch_rad": camera.pitch_rad,
            "focal_y_px": camera.focal_y_px,
            "principal_row_px": camera.principal_row_px,
            "principal_column_px": camera.principal_column_px,
        },
        **_turn_section(calibration),
        "row_covariance": {
            "support_distances_m": list(calibration.support_distances_m),
            "covariance_px2": [list(row) for row in calibration.covariance],
        },
    }
    if calibration.undone is not None:
        document["undone"] = _turn_section(calibration.undone)
    return comment + yaml.dump(document, Dumper=_Dumper, sort_keys=False, default_flow_style=None)


def _turn_section(turned: Calibration | Undone) -> dict[str, object]:
    return {
        "orientation": asdict(turned.orientation),
        "lens": None if turned.lens is None else _lens_section(turned.lens),
    }


def _priors_section(priors: Priors) -> dict[str, dict[str, float] | None]:
    return {
        name: None if prior is None else {"value": prior.value, "sigma": prior.sigma}
        for name in PRIOR_FIELDS
        for prior in (getattr(priors, name),)
    }


def _rectangle_section(rectangle: GroundRectangle) -> dict[str, object]:
    return {
        "corners_px": [list(corner) for corner in rectangle.corners_px],
        "first_side_m": None if rectangle.first_side_m is None else asdict(rectangle.first_side_m),
        "second_side_m": None if rectangle.second_side_m is None else asdict(rectangle.second_side_m),
        "along": rectangle.along,
    }


def _plate_section(plate: NumberPlate) -> dict[str, object]:
    return {"places_px": [list(place) for place in plate.places_px], "width_m": asdict(plate.width_m)}


def _lens_section(lens: Lens) -> dict[str, object]:
    return {
        "model": lens.model,
        "focal_x_px": lens.focal_x_px,
        "focal_y_px": lens.focal_y_px,
        "column_px": lens.column_px,
        "row_px": lens.row_px,
        "coefficients": list(lens.coefficients),
    }


def write_calibration(calibration: Calibration, path: Path, warnings: Sequence[str] | None = None) -> None:
    """Write the calibration file, whole or not at all; see `calibration_text`.

    Raises:
        UserError: the file cannot be written there, or is there already and is no calibration, or it would
            hold a number that is none of a camera, so that nobody could read it again.
    """
    check_kind(path, *CALIBRATION)
    text = calibration_text(calibration, warnings)
    try:
        parse_calibration(text, str(path))
    except UserError as error:
        raise UserError(
            f"{error}; not saved: check the marks, the lens and everything else you gave"
        ) from error
    write_whole(path, text)


def read_calibration(path: Path) -> Calibration:
    """Read a calibration file.

    Raises:
        UserError: the file is missing, of another version, or a field of it is not as expected.
    """
    try:
        text = read_text(path, MOST_YAML_BYTES)
    except FileNotFoundError:
        raise UserError(f"{path}: no such calibration file; make one with `fcw calibrate`") from None
    except (OSError, MalformedError) as error:
        raise UserError(f"{path}: cannot read the calibration ({error})") from error
    return parse_calibration(text, str(path))


def parse_calibration(text: str, name: str) -> Calibration:
    """The calibration in a file's text.

    Args:
        text: what `calibration_text` gave.
        name: of the file, for messages.

    Raises:
        UserError: naming file, field, value and what was expected.
    """
    version, fields = _versioned(text, name)
    size = fields.section("image_size")
    image_size = ImageSize(size.count("width"), size.count("height"))
    size.finish()
    height_m = fields.number("height_m", positive=True, at_least=LEAST_HEIGHT_M, at_most=MOST_M)
    offset_m = fields.number("reference_offset_m", at_least=0.0, at_most=MOST_M)
    row_sigma_px = fields.number("row_sigma_px", at_least=0.0, at_most=LONGEST_SIDE_PX)
    points = fields.points("points")
    residuals = fields.numbers("residuals_px", len(points))
    priors = fields.priors("priors")
    assumed, tape_error, orientation, lens, rectangles, plates = Priors(), 0.0, LEVEL, None, (), ()
    undone = None
    if version > 1:
        assumed = fields.priors("assumed")
        tape_error = fields.number("tape_error", at_least=0.0, at_most=LARGEST_TAPE_ERROR)
        orientation = fields.orientation("orientation")
        lens = fields.lens("lens", image_size)
    if version > 2:
        rectangles = fields.rectangles("rectangles")
        plates = fields.plates("plates")
    if version == STRAIGHT_VERSION:
        section = fields.section("undone")
        undone = Undone(section.orientation("orientation"), section.lens("lens", image_size))
        section.finish()
    section = fields.section("camera")
    camera = GroundPlaneCamera(
        section.number("pitch_rad", above=-math.pi / 2, below=math.pi / 2),
        section.focal_length("focal_y_px"),
        section.number("principal_row_px"),
        height_m,
        section.number("principal_column_px"),
    )
    section.finish()
    section = fields.section("row_covariance")
    support = section.support_distances("support_distances_m", offset_m + camera.pole_m)
    covariance = section.covariance("covariance_px2")
    section.finish()
    fields.finish()
    calibration = Calibration(
        camera,
        image_size,
        points,
        row_sigma_px,
        support,
        covariance,
        offset_m,
        priors,
        residuals,
        assumed,
        tape_error,
        orientation,
        lens,
        rectangles,
        plates,
        undone,
    )
    _check_residuals(calibration, name)
    return calibration


def _versioned(text: str, name: str) -> tuple[int, Fields]:
    """The version of a file, and its other fields."""
    try:
        document = yaml_value(text)
    except MalformedError as error:
        raise UserError(f"{name}: not a YAML file ({error}); make one with `fcw calibrate`") from error
    if not isinstance(document, dict) or VERSION_FIELD not in document:
        raise UserError(
            f"{name}: not a calibration of fcw: the field {VERSION_FIELD} is missing; "
            "make one with `fcw calibrate`"
        )
    version = document[VERSION_FIELD]
    if version not in READABLE_VERSIONS:
        readable = ", ".join(map(str, READABLE_VERSIONS))
        raise UserError(
            f"{name}: {VERSION_FIELD} is {version!r}, this program reads {readable}; "
            "calibrate again with `fcw calibrate`, or use the program that wrote the file"
        )
    fields = Fields(name, "", document)
    fields.take(VERSION_FIELD)
    return version, fields


def _check_residuals(calibration: Calibration, name: str) -> None:
    """See that points and camera are still those of one calibration."""
    told = zip(calibration.points, calibration.straight_rows_px, calibration.residuals_px, strict=True)
    for index, (point, row_px, residual) in enumerate(told):
        expected = row_px - calibration.camera.row_at(point.distance_m + calibration.reference_offset_m)
        if not abs(expected - residual) <= RESIDUAL_TOLERANCE_PX:
            raise UserError(
                f"{name}: residuals_px[{index}] is {residual:g}, but the point {point} lies {expected:g} px "
                "from the row of the camera in the file: it was changed after calibrating; "
                "run `fcw calibrate` again with the points"
            )
