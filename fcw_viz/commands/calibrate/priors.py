"""What the command line says of the camera besides points."""

import math

from fcw.camera.calibration import Gaussian, Priors
from fcw.camera.lens.files import read_lens
from fcw.camera.lens.model import Lens
from fcw.camera.prior_sigmas import (
    FIELD_OF_VIEW_SIGMA_DEG,
    HORIZON_ROW_SIGMA_PX,
    PRINCIPAL_ROW_SIGMA_HEIGHTS,
)
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.commands.calibrate.options import CalibrateCommand

SMALLEST, LARGEST = 1e-6, 1e6
SMALLEST_FIELD_OF_VIEW_DEG = 1.0


def stated_priors(command: CalibrateCommand, size: ImageSize) -> Priors:
    """The field of view, the principal row and the horizon that are stated, for pictures of a size.

    Raises:
        UserError: one of them is not `VALUE` or `VALUE:SIGMA`.
    """
    degrees = _parse("--field-of-view", command.field_of_view, FIELD_OF_VIEW_SIGMA_DEG)
    return Priors(
        degrees and Gaussian(math.radians(degrees.value), math.radians(degrees.sigma)),
        _parse("--principal-row", command.principal_row, PRINCIPAL_ROW_SIGMA_HEIGHTS * size.height),
        _parse("--horizon-row", command.horizon_row, HORIZON_ROW_SIGMA_PX),
    )


def stated_lens(command: CalibrateCommand, size: ImageSize) -> Lens | None:
    """The lens that is stated, for pictures of a size; None where none is.

    Raises:
        UserError: its file is no lens, or of pictures of another aspect ratio.
    """
    if command.lens is None:
        return None
    lens = read_lens(command.lens)
    try:
        return lens.for_image_size(size)
    except UserError as error:
        raise UserError(f"--lens {command.lens}: {error}") from None


def _parse(option: str, text: str | None, default_sigma: float) -> Gaussian | None:
    """A value with its standard deviation; None for None."""
    if text is None:
        return None
    try:
        value, *rest = (float(part) for part in text.split(":"))
        (sigma,) = rest or (default_sigma,)
    except ValueError:
        raise UserError(f"{option} {text}: expected VALUE or VALUE:SIGMA, for example 65 or 65:3") from None
    if abs(value) > LARGEST or sigma > LARGEST or 0 < sigma < SMALLEST:
        raise UserError(f"{option} {text}: expected numbers of a plausible size, for example 65 or 65:3")
    if option == "--field-of-view" and 0 < value < SMALLEST_FIELD_OF_VIEW_DEG:
        raise UserError(f"{option} {text}: expected at least {SMALLEST_FIELD_OF_VIEW_DEG:g} degrees")
    return Gaussian(value, sigma)
