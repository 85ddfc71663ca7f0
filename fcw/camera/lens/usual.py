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
        field_of_view = Gaussian(math.radians(value_deg), math.radians(sigma_deg))
    if stated.principal_row_px is None:
        middle_px = (image_size.height - 1) / 2
        principal_row = Gaussian(middle_px, PRINCIPAL_ROW_SIGMA_HEIGHTS * image_size.height)
    return Priors(field_of_view, principal_row)
