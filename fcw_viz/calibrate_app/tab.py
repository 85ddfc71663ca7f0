"""One browser tab: the desk of its person, and the page that shows it."""

from pathlib import Path

import viser

from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.handles import PictureHandles
from fcw_viz.calibrate_app.keys import all_keys
from fcw_viz.calibrate_app.panels.layout import Panels
from fcw_viz.calibrate_app.proposals.drive_look import DriveLooks
from fcw_viz.calibrate_app.session import CalibrationSession
from fcw_viz.page.keys import add_keys
from fcw_viz.page.pictures import Pictures
from fcw_viz.page.tab import PageTab


class Tab(PageTab):
    """One tab on a session.

    Attributes:
        desk: where its person works.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        session: CalibrationSession,
        pictures: Pictures,
        source: Path,
        dark: bool,
        looks: DriveLooks,
    ) -> None:
        super().__init__(client, f"{pictures.name} · fcw calibrate", pictures.image_size)
        desk = self.desk = Desk(self, session, pictures, source, self, looks)
        self._handles = PictureHandles(desk)
        self._panels = Panels(client.gui, desk, dark)
        add_keys(client.gui, self.run, all_keys(desk))
        self.view.on_view_change(lambda: self._handles.show(desk.state))
        desk.sit_down()

    def close(self) -> None:
        """The tab is gone."""
        self._panels.close()
        self.desk.leave()
        super().close()

    def show(self) -> None:
        """Show what is on the desk now."""
        desk, state = self.desk, self.desk.state
        with self.client.atomic():
            grip = self._handles.horizon_grip(state.document)
            desk.overlay.show(state, desk.selected, desk.frame_index, grip)
            self._handles.show(state)
        self.client.flush()  # the eye is on the picture: it does not wait for the panels
        with self.client.atomic():
            self._panels.show(state)

    def ask_distance(self, mark_id: int) -> None:
        """Put the cursor where the distance of a mark is typed."""
        self._panels.points.focus_on(mark_id)
