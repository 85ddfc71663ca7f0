"""Reads a lens from the files of other tools: ROS camera_info, Kalibr camchain, OpenCV FileStorage."""

import math
import re
from pathlib import Path
from typing import Any

from fcw.bounded.files import MalformedError, read_text
from fcw.bounded.formats import MOST_YAML_BYTES, yaml_value
from fcw.camera.lens.model import COEFFICIENT_COUNTS, DistortionModel, Lens
from fcw.errors import UserError
from fcw.frame import ImageSize

MODELS: dict[str, DistortionModel] = {
    "plumb_bob": "radtan",
    "rational_polynomial": "radtan",
    "radtan": "radtan",
    "equidistant": "equidistant",
    "fisheye": "equidistant",
}
KINDS = "a camera_info of ROS, a camchain of Kalibr or a camera of OpenCV (YAML)"


def read_lens(path: Path) -> Lens:
    """Read the lens in a file; its fields show which tool wrote it.

    Raises:
        UserError: the file cannot be read, is of none of the three kinds, or one of its fields is wrong.
    """
    try:
        text = read_text(path, MOST_YAML_BYTES)
    except FileNotFoundError:
        raise UserError(f"{path}: no such lens file; name {KINDS}") from None
    except (OSError, MalformedError) as error:
        raise UserError(f"{path}: cannot read the lens ({error})") from error
    # OpenCV writes a directive that YAML does not know, and tags its matrices.
    text = re.sub(r"\A%YAML:1\.0\s*\n(?:---\s*\n)?", "", text).replace("!!opencv-matrix", "")
    try:
        document = yaml_value(text)
    except MalformedError as error:
        raise UserError(f"{path}: not YAML ({error}); name {KINDS}") from error
    if isinstance(document, dict):
        if isinstance(document.get("cam0"), dict):
            return _kalibr(path, document["cam0"])
        if "camera_matrix" in document:
            return _matrices(path, document)
    raise UserError(f"{path}: no camera_matrix and no cam0 in it; name {KINDS}")


def _kalibr(path: Path, camera: dict[str, Any]) -> Lens:
    if camera.get("camera_model") != "pinhole":
        raise _wrong(path, "cam0.camera_model", camera.get("camera_model"), "pinhole")
    model = camera.get("distortion_model")
    intrinsics = _numbers(path, "cam0.intrinsics", camera.get("intrinsics"))
    size = _numbers(path, "cam0.resolution", camera.get("resolution"))
    coefficients = _numbers(path, "cam0.distortion_coeffs", camera.get("distortion_coeffs"))
    if len(intrinsics) != 4:
        raise _wrong(path, "cam0.intrinsics", intrinsics, "four numbers: fu, fv, pu, pv")
    return _lens(path, "cam0.distortion_model", model, intrinsics, coefficients, size)


def _matrices(path: Path, document: dict[str, Any]) -> Lens:
    values = _numbers(path, "camera_matrix", _data(document["camera_matrix"]))
    if len(values) != 9:
        raise _wrong(path, "camera_matrix", values, "nine numbers")
    coefficients = document.get("distortion_coefficients", document.get("dist_coeffs"))
    numbers = _numbers(path, "distortion_coefficients", _data(coefficients))
    size = _numbers(
        path, "image_width, image_height", [document.get(f"image_{n}") for n in ("width", "height")]
    )
    fisheye = document.get("fisheye_model") or document.get("distortion_model") == "fisheye"
    model = "fisheye" if fisheye else document.get("distortion_model", "plumb_bob")
    intrinsics = (values[0], values[4], values[2], values[5])
    return _lens(path, "distortion_model", model, intrinsics, numbers, size)


def _lens(
    path: Path,
    field: str,
    model: object,
    intrinsics: tuple[float, ...],
    coefficients: tuple[float, ...],
    size: tuple[float, ...],
) -> Lens:
    known = MODELS.get(model) if isinstance(model, str) else None
    if known is None:
        raise _wrong(path, field, model, f"one of {', '.join(MODELS)}")
    counts = COEFFICIENT_COUNTS[known]
    # Trailing zeros do not change the lens: OpenCV writes up to fourteen coefficients.
    while len(coefficients) > max(counts) and coefficients[-1] == 0:
        coefficients = coefficients[:-1]
    if len(coefficients) not in counts:
        expected = " or ".join(map(str, counts))
        raise _wrong(path, "distortion coefficients", list(coefficients), f"{expected} numbers of {known}")
    if len(size) != 2 or min(size) < 1 or any(value != int(value) for value in size):
        raise _wrong(path, "image size", list(size), "width and height in pixels")
    if min(intrinsics[:2]) <= 0:
        raise _wrong(path, "focal length", intrinsics[:2], "numbers above 0")
    across, down, column, row = intrinsics
    return Lens(known, across, down, column, row, coefficients, ImageSize(int(size[0]), int(size[1])))


def _data(matrix: object) -> object:
    return matrix.get("data") if isinstance(matrix, dict) else matrix


def _numbers(path: Path, field: str, values: object) -> tuple[float, ...]:
    if isinstance(values, list) and any(isinstance(row, list) for row in values):
        values = [item for row in values for item in (row if isinstance(row, list) else [row])]
    if (
        not isinstance(values, list)
        or not values
        or not all(
            isinstance(v, (int, float)) and not isinstance(v, bool) and math.isfinite(v) for v in values
        )
    ):
        raise _wrong(path, field, values, "a list of finite numbers")
    return tuple(float(value) for value in values)


def _wrong(path: Path, field: str, value: object, expected: str) -> UserError:
    return UserError(f"{path}: {field} is {value!r}, expected {expected}")
