"""The age of the picture on the screen of a tab, which the browser checks and reports if it is too old."""

import json
from collections import deque
from pathlib import Path

import viser

from fcw_viz.page.script import run_script

_BROWSER_SIDE = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")
REMEMBERED = 60
"""Number of the browser's latest messages that set its clock; clocks drift by milliseconds in an hour."""


class BrowserClock:
    """The difference between a browser's clock and ours, from messages with its time.

    A message takes some time to arrive, so the quickest of the last ones gives the difference, to within the
    time that it took.
    """

    def __init__(self) -> None:
        self._ahead_s: deque[float] = deque(maxlen=REMEMBERED)

    def heard(self, browser_s: float, now_s: float) -> None:
        """Take a message that arrived now and was sent when the browser's clock was at `browser_s`."""
        self._ahead_s.append(browser_s - now_s)

    @property
    def known(self) -> bool:
        """Whether a message has come."""
        return bool(self._ahead_s)

    def of_browser(self, our_s: float) -> float:
        """Convert a time of ours to the browser's."""
        return our_s + max(self._ahead_s)

    def of_ours(self, browser_s: float) -> float:
        """Convert a time of the browser to ours."""
        return browser_s - max(self._ahead_s)


class PictureAge:
    """The age of the picture in one tab, which the browser watches."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self.clock = BrowserClock()
        run_script(client, _BROWSER_SIDE)

    def start(self) -> None:
        """Learn the browser's clock once the channel of the page is open; it sends `clock:<ms>`."""
        run_script(self._client, "window.fcwChannel.tell(`clock:${performance.now()}`);")

    def comes(self, captured_s: float) -> None:
        """Announce a picture that was captured at a time of ours."""
        run_script(self._client, f"window.fcwAge.comes({self.in_browser(captured_s)});")

    def in_browser(self, our_s: float) -> str:
        """A time of ours in JavaScript: milliseconds of the browser's clock, or null."""
        return f"{self.clock.of_browser(our_s) * 1000:.1f}" if self.clock.known else "null"

    def says(self, words: str) -> None:
        """Set the words for an old picture; empty if there is nothing special."""
        run_script(self._client, f"window.fcwAge.says({json.dumps(words)});")

    def end(self, lost: str) -> None:
        """End the watch: no picture will come any more, so the last one is not too old.

        Args:
            lost: why the source was lost, shown over the picture from now on; empty for a normal end.
        """
        run_script(self._client, f"window.fcwAge.end({json.dumps(lost)});")
