"""Step 1 of the job: which picture of the drive is clicked in."""

from typing import TYPE_CHECKING

import viser

from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.page.controls import on_choice, on_press
from fcw_viz.page.style import set_html, step_heading

if TYPE_CHECKING:
    from fcw_viz.calibrate_app.tab import Tab

PREVIOUS, NEXT, FIT = "◀ Previous", "Next ▶", "Fit"


class PicturePanel:
    """The slider over the pictures, with the steps to both sides."""

    def __init__(self, gui: viser.GuiApi, tab: "Tab") -> None:
        self._tab = tab
        self._heading = gui.add_html("")
        count = tab.pictures.count
        self._slider = gui.add_slider(
            "Picture", min=1, max=max(count, 2), step=1, initial_value=1, visible=count > 1
        )
        self._steps = gui.add_button_group("", (PREVIOUS, NEXT, FIT) if count > 1 else (FIT,))

        on_choice(self._slider, tab.run, lambda number: tab.go_to(number - 1))
        on_press(
            self._steps,
            tab.run,
            {
                PREVIOUS: lambda: tab.step(-1),
                NEXT: lambda: tab.step(1),
                FIT: tab.view.fit,
            },
        )

    def show(self, state: SessionState) -> None:
        """Show which picture is seen."""
        pictures, index = self._tab.pictures, self._tab.frame_index
        seconds = index / pictures.frame_rate_hz
        note = f"{seconds:.1f} s" if pictures.count > 1 else str(pictures.image_size)
        mark = "done" if state.document.marks else ""
        set_html(self._heading, step_heading(1, pictures.name, mark, note))
        self._slider.value = index + 1
