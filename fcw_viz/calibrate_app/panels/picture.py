"""Which picture of the drive is clicked in."""

import viser

from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.page.controls import on_choice, on_press
from fcw_viz.page.style import heading, set_html

PREVIOUS, NEXT, FIT = "◀ Previous", "Next ▶", "Whole picture"


class PicturePanel:
    """The slider over the pictures, with the steps to both sides."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._heading = gui.add_html("")
        count = desk.pictures.count
        self._slider = gui.add_slider(
            "Picture", min=1, max=max(count, 2), step=1, initial_value=1, visible=count > 1
        )
        self._steps = gui.add_button_group("", (PREVIOUS, NEXT, FIT) if count > 1 else (FIT,))

        on_choice(self._slider, desk.run, lambda number: desk.go_to(number - 1))
        on_press(
            self._steps,
            desk.run,
            {
                PREVIOUS: lambda: desk.step(-1),
                NEXT: lambda: desk.step(1),
                FIT: desk.view.fit,
            },
        )

    def show(self, state: SessionState) -> None:
        """Show which picture is seen."""
        del state  # the desk alone knows which picture its tab shows
        pictures, index = self._desk.pictures, self._desk.frame_index
        seconds = index / pictures.frame_rate_hz
        note = f"{seconds:.1f} s" if pictures.count > 1 else str(pictures.image_size)
        set_html(self._heading, heading(pictures.name, note))
        self._slider.value = index + 1
