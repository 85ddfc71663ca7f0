"""The panels of a tab: one beside the picture, with the steps of the job and what checks it in its tabs.

Nothing lies over the picture but the line that says what to do next: every label and every proposal is seen.
"""

from typing import Protocol

import viser

from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.keys import HELP_ROWS
from fcw_viz.calibrate_app.panels.camera.lens import LensPanel
from fcw_viz.calibrate_app.panels.camera.setup import SetupPanel
from fcw_viz.calibrate_app.panels.check import CheckPanel
from fcw_viz.calibrate_app.panels.compare import ComparePanel
from fcw_viz.calibrate_app.panels.figures import AbovePanel, IntervalPanel
from fcw_viz.calibrate_app.panels.guide import Guide
from fcw_viz.calibrate_app.panels.picture import PicturePanel
from fcw_viz.calibrate_app.panels.points import PointsPanel
from fcw_viz.calibrate_app.panels.result import ResultPanel
from fcw_viz.calibrate_app.panels.road.plates import PlatesPanel
from fcw_viz.calibrate_app.panels.road.rectangle import RectanglePanel
from fcw_viz.calibrate_app.panels.save import SavePanel
from fcw_viz.calibrate_app.panels.way import WayPanel
from fcw_viz.page.panel import add_page_panel

PANEL_WIDTH_PX = 360
CALIBRATE = "Calibrate"
"""The tab of the steps."""


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
        gui.main_panel.set_width(PANEL_WIDTH_PX)
        desk.channel.on("docked", lambda _: gui.main_panel.set_width(PANEL_WIDTH_PX))
        guide = Guide(gui, desk, PANEL_WIDTH_PX)
        tabs = gui.add_tab_group()
        with tabs.add_tab(CALIBRATE):
            picture = PicturePanel(gui, desk)
            way = WayPanel(gui, desk)
            road: list[Panel] = [RectanglePanel(gui, desk), PlatesPanel(gui, desk)]
            self.points = PointsPanel(gui, desk)
            steps: list[Panel] = [
                guide,
                picture,
                way,
                *road,
                self.points,
                SetupPanel(gui, desk),
                LensPanel(gui, desk),
                ResultPanel(gui, desk),
                SavePanel(gui, desk),
            ]
        with tabs.add_tab("Check"):
            self._check = CheckPanel(gui, desk)
            interval = IntervalPanel(gui)
            compare = ComparePanel(gui, desk)
        with tabs.add_tab("From above"):
            self._above = AbovePanel(gui, desk)
        with tabs.add_tab("Keys"):
            add_page_panel(gui, desk.run, HELP_ROWS, dark)
        self._all: list[Panel] = [*steps, self._check, interval, compare, self._above]

    def show(self, state: SessionState) -> None:
        """Bring all of them to a moment of the session."""
        for panel in self._all:
            panel.show(state)

    def close(self) -> None:
        """The tab is gone: end what runs."""
        self._check.close()
        self._above.close()
