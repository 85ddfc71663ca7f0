"""What the check tools draw over the picture: vehicles with their distances, and a measured length."""

from collections.abc import Sequence

from fcw.logs.overlay import OTHER_TRACK_COLOR, Rgb
from fcw_viz.calibrate_app.document.numbers_text import interval_text
from fcw_viz.calibrate_app.drawing.drawing import MEASURE_COLOR
from fcw_viz.calibrate_app.frame_detector import RangedVehicle
from fcw_viz.calibrate_app.measure import GroundMeasurement, distance_words, point_words
from fcw_viz.page.picture.lines import LabelledLine, Place, box_line

VEHICLE_COLOR: Rgb = OTHER_TRACK_COLOR


def vehicle_words(vehicle: RangedVehicle, imperial: bool) -> str:
    """`38 m  34–42`."""
    if vehicle.distance_m is None:
        return "cut off by the picture's edge"
    interval = interval_text(vehicle.low_m, vehicle.high_m, imperial)
    return f"{distance_words(vehicle.distance_m, interval, imperial)}  {interval}"


def vehicle_lines(vehicles: Sequence[RangedVehicle], imperial: bool) -> tuple[LabelledLine, ...]:
    """Boxes with distances; the words above the box, else below, else beside it."""
    return tuple(
        box_line(vehicle.box, VEHICLE_COLOR, vehicle_words(vehicle, imperial)) for vehicle in vehicles
    )


def length_lines(
    start: GroundMeasurement, end: GroundMeasurement, imperial: bool
) -> tuple[LabelledLine, ...]:
    """The line from one measured point to the next, with the words of the first."""
    column_px, row_px = start.column_px, start.row_px
    places = (
        Place(column_px, row_px, 0.0, 0.5),
        Place(column_px, row_px, 1.0, 0.5),
        Place(column_px, row_px, 0.0, -0.5),
        Place(column_px, row_px, 1.0, -0.5),
    )
    ends = ((column_px, row_px), (end.column_px, end.row_px))
    return (LabelledLine(ends, MEASURE_COLOR, point_words(start, imperial), places),)
