"""How old the picture on a tab's screen is: told to the browser, which says so where that is too much."""

import json
from collections import deque
from pathlib import Path

import viser

from fcw_viz.page.script import run_script

_BROWSER_SIDE = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")
REMEMBERED = 60
"""Words of the browser by which its clock is known: clocks drift by milliseconds in an hour."""


class BrowserClock:
    """A browser's clock beside our own, by what it says of its time.

    A word takes some time until it is heard here, never less than none: of the last words the quickest one
    tells the difference of the clocks, to within what that one took.
    """

    def __init__(self) -> None:
        self._ahead_s: deque[float] = deque(maxlen=REMEMBERED)

    def heard(self, browser_s: float, now_s: float) -> None:
        """A word came now that was said when the browser's clock was at `browser_s`."""
        self._ahead_s.append(browser_s - now_s)

    @property
    def known(self) -> bool:
        """Whether the browser has said anything."""
        return bool(self._ahead_s)

    def of_browser(self, our_s: float) -> float:
        """The browser's time at one of ours."""
        return our_s + max(self._ahead_s)

    def of_ours(self, browser_s: float) -> float:
        """Our time at one of the browser's."""
        return browser_s - max(self._ahead_s)


class PictureAge:
    """The age of the picture in one tab, of which the browser keeps watch."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self.clock = BrowserClock()
        run_script(client, _BROWSER_SIDE)

    def start(self) -> None:
        """Learn the browser's clock, once the page's channel is open: it says `clock:<ms>`."""
        run_script(self._client, "window.fcwChannel.tell(`clock:${performance.now()}`);")

    def comes(self, captured_s: float) -> None:
        """A picture follows that was captured at a time of ours."""
        run_script(self._client, f"window.fcwAge.comes({self.in_browser(captured_s)});")

    def in_browser(self, our_s: float) -> str:
        """A time of ours as JavaScript says it: milliseconds of the browser's clock, or null."""
        return f"{self.clock.of_browser(our_s) * 1000:.1f}" if self.clock.known else "null"

    def says(self, words: str) -> None:
        """What is said of an old picture; empty where nothing more is known of it."""
        run_script(self._client, f"window.fcwAge.says({json.dumps(words)});")

    def end(self, lost: str) -> None:
        """No picture will come any more: the last one is right, and nothing is present.

        Args:
            lost: why, which stands over the picture from now on; empty where that is as it should be.
        """
        run_script(self._client, f"window.fcwAge.end({json.dumps(lost)});")
