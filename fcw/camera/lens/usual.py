"""What every lens has."""

import math

from fcw.camera.calibration import Gaussian, Priors
from fcw.camera.prior_sigmas import (
    PRINCIPAL_ROW_SIGMA_HEIGHTS,
    USUAL_FIELD_OF_VIEW_DEG,
    USUAL_FIELD_OF_VIEW_SIGMA_DEG,
)
from fcw.frame import ImageSize


def usual_lens(image_size: ImageSize, stated: Priors = Priors()) -> Priors:  # noqa: B008 - immutable
    """What every lens has, of all that is not stated: an axis near the middle, a plausible field of view."""
    field_of_view = principal_row = None
    if stated.field_of_view_rad is None:
        field_of_view = Gaussian(
            math.radians(USUAL_FIELD_OF_VIEW_DEG), math.radians(USUAL_FIELD_OF_VIEW_SIGMA_DEG)
        )
    if stated.principal_row_px is None:
        middle_px = (image_size.height - 1) / 2
        principal_row = Gaussian(middle_px, PRINCIPAL_ROW_SIGMA_HEIGHTS * image_size.height)
    return Priors(field_of_view, principal_row)
