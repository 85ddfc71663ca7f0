"""The panel about the page itself: its keys and colours."""

from collections.abc import Iterable

import viser

from fcw_viz.page.controls import Run, on_choice
from fcw_viz.page.keys import help_table
from fcw_viz.page.style import set_colours, text_block


def add_page_panel(gui: viser.GuiApi, run: Run, help_rows: Iterable[tuple[str, str]], dark: bool) -> None:
    """Add a table of the keys, and the switch between dark and light.

    Args:
        gui: GUI of the tab.
        run: runs work in the thread of the tab.
        help_rows: keys and what they do.
        dark: whether the page starts in dark colours.
    """
    gui.add_html(text_block(help_table(help_rows)))
    on_choice(gui.add_checkbox("Dark mode", dark), run, lambda chosen: set_colours(gui, chosen))
