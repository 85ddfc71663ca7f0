"""The keys of the page: each does what some button or drag does, and stands in the command palette."""

from functools import partial
from typing import TYPE_CHECKING

from fcw_viz.page.keys import ZOOM_STEP, Key

if TYPE_CHECKING:
    from fcw_viz.calibrate_app.tab import Tab

NUDGE_PX = 0.1
LARGE_NUDGE_PX = 1.0
NUMBER_KEYS = 9
ARROWS = (("left", -1, 0), ("right", 1, 0), ("up", 0, -1), ("down", 0, 1))


def all_keys() -> "list[Key[Tab]]":
    """Every key of the page."""
    keys: list[Key[Tab]] = [
        Key("Undo", "Z", "cmd/ctrl", lambda tab: tab.undo()),
        Key("Redo", "Z", "cmd/ctrl+shift", lambda tab: tab.redo()),
        Key("Redo", "Y", "cmd/ctrl", lambda tab: tab.redo()),
        Key("Save the calibration", "S", "cmd/ctrl", lambda tab: tab.save()),
        Key("Delete the selected point", "delete", None, lambda tab: tab.delete_selected()),
        Key("Delete the selected point", "backspace", None, lambda tab: tab.delete_selected()),
        Key("Switch the selected point on or off", "O", None, lambda tab: tab.switch_selected()),
        Key("Type the distance of the selected point", "D", None, lambda tab: tab.type_distance()),
        Key("Select nothing", "escape", None, lambda tab: tab.escape()),
        Key("Next picture", "N", None, lambda tab: tab.step(1)),
        Key("Previous picture", "P", None, lambda tab: tab.step(-1)),
        Key("Next picture", ".", None, lambda tab: tab.step(1)),
        Key("Previous picture", ",", None, lambda tab: tab.step(-1)),
        Key("Whole picture", "F", None, lambda tab: tab.view.fit()),
        Key("Zoom in", "=", None, lambda tab: tab.zoom(ZOOM_STEP)),
        Key("Zoom in", "[plus]", None, lambda tab: tab.zoom(ZOOM_STEP)),
        Key("Zoom in", "[plus]", "shift", lambda tab: tab.zoom(ZOOM_STEP)),
        Key("Zoom out", "-", None, lambda tab: tab.zoom(1 / ZOOM_STEP)),
    ]
    for name, columns, rows in ARROWS:
        for step_px, modifier in ((NUDGE_PX, None), (LARGE_NUDGE_PX, "shift")):
            move = partial(_nudge, columns_px=columns * step_px, rows_px=rows * step_px)
            keys.append(Key(f"Move the point {step_px:g} px {name}", f"arrow{name}", modifier, move))
    for number in range(1, NUMBER_KEYS + 1):
        keys.append(Key(f"Select point {number}", str(number), None, partial(_select, number=number)))
    return keys


def _nudge(tab: "Tab", columns_px: float, rows_px: float) -> None:
    tab.nudge(columns_px, rows_px)


def _select(tab: "Tab", number: int) -> None:
    marks = tab.state.document.marks
    if number <= len(marks):
        tab.select(marks[number - 1].id)


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
