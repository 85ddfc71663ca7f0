"""The panels of a tab and where they stand: the steps of the job at the right, the rest floating."""

from typing import Protocol

import viser

from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.keys import HELP_ROWS
from fcw_viz.calibrate_app.panels.check import CheckPanel
from fcw_viz.calibrate_app.panels.figures import AbovePanel, IntervalPanel
from fcw_viz.calibrate_app.panels.guide import Guide
from fcw_viz.calibrate_app.panels.knowledge import KnowledgePanel
from fcw_viz.calibrate_app.panels.picture import PicturePanel
from fcw_viz.calibrate_app.panels.points import PointsPanel
from fcw_viz.calibrate_app.panels.result import ResultPanel
from fcw_viz.calibrate_app.panels.save import SavePanel
from fcw_viz.calibrate_app.panels.setup import SetupPanel
from fcw_viz.page.panel import add_page_panel

STEPS_WIDTH_PX = 340
SIDE_LEFT_PX, SIDE_TOP_PX, SIDE_WIDTH_PX = 12, 72, 356
"""Over the sky, where nobody clicks, and under the line that says what to do next."""

LOW_WINDOW_PX = 680
"""In a lower window it would reach down to the road: it begins folded."""


class Panel(Protocol):
    """A part of the page that shows a session."""

    def show(self, state: SessionState) -> None:
        """Bring it to a moment of the session."""
        ...


class Panels:
    """All panels of a desk.

    Attributes:
        points: the one that the cursor is put into.
    """

    def __init__(self, gui: viser.GuiApi, desk: Desk, dark: bool) -> None:
        gui.main_panel.dock_right()
        gui.main_panel.set_width(STEPS_WIDTH_PX)
        guide = Guide(gui, desk, STEPS_WIDTH_PX)
        picture = PicturePanel(gui, desk)
        self.points = PointsPanel(gui, desk)
        steps: list[Panel] = [
            guide,
            picture,
            self.points,
            SetupPanel(gui, desk),
            ResultPanel(gui, desk),
            SavePanel(gui, desk),
        ]
        side = gui.add_panel()
        with side.add_tab("Error"):
            interval = IntervalPanel(gui)
        with side.add_tab("From above"):
            above = AbovePanel(gui)
        with side.add_tab("Know more"):
            knowledge = KnowledgePanel(gui, desk)
        with side.add_tab("Check"):
            self._check = CheckPanel(gui, desk)
        with side.add_tab("Keys"):
            add_page_panel(gui, desk.run, HELP_ROWS, dark)
        side.float(x=SIDE_LEFT_PX, y=SIDE_TOP_PX, width=SIDE_WIDTH_PX)
        if desk.client.camera.image_height < LOW_WINDOW_PX:
            side.minimize()
        self._all: list[Panel] = [*steps, interval, above, knowledge, self._check]

    def show(self, state: SessionState) -> None:
        """Bring all of them to a moment of the session."""
        for panel in self._all:
            panel.show(state)

    def close(self) -> None:
        """The tab is gone: end what runs."""
        self._check.close()
