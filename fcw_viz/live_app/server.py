"""The server of the live page: the running drive in every tab, and its review after the end."""

from pathlib import Path

import viser

from fcw_viz.live_app.feed import LiveFeed
from fcw_viz.live_app.tab import LiveTab
from fcw_viz.page.script import run_script
from fcw_viz.page.server import DEFAULT_PORT, PageServer
from fcw_viz.page.tab import PageTab
from fcw_viz.review_app.session import ReviewSession
from fcw_viz.review_app.tab import Tab

FOR_FIRST_PICTURE = "waiting for the first picture"


class LivePage(PageServer):
    """The live page while it is served."""

    runs_drive = True

    def __init__(self, feed: LiveFeed, title: str, port: int = DEFAULT_PORT, dark: bool = False) -> None:
        """Serve a drive that is about to begin or has begun.

        Args:
            feed: the feed from the pipeline.
            title: title of the drive.
            port: preferred port; the next free one is used if it is taken.
            dark: whether the page starts in dark colours.

        Raises:
            UserError: the port is not valid.
        """
        self._feed, self._title, self._dark = feed, title, dark
        self._waiting = FOR_FIRST_PICTURE
        self._session: ReviewSession | None = None
        super().__init__(port, f"fcw · {title}", dark)

    def say_waiting(self, words: str) -> None:
        """Show in every tab what is waited for, until the first picture comes."""
        self._waiting = words
        for tab in self.tabs:
            if isinstance(tab, LiveTab):
                tab.show_waiting(words)

    def say_ended(self, words: str) -> None:
        """Show in every tab that the drive has ended, and what comes next; also when the program ends."""
        self.goodbye = words
        for tab in self.tabs:
            if isinstance(tab, LiveTab):
                tab.show_end(words)

    def review(self, log: Path, reviewer: str) -> None:
        """Become the page that reviews the complete log of the drive; every tab is reloaded.

        If the source was lost, the tabs show that until the user asks for the review. Nobody must mistake an
        empty page for a road without danger.

        Args:
            log: the drive.mcap.
            reviewer: name under which verdicts are stored.
        """
        session = ReviewSession({self._title: log}, reviewer)
        session.start()
        self._session = session
        self._tidying.give_pictures_back()
        for tab in self.tabs:
            if isinstance(tab, LiveTab) and not self._feed.trouble:
                run_script(tab.client, "location.reload();")
                tab.client.flush()

    def open_tab(self, client: viser.ClientHandle) -> PageTab:
        """Open a tab on the drive, or on its review."""
        if self._session is None:
            return LiveTab(client, self._feed, self._title, self._waiting)
        return Tab(client, self._session, self._title, self._dark)

    def stop(self) -> None:
        """End the page."""
        super().stop()
        if self._session is not None:
            self._session.close()
