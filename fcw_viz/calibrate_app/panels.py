"""The panels of a tab and where they stand: the steps of the job at the right, the rest floating."""

from typing import TYPE_CHECKING, Protocol

import viser

from fcw_viz.calibrate_app.guide import Guide
from fcw_viz.calibrate_app.keys import help_html
from fcw_viz.calibrate_app.knowledge_panel import KnowledgePanel
from fcw_viz.calibrate_app.page_style import text_block
from fcw_viz.calibrate_app.picture_panel import PicturePanel
from fcw_viz.calibrate_app.points_panel import PointsPanel
from fcw_viz.calibrate_app.result_panel import ResultPanel
from fcw_viz.calibrate_app.save_panel import SavePanel
from fcw_viz.calibrate_app.setup_panel import SetupPanel
from fcw_viz.calibrate_app.state import SessionState
from fcw_viz.calibrate_app.trouble_panel import TroublePanel

if TYPE_CHECKING:
    from fcw_viz.calibrate_app.tab import Tab

STEPS_WIDTH_PX = 340


class Panel(Protocol):
    """A part of the page that shows a session."""

    def show(self, state: SessionState) -> None:
        """Bring it to a moment of the session."""
        ...


class Panels:
    """All panels of a tab.

    Attributes:
        points: the one that the cursor is put into.
    """

    def __init__(self, gui: viser.GuiApi, tab: "Tab") -> None:
        gui.main_panel.dock_right()
        gui.main_panel.set_width(STEPS_WIDTH_PX)
        guide = Guide(gui, tab, STEPS_WIDTH_PX)
        picture = PicturePanel(gui, tab)
        self.points = PointsPanel(gui, tab)
        steps: list[Panel] = [
            guide,
            picture,
            self.points,
            SetupPanel(gui, tab),
            ResultPanel(gui, tab),
            TroublePanel(gui, tab),
            SavePanel(gui, tab),
        ]
        side = gui.add_panel()
        with side.add_tab("Know more", viser.Icon.BULB):
            knowledge = KnowledgePanel(gui, tab)
        with side.add_tab("Keys", viser.Icon.KEYBOARD):
            gui.add_html(text_block(help_html()))
        side.float(x=12, y=52, width=300)
        self._all: list[Panel] = [*steps, knowledge]

    def show(self, state: SessionState) -> None:
        """Bring all of them to a moment of the session."""
        for panel in self._all:
            panel.show(state)
