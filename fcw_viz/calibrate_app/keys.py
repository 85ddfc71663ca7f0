"""The keys of the page: each does what some button or drag does, and stands in the command palette."""

from functools import partial

from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.page.keys import Key, picture_keys

NUDGE_PX = 0.1
LARGE_NUDGE_PX = 1.0
NUMBER_KEYS = 9
ARROWS = (("left", -1, 0), ("right", 1, 0), ("up", 0, -1), ("down", 0, 1))


def all_keys(desk: Desk) -> list[Key]:
    """Every key of the page, at one desk."""
    keys = [
        Key("Undo", "Z", "cmd/ctrl", desk.undo),
        Key("Redo", "Z", "cmd/ctrl+shift", desk.redo),
        Key("Redo", "Y", "cmd/ctrl", desk.redo),
        Key("Save the calibration", "S", "cmd/ctrl", desk.save),
        Key("Delete the selected point", "delete", None, desk.delete_selected),
        Key("Delete the selected point", "backspace", None, desk.delete_selected),
        Key("Switch the selected point on or off", "O", None, desk.switch_selected),
        Key("Type the distance of the selected point", "D", None, desk.type_distance),
        Key("Deselect", "escape", None, desk.escape),
        Key("Next picture", "N", None, lambda: desk.step(1)),
        Key("Previous picture", "P", None, lambda: desk.step(-1)),
        Key("Next picture", ".", None, lambda: desk.step(1)),
        Key("Previous picture", ",", None, lambda: desk.step(-1)),
        *picture_keys(desk.view.fit, desk.zoom),
    ]
    for name, columns, rows in ARROWS:
        for step_px, modifier in ((NUDGE_PX, None), (LARGE_NUDGE_PX, "shift")):
            move = partial(desk.nudge, columns * step_px, rows * step_px)
            keys.append(Key(f"Move the point {step_px:g} px {name}", f"arrow{name}", modifier, move))
    for number in range(1, NUMBER_KEYS + 1):
        keys.append(Key(f"Select point {number}", str(number), None, partial(_select, desk, number)))
    return keys


def _select(desk: Desk, number: int) -> None:
    marks = desk.state.document.marks
    if number <= len(marks):
        desk.select(marks[number - 1].id)


HELP_ROWS = (
    ("Click", "add a point; drag it to move it"),
    ("1 … 9", "select a point; or click it or its row"),
    ("Arrows", "move it by 0.1 px, with Shift by 1 px"),
    ("D", "type its distance; Enter leaves the field"),
    ("O, Delete", "switch it on or off; delete it"),
    ("Esc", "deselect, or close the tool"),
    ("Ctrl Z, Ctrl Y", "undo, redo"),
    ("Wheel, + −", "zoom; drag the picture to move it"),
    ("Shift drag", "zoom to a box"),
    ("F", "whole picture"),
    ("N P, . ,", "next, previous picture"),
    ("Space", "play, pause the drive"),
    ("Ctrl S", "save"),
    ("Ctrl K", "all commands"),
)
