"""The keys, and how the page looks."""

import viser

from fcw_viz.page.controls import Run, on_choice
from fcw_viz.page.keys import help_table
from fcw_viz.page.server import set_colours
from fcw_viz.page.style import text_block
from fcw_viz.review_app.keys import HELP_ROWS


class PagePanel:
    """A table of the keys, and the switch between dark and light."""

    def __init__(self, gui: viser.GuiApi, run: Run, dark: bool) -> None:
        gui.add_html(text_block(help_table(HELP_ROWS)))
        on_choice(gui.add_checkbox("Dark colours", dark), run, lambda chosen: set_colours(gui, chosen))
