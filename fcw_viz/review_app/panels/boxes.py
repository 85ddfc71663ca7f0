"""Correcting boxes: the switch, what can be done, and the buttons of the selected box."""

from collections.abc import Callable

import viser

from fcw_viz.page.controls import Run, on_button, on_press
from fcw_viz.page.style import set_html, text_block
from fcw_viz.review_app.picture.box_editor import BoxEditor

START, STOP = "Correct boxes (E)", "Done (E)"
DELETE, IGNORE = "Delete", "Ignore, or not"
CONFIRM = "All boxes are right (C)"


class BoxesPanel:
    """The third of a drive's tabs."""

    def __init__(self, gui: viser.GuiApi, run: Run, boxes: BoxEditor, switch: Callable[[], object]) -> None:
        self._boxes = boxes
        self._switch = gui.add_button(START, icon=viser.Icon.PENCIL)
        self._words = gui.add_html("")
        self._selected = gui.add_button_group("Box", (DELETE, IGNORE), visible=False)
        self._confirm = gui.add_button(CONFIRM, icon=viser.Icon.CHECK, color="gray", visible=False)
        on_button(self._switch, run, switch)
        on_press(self._selected, run, {DELETE: boxes.delete, IGNORE: boxes.switch_ignored})
        on_button(self._confirm, run, boxes.confirm)

    def show(self) -> None:
        """Bring it to the boxes of the frame."""
        boxes = self._boxes
        self._switch.label = STOP if boxes.active else START
        self._selected.visible = boxes.active and boxes.selected is not None
        self._confirm.visible = boxes.active
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
        confirmed = f"<p>All right, say {said}.</p>" if said else ""
        return (
            f"<p><b>{count} box{'es' * (count != 1)}</b> on this frame, {edited} corrected.</p>{confirmed}"
            "<table><tr><td>Click</td><td style='text-align:left'>selects a box; drag its corners</td></tr>"
            "<tr><td><kbd>Shift</kbd> drag</td><td style='text-align:left'>draws a new box</td></tr>"
            "<tr><td><kbd>Delete</kbd></td><td style='text-align:left'>there is no vehicle</td></tr>"
            "<tr><td><kbd>← →</kbd></td><td style='text-align:left'>next frame</td></tr>"
            "<tr><td><kbd>Ctrl Z</kbd></td><td style='text-align:left'>takes the last one back</td></tr>"
            "</table>"
        )
