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
        return "Say how high the camera is above the road, or choose your kind of vehicle."
    if document.field_of_view is None:
        return "Say how much the lens sees from side to side, or choose your kind of camera."
    if document.horizon is None and None in document.lane_lines:
        return "Take the horizon that the drive shows or the vehicles ahead as rulers, or drag the horizon."
    return "Switch the lens, its axis and the horizon or the lane lines on: all are needed without points."


def hint_lane(document: Document) -> str:
    """What to do next with a lane of known width."""
    if None in document.lane_lines:
        return "Go to a straight stretch and find or draw both lane lines."
    if document.lane_width is None:
        return "Say how far the lane lines are apart."
    return hint_clip(document)


def hint_speed(document: Document) -> str:
    """What to do next with a known speed."""
    if document.horizon is None and None in document.lane_lines:
        return "Take the horizon that the drive shows, or drag it; then say the mean speed."
    if document.speed is None:
        return "Say the mean speed over the stretch that was looked at."
    if document.height_m is None:
        return hint_clip(document)
    return "Switch the speed, the lens's axis and the horizon on: all are needed without points."


def hint_vehicles(document: Document) -> str:
    """What to do next with vehicles as rulers."""
    if not document.vehicles:
        return "Let the program look for the vehicles ahead, and take them as rulers."
    return hint_clip(document)


def hint_plates(document: Document) -> str:
    """What to do next with number plates."""
    begun = document.plates[len(document.whole_plates) :]
    if begun:
        return PLATE_CLICKS[len(begun[0])]
    if not document.plates:
        return "Click one end of a number plate; where the picture is small, a first click zooms in."
    if len(document.plates) < FEWEST_PLATES:
        return "Click one end of the plate of another vehicle, nearer or farther."
    if document.field_of_view is None:
        return "Say how much the lens sees from side to side, or choose your kind of camera."
    return "Switch the lens and its axis on: both are needed with plates alone."


def hint_dashes(document: Document) -> str:
    """What to do first with lane dashes."""
    return "Choose your country's dashes in the list, or type how far apart they are."


def hint_rectangle(document: Document) -> str:
    """What to do next with a rectangle on the road."""
    clicked = len(document.rectangles[-1].corners_px) if document.rectangles else 0
    if clicked == 0:
        return "Click a corner of a rectangle that is painted on the road, such as a parking bay."
    if clicked < CORNERS:
        return f"Click its next corner; {CORNERS - clicked} to go."
    return "Say what it is or type one of its sides; with the camera's height, none is needed."


HINTS = {
    CLIP: hint_clip,
    LANE: hint_lane,
    SPEED: hint_speed,
    VEHICLES: hint_vehicles,
    DASHES: hint_dashes,
    RECTANGLE: hint_rectangle,
    PLATES: hint_plates,
}
