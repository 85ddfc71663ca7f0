"""What every lens has."""

import math

from fcw.camera.calibration import Gaussian, Priors
from fcw.camera.prior_sigmas import (
    PRINCIPAL_ROW_SIGMA_HEIGHTS,
    UNKNOWN_FIELD_OF_VIEW_DEG,
    UNKNOWN_FIELD_OF_VIEW_SIGMA_DEG,
    USUAL_FIELD_OF_VIEW_DEG,
    USUAL_FIELD_OF_VIEW_SIGMA_DEG,
)
from fcw.frame import ImageSize


def across_picture(along_longer_side: Gaussian, image_size: ImageSize) -> Gaussian:
    """A field of view from side to side in radians, where one is known along the longer side of the picture.

    Kinds of cameras are told of pictures that are wider than high; a telephone that is held upright sees so
    much from top to bottom.
    """
    view = along_longer_side
    if image_size.width >= image_size.height:
        return view
    part, tangent = image_size.width / image_size.height, math.tan(view.value / 2)
    slope = part * (1 + tangent**2) / (1 + (part * tangent) ** 2)
    return Gaussian(2 * math.atan(part * tangent), slope * view.sigma)


def usual_lens(
    image_size: ImageSize,
    stated: Priors = Priors(),  # noqa: B008 - immutable
    marked: bool = True,
) -> Priors:
    """What every lens has, of all that is not stated: an axis near the middle, a plausible field of view.

    Args:
        image_size: of the picture.
        stated: what is said of the lens.
        marked: whether distances are marked; where not, the field of view decides all of them.
    """
    field_of_view = principal_row = None
    if stated.field_of_view_rad is None:
        value_deg, sigma_deg = (
            (USUAL_FIELD_OF_VIEW_DEG, USUAL_FIELD_OF_VIEW_SIGMA_DEG)
            if marked
            else (UNKNOWN_FIELD_OF_VIEW_DEG, UNKNOWN_FIELD_OF_VIEW_SIGMA_DEG)
        )
        along_longer = Gaussian(math.radians(value_deg), math.radians(sigma_deg))
        field_of_view = across_picture(along_longer, image_size)
    if stated.principal_row_px is None:
        middle_px = (image_size.height - 1) / 2
        principal_row = Gaussian(middle_px, PRINCIPAL_ROW_SIGMA_HEIGHTS * image_size.height)
    return Priors(field_of_view, principal_row)
