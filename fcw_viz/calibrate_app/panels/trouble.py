"""What is wrong, in words, each with the button that mends it."""

from html import escape

import viser

from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.state import Mend, SessionState, Trouble
from fcw_viz.page.channel import is_place
from fcw_viz.page.controls import on_button
from fcw_viz.page.style import card, text_block

MEND_COLOR = (47, 158, 68)


class TroublePanel:
    """One card for each trouble; nothing where all is well."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._gui = gui
        self._desk = desk
        self._folder = gui.add_folder(None)
        self._shown: tuple[Trouble, ...] = ()
        self._parts: list[viser.GuiHtmlHandle | viser.GuiButtonHandle] = []

    def show(self, state: SessionState) -> None:
        """Show the troubles of a moment of the session."""
        troubles = state.solution.troubles
        if troubles == self._shown:
            return
        self._shown = troubles
        for part in self._parts:
            part.remove()
        self._parts = []
        with self._folder:
            for trouble in troubles:
                self._add(trouble)

    def _add(self, trouble: Trouble) -> None:
        document = self._desk.state.document
        names = ", ".join(mark.name for mark in document.marks if mark.id in trouble.mark_ids)
        subject = f"<b>⚠ {escape(names)}:</b> " if names else ""
        html = f"<div {is_place('trouble')}>{card(f'{subject}{escape(trouble.text)}')}</div>"
        self._parts.append(self._gui.add_html(text_block(html)))
        if trouble.mend is not None:
            self._parts.append(self._mend_button(trouble.mend))

    def _mend_button(self, mend: Mend) -> viser.GuiButtonHandle:
        button = self._gui.add_button(mend.label, color=MEND_COLOR)

        on_button(button, self._desk.run, lambda: self._desk.apply(*mend.edits))
        return button
