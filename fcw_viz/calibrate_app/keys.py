"""The keys of the page: each does what some button or drag does, and stands in the command palette."""

from functools import partial

from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.page.keys import ZOOM_STEP, Key

NUDGE_PX = 0.1
LARGE_NUDGE_PX = 1.0
NUMBER_KEYS = 9
ARROWS = (("left", -1, 0), ("right", 1, 0), ("up", 0, -1), ("down", 0, 1))


def all_keys() -> list[Key[Desk]]:
    """Every key of the page."""
    keys: list[Key[Desk]] = [
        Key("Undo", "Z", "cmd/ctrl", lambda desk: desk.undo()),
        Key("Redo", "Z", "cmd/ctrl+shift", lambda desk: desk.redo()),
        Key("Redo", "Y", "cmd/ctrl", lambda desk: desk.redo()),
        Key("Save the calibration", "S", "cmd/ctrl", lambda desk: desk.save()),
        Key("Delete the selected point", "delete", None, lambda desk: desk.delete_selected()),
        Key("Delete the selected point", "backspace", None, lambda desk: desk.delete_selected()),
        Key("Switch the selected point on or off", "O", None, lambda desk: desk.switch_selected()),
        Key("Type the distance of the selected point", "D", None, lambda desk: desk.type_distance()),
        Key("Select nothing", "escape", None, lambda desk: desk.escape()),
        Key("Next picture", "N", None, lambda desk: desk.step(1)),
        Key("Previous picture", "P", None, lambda desk: desk.step(-1)),
        Key("Next picture", ".", None, lambda desk: desk.step(1)),
        Key("Previous picture", ",", None, lambda desk: desk.step(-1)),
        Key("Whole picture", "F", None, lambda desk: desk.view.fit()),
        Key("Zoom in", "=", None, lambda desk: desk.zoom(ZOOM_STEP)),
        Key("Zoom in", "[plus]", None, lambda desk: desk.zoom(ZOOM_STEP)),
        Key("Zoom in", "[plus]", "shift", lambda desk: desk.zoom(ZOOM_STEP)),
        Key("Zoom out", "-", None, lambda desk: desk.zoom(1 / ZOOM_STEP)),
    ]
    for name, columns, rows in ARROWS:
        for step_px, modifier in ((NUDGE_PX, None), (LARGE_NUDGE_PX, "shift")):
            move = partial(_nudge, columns_px=columns * step_px, rows_px=rows * step_px)
            keys.append(Key(f"Move the point {step_px:g} px {name}", f"arrow{name}", modifier, move))
    for number in range(1, NUMBER_KEYS + 1):
        keys.append(Key(f"Select point {number}", str(number), None, partial(_select, number=number)))
    return keys


def _nudge(desk: Desk, columns_px: float, rows_px: float) -> None:
    desk.nudge(columns_px, rows_px)


def _select(desk: Desk, number: int) -> None:
    marks = desk.state.document.marks
    if number <= len(marks):
        desk.select(marks[number - 1].id)


HELP_ROWS = (
    ("Click", "add a point; drag it to move it"),
    ("1 … 9", "select a point, as a click on it or its row does"),
    ("Arrows", "move it by 0.1 px, with Shift by 1 px"),
    ("D", "type its distance; Enter leaves the field"),
    ("O, Delete", "switch it on or off; delete it"),
    ("Esc", "select nothing, put the tool away"),
    ("Ctrl Z, Ctrl Y", "undo, redo"),
    ("Wheel, + −", "zoom; drag the picture to slide it"),
    ("Shift drag", "zoom to a box"),
    ("F", "whole picture"),
    ("N P, . ,", "next, previous picture"),
    ("Space", "play the drive, stop"),
    ("Ctrl S", "save"),
    ("Ctrl K", "every command"),
)
