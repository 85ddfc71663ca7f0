"""What to do next, by the way that was chosen."""

from fcw.camera.joint.rectangle import CORNERS
from fcw_viz.calibrate_app.document.document import FEWEST_PLATES, Document
from fcw_viz.calibrate_app.document.ways.ways import (
    CLIP,
    DASHES,
    LANE,
    PLATES,
    RECTANGLE,
    SPEED,
    VEHICLES,
)

PLATE_CLICKS = {
    1: "Click the other end of the plate.",
    2: "Click where a rear tyre of that vehicle meets the road.",
}


def hint_clip(document: Document) -> str:
    """What to do next without points."""
    if document.height_m is None:
        return "Type the camera's height above the road, or choose your kind of vehicle."
    if document.field_of_view is None:
        return "Type the field of view, or choose your kind of camera."
    if document.horizon is None and None in document.lane_lines:
        return "Use the horizon that the drive shows, use the vehicles ahead as rulers, or drag the horizon."
    return (
        "Switch on the field of view, the lens axis, and the horizon or the lane lines: without points, "
        "all are needed."
    )


def hint_lane(document: Document) -> str:
    """What to do next with a lane of known width."""
    if None in document.lane_lines:
        return "Go to a straight stretch and find or draw both lane lines."
    if document.lane_width is None:
        return "Type the lane width."
    return hint_clip(document)


def hint_speed(document: Document) -> str:
    """What to do next with a known speed."""
    if document.horizon is None and None in document.lane_lines:
        return "Use the horizon that the drive shows, or drag it; then type the mean speed."
    if document.speed is None:
        return "Type the mean speed over the stretch that was analysed."
    if document.height_m is None:
        return hint_clip(document)
    return "Switch on the speed, the lens axis and the horizon: without points, all are needed."


def hint_vehicles(document: Document) -> str:
    """What to do next with vehicles as rulers."""
    if not document.vehicles:
        return "Let the program look for the vehicles ahead, then use them as rulers."
    return hint_clip(document)


def hint_plates(document: Document) -> str:
    """What to do next with number plates."""
    begun = document.plates[len(document.whole_plates) :]
    if begun:
        return PLATE_CLICKS[len(begun[0])]
    if not document.plates:
        return "Click one end of a number plate. If the picture is small, the first click zooms in."
    if len(document.plates) < FEWEST_PLATES:
        return "Click one end of the plate of another vehicle, nearer or farther."
    if document.field_of_view is None:
        return "Type the field of view, or choose your kind of camera."
    return "Switch on the field of view and the lens axis: with plates alone, both are needed."


def hint_dashes(document: Document) -> str:
    """What to do first with lane dashes."""
    return "Choose your country's dashes in the list, or type their spacing."


def hint_rectangle(document: Document) -> str:
    """What to do next with a rectangle on the road."""
    clicked = len(document.rectangles[-1].corners_px) if document.rectangles else 0
    if clicked == 0:
        return "Click a corner of a rectangle painted on the road, such as a parking bay."
    if clicked < CORNERS:
        return f"Click its next corner; {CORNERS - clicked} to go."
    return (
        "Choose a standard size, or type one of its sides. If the camera height is known, neither is needed."
    )


HINTS = {
    CLIP: hint_clip,
    LANE: hint_lane,
    SPEED: hint_speed,
    VEHICLES: hint_vehicles,
    DASHES: hint_dashes,
    RECTANGLE: hint_rectangle,
    PLATES: hint_plates,
}
