"""Number plates as rulers: their width in metres at the distance of their vehicle.

The width of a plate is known to 1 %, that of a vehicle only to some per cent, but a plate has far fewer
pixels. It is on the rear face, above the road. The row of a rear tyre gives the distance at which the tyre
meets the road, and the rear face is nearer by the overhang.
"""

import math
from collections.abc import Sequence

import numpy as np

from fcw.camera.calibration import Gaussian, NumberPlate
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.points import OUTSIDE_LIMIT
from fcw.errors import UserError
from fcw.frame import ImageSize

PLACES = 3
"""Clicked places of each plate: its two ends, and where a tyre meets the road."""
PLATE_SIGMA_M = 0.004
"""Standard deviation of a plate's width in a known country: rims are bent, and ends are rounded."""
PLATE_WIDTHS_M = {"eu": 0.520, "us": 0.3048, "jp": 0.330, "au": 0.372}
"""Widths of the ordinary plates for cars, by law: EU and Britain; USA, Canada and Mexico; Japan;
Australia."""
OVERHANG_M = Gaussian(0.75, 0.25)
"""Distance from the rear edge of a tyre's contact back to the plate. In drawings of common cars, bumpers are
0.6 to 1.1 m behind the axle; this is an estimate, not a count."""
TURN_SIGMA = 0.01
"""Relative error of the width from the angle of the vehicle: at 8 degrees it looks 1 % narrower."""
NARROWEST_PX = 4.0
NARROWEST_M, WIDEST_M = 0.1, 1.0
LOWEST_M, HIGHEST_M = 0.3, 6.0
"""Range of camera heights at which a fit starts, even if plates were clicked badly."""


def check_plate(plate: NumberPlate, image_size: ImageSize) -> None:
    """Refuse places that are no plate above a road, and widths that none has.

    Raises:
        UserError: naming what is wrong, and what to do.
    """
    places = np.array(plate.places_px, float)
    if places.shape != (PLACES, 2) or not np.isfinite(places).all():
        raise UserError(
            f"number plate: {len(plate.places_px)} places, expected two ends and where a tyre stands"
        )
    size = np.array((image_size.width, image_size.height))
    if ((places < -OUTSIDE_LIMIT * size) | (places > 2 * size)).any():
        raise UserError(
            f"number plate: a place is far outside the picture of {image_size}; click in the picture"
        )
    ends, contact_row_px = places[:2], places[2, 1]
    if math.dist(*ends) < NARROWEST_PX:
        raise UserError(
            f"number plate: it is {math.dist(*ends):.1f} px wide, too narrow to tell; take a nearer one"
        )
    if contact_row_px <= ends[:, 1].max():
        raise UserError(
            f"number plate: the tyre meets the road at row {contact_row_px:g}, above the plate at row "
            f"{ends[:, 1].max():g}; give the two ends of the plate, then where a rear tyre stands below it"
        )
    width = plate.width_m
    if not (NARROWEST_M <= width.value <= WIDEST_M and width.sigma > 0):
        raise UserError(
            f"number plate: width {width.value:g} ± {width.sigma:g} m: expected {NARROWEST_M:g} to "
            f"{WIDEST_M:g} m, and an error above 0"
        )


def horizons_by_plates(
    plates: Sequence[NumberPlate], height_m: float, focal_px: float
) -> list[tuple[float, float]]:
    """Row of the horizon and height of the camera from which a fit may start; none without plates.

    Where the horizon of the usual camera is below a tyre, its plate would not pull it up. As far as the plate
    is wide, the tyre stands in the row B + f h / d: in the middle of all for the height that is believed, and
    for that which fits two plates and more best.
    """
    if not plates:
        return []
    places = np.array([plate.places_px for plate in plates], float)
    widths_px = np.maximum(np.linalg.norm(places[:, 1] - places[:, 0], axis=1), 1.0)
    tyres_m = focal_px * np.array([plate.width_m.value for plate in plates]) / widths_px + OVERHANG_M.value
    slopes, rows_px = focal_px / tyres_m, places[:, 2, 1]
    found = [(float(np.median(rows_px - slopes * height_m)), height_m)]
    off = slopes - slopes.mean()
    fitted_m = float(off @ rows_px / (off @ off)) if off.any() else 0.0
    if LOWEST_M < fitted_m < HIGHEST_M:
        found.append((float(rows_px.mean() - slopes.mean() * fitted_m), fitted_m))
    return found


def plate_misfits(
    plates: Sequence[NumberPlate], places: FloatArray, camera: GroundPlaneCamera, click_px: float
) -> FloatArray:
    """(N,) in sigmas: the width of each plate where its vehicle stands, against what it is.

    Args:
        plates: as they were clicked.
        places: (N, 3, 2) columns and rows of their ends and contacts in the straight picture.
        camera: of it.
        click_px: standard deviation of a clicked column or row.
    """
    widths_px = np.maximum(np.linalg.norm(places[:, 1] - places[:, 0], axis=1), 1.0)
    below_px = np.maximum(places[:, 2, 1] - camera.horizon_row_px, 1.0)
    tyres_m = camera.distance_at(camera.horizon_row_px + below_px)
    rears_m = np.maximum(tyres_m - OVERHANG_M.value, 0.5)
    rows = (places[:, :2, 1].mean(axis=1) - camera.principal_row_px) / camera.focal_y_px
    depths_m = rears_m / (math.cos(camera.pitch_rad) - rows * math.sin(camera.pitch_rad))
    seen_m = widths_px * depths_m / camera.focal_y_px
    stated_m = np.array([plate.width_m.value for plate in plates])
    width_parts = np.array([plate.width_m.sigma for plate in plates]) / stated_m
    tyre_sigmas_m = click_px * (tyres_m + camera.pole_m) / below_px
    sigmas = np.sqrt(
        width_parts**2
        + TURN_SIGMA**2
        + 2 * (click_px / widths_px) ** 2
        + (np.hypot(tyre_sigmas_m, OVERHANG_M.sigma) / rears_m) ** 2
    )
    return np.log(seen_m / stated_m) / sigmas
