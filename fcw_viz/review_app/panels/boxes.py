"""Correcting boxes: the switch, what can be done, and the buttons of the selected box."""

from collections.abc import Callable, Mapping
from html import escape

import viser

from fcw.annotation.records import LabelledBox, VehicleKind, View
from fcw_viz.page.channel import chooses, says
from fcw_viz.page.controls import Run, on_button, on_press
from fcw_viz.page.style import set_html, text_block
from fcw_viz.review_app.picture.box_editor import BoxEditor

BOXES = "Boxes"
"""The name of its tab."""
START, STOP = "Correct boxes (E)", "Done (E)"
DELETE, IGNORE = "Delete", "Ignore / use"
DRAW, DRAWING = "Draw a box", "Drag on the picture, or press here to cancel"
CONFIRM = "Confirm all boxes (C)"


class BoxesPanel:
    """The third of a drive's tabs."""

    def __init__(self, gui: viser.GuiApi, run: Run, boxes: BoxEditor, switch: Callable[[], object]) -> None:
        self._boxes = boxes
        self._switch = gui.add_button(START, icon=viser.Icon.PENCIL)
        self._words = gui.add_html("")
        self._selected = gui.add_button_group("Box", (DELETE, IGNORE), visible=False)
        self._draw = gui.add_button(DRAW, icon=viser.Icon.SQUARE_PLUS, color="gray", visible=False)
        self._confirm = gui.add_button(CONFIRM, icon=viser.Icon.CHECK, color="gray", visible=False)
        self._help = gui.add_html(text_block(_HELP), visible=False)
        on_button(self._switch, run, switch)
        on_press(self._selected, run, {DELETE: boxes.delete, IGNORE: boxes.switch_ignored})
        on_button(self._draw, run, boxes.switch_drawing)
        on_button(self._confirm, run, boxes.confirm)

    def show(self) -> None:
        """Bring it to the boxes of the frame."""
        boxes = self._boxes
        self._switch.label = STOP if boxes.active else START
        self._selected.visible = boxes.active and boxes.selected is not None
        self._draw.visible = self._confirm.visible = self._help.visible = boxes.active
        self._draw.label = DRAWING if boxes.draws else DRAW
        set_html(self._words, text_block(self._html()))

    def _html(self) -> str:
        boxes = self._boxes
        if not boxes.active:
            return (
                '<p class="dim">Corrected boxes become labels: <code>fcw train</code> learns from them. '
                "The log itself is never changed.</p>"
            )
        count, edited = boxes.box_count
        said = ", ".join(boxes.confirmed_by)
        confirmed = f"<p>Confirmed by {escape(said)}.</p>" if said else ""
        return (
            f"<p><b>{count} box{'es' * (count != 1)}</b> on this frame, {edited} corrected.</p>{confirmed}"
            f"{'' if boxes.selected is None else _selected_html(boxes.told()[1], boxes.draws_rear)}"
        )


_HELP = (
    "<table>"
    + "".join(
        f"<tr><td>{what}</td><td style='text-align:left'>{does}</td></tr>"
        for what, does in (
            ("Click, <kbd>V</kbd>", "selects a box; drag it, its edges or corners"),
            ("<kbd>Shift</kbd> drag", "draws a new box"),
            ("<kbd>Ctrl</kbd> arrows", "moves it by a pixel; with Shift: an edge"),
            ("<kbd>Delete</kbd>", "deletes it: no vehicle there"),
            ("<kbd>K</kbd>", "copies it to the next frame"),
            ("<kbd>I</kbd>", "interpolates from where you last drew it"),
            ("<kbd>J</kbd>", "follows it until it drifts"),
            ("<kbd>← →</kbd>", "previous, next frame"),
            ("<kbd>Ctrl Z</kbd>", "undo"),
        )
    )
    + "</table>"
)


def _selected_html(label: LabelledBox, draws_rear: bool) -> str:
    """What is said of the selected box, to choose, and what is done with it."""
    views = {view.name: view.value for view in View}
    kinds = {kind.name: kind.value for kind in VehicleKind}
    hidden = {"0": "not hidden", "1": "hidden up to 40 %", "2": "hidden more than 40 %"}
    fields = (
        _choice("boxview", "view?", views, label.view.name if label.view else "")
        + _choice("boxkind", "kind?", kinds, label.kind.name if label.kind else "")
        + _choice("boxoccluded", "hidden?", hidden, "" if label.occluded is None else str(label.occluded))
    )
    rear = "No rear face" if label.rear_box else "Rear face"
    buttons = "".join(
        f"<button {says(message)} class='{'on' if on else ''}'>{words}</button>"
        for message, words, on in (
            ("boxrear:", rear, draws_rear),
            ("boxcopy:", "Copy to next", False),
            ("boxinterpolate:", "Interpolate", False),
            ("boxfollow:", "Follow", False),
        )
    )
    return f'<div class="fcw-fields">{fields}</div><div class="fcw-triage">{buttons}</div>'


def _choice(name: str, empty: str, choices: Mapping[str, str], chosen: str) -> str:
    options = "".join(
        f'<option value="{value}"{" selected" * (value == chosen)}>{words}</option>'
        for value, words in ({"": empty} | dict(choices)).items()
    )
    return f"<select {chooses(name)}>{options}</select>"
