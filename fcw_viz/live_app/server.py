"""The live page's server: the running drive in every tab, and its review once it has ended."""

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
    """A running page."""

    runs_drive = True

    def __init__(self, feed: LiveFeed, title: str, port: int = DEFAULT_PORT, dark: bool = False) -> None:
        """Serve a drive that begins, or has begun.

        Args:
            feed: what the pipeline tells.
            title: of the drive.
            port: wished for; the next free one where it is taken.
            dark: colours at the beginning.

        Raises:
            UserError: the port is none.
        """
        self._feed, self._title, self._dark = feed, title, dark
        self._waiting = FOR_FIRST_PICTURE
        self._session: ReviewSession | None = None
        super().__init__(port, f"fcw · {title}", dark)

    def say_waiting(self, words: str) -> None:
        """Have every tab say what is waited for, until the first picture comes."""
        self._waiting = words
        for tab in self.tabs:
            if isinstance(tab, LiveTab):
                tab.show_waiting(words)

    def say_ended(self, words: str) -> None:
        """Tell every tab that the drive has ended, and what comes now; also when the program ends."""
        self.goodbye = words
        for tab in self.tabs:
            if isinstance(tab, LiveTab):
                tab.show_end(words)

    def review(self, log: Path, reviewer: str) -> None:
        """Become the page that reviews the drive's log, now that it is whole; every tab is loaded anew.

        Where the source was lost, the tabs say so until a person asks for the review: nobody must take an
        empty page for a road without danger.

        Args:
            log: the drive.mcap.
            reviewer: in whose name verdicts are kept.
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
        """A tab on the drive, or on its review."""
        if self._session is None:
            return LiveTab(client, self._feed, self._title, self._waiting)
        return Tab(client, self._session, self._title, self._dark)

    def stop(self) -> None:
        """End it."""
        super().stop()
        if self._session is not None:
            self._session.close()
