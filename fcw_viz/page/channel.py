"""Messages from the HTML and SVG of a page to the server, because viser's HTML has no events.

Attributes of elements define what a click or a drag on them means. A script in the browser
(`page_channel.js`) sends it through a hidden field.
"""

import json
from collections.abc import Callable
from html import escape
from pathlib import Path

import viser

from fcw_viz.page.controls import Run
from fcw_viz.page.guard.viser_server import close_client, where
from fcw_viz.page.script import run_script

_BROWSER_SIDE = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")

OnMessage = Callable[[str], object]


class PageChannel:
    """The messages of one tab: each is a name and, after a colon, a text.

    Besides those of the page's elements, there are these. `asked:` and `ready:` come when the script runs,
    with the texts after `asked=` and `at=` in the address. `size:<name> <width>x<height>` comes from elements
    with `data-fcw-size="<name>"`. `docked:` comes when the panel is docked again, with viser's own width,
    after the window was too narrow for that.
    """

    def __init__(self, client: viser.ClientHandle, run: Run) -> None:
        """Make the channel; no message is received before `open`.

        Args:
            client: the side of the browser.
            run: runs work in the thread of the tab, in order.
        """
        self._client = client
        self._run = run
        self._on_message: dict[str, tuple[OnMessage, Run]] = {}

    def on(self, name: str, callback: OnMessage, run: Run | None = None) -> None:
        """Register a callback for the text of messages with this name.

        Args:
            name: name of the message.
            callback: raises ValueError, LookupError or OverflowError for a text that the page never sends.
            run: runs the callback instead of the channel's own `run`.
        """
        self._on_message[name] = callback, run or self._run

    def open(self) -> None:
        """Start to receive messages, after all callbacks are registered."""
        field = self._client.gui.add_text("", "", visible=False)

        @field.on_update
        async def _(event: viser.GuiEvent[viser.GuiTextHandle]) -> None:
            if event.client is not None:
                self._hear(event.target.value)

        run_script(self._client, f"const uuid = {json.dumps(field._impl.uuid)};\n{_BROWSER_SIDE}")

    def _hear(self, text: str) -> None:
        _, _, message = text.partition(" ")  # its number
        name, _, about = message.partition(":")
        if name in self._on_message:
            callback, run = self._on_message[name]
            run(lambda: self._answer(callback, name, about))

    def _answer(self, callback: OnMessage, name: str, about: str) -> None:
        try:
            callback(about)
        except (ValueError, LookupError, OverflowError) as error:
            close_client(self._client, f"{name}:{about[:40]!r} is no message: {where(error)}")


def says(message: str) -> str:
    """The attribute of an element whose click sends a message."""
    return f'data-fcw="{escape(message)}"'


def leads_to(tab: str, place: str) -> str:
    """The attribute of an element whose click shows a place on the page, see `is_place`."""
    return f'data-fcw-goto="{escape(f"{tab}/{place}")}"'


def is_place(place: str) -> str:
    """The attribute of an element that `leads_to` leads to."""
    return f'data-fcw-place="{escape(place)}"'


def chooses(name: str) -> str:
    """The attribute of a `select` that sends its chosen value as a message with this name."""
    return f'data-fcw-choice="{escape(name)}"'


def enters(field: str, name: str, key: str = "") -> str:
    """Attributes of an input that sends its text as a message when Enter is pressed.

    Args:
        field: its id, which `script.empty_element` needs to clear it after the text was taken.
        name: name of the message.
        key: a lower-case letter that puts the cursor into it; empty for none.
    """
    by_key = f' data-fcw-key="{escape(key)}"' if key else ""
    return f'id="{escape(field)}" data-fcw-enter="{escape(name)}"{by_key}'


def tells_typed(field: str, name: str) -> str:
    """Attributes of an input that sends its text as a message while it is typed.

    Args:
        field: its id.
        name: name of the message.
    """
    return f'id="{escape(field)}" data-fcw-typed="{escape(name)}"'


def is_item(name: str, opens: bool = True) -> str:
    """Attributes of a list element that can be reached with the arrow keys.

    Args:
        name: its name, by which it is found again after the list was redrawn.
        opens: whether a click on it opens something.
    """
    role = ' role="link"' if opens else ""
    return f'data-fcw-item="{escape(name)}" tabindex="0"{role}'


def keeps_scroll(name: str) -> str:
    """The attribute of an element that keeps its scroll position under this name when it is redrawn."""
    return f'data-fcw-scroll="{escape(name)}"'


def slides(element: str, name: str, start: float, end: float) -> str:
    """Attributes of an element on which a click or a drag sends a message with a number.

    Args:
        element: its id, by which it is found again if it is redrawn during a drag.
        name: name of the message.
        start: the number at the left edge of the element.
        end: the number at the right edge.
    """
    return f'id="{escape(element)}" data-fcw-slide="{escape(name)}:{start!r}:{end!r}"'


def slides_along(
    element: str, other: str, name: str, start: float, end: float, *, waits: bool = False
) -> str:
    """The same as `slides` for a small element that is dragged along another one.

    Args:
        element: its id.
        other: id of the other element.
        name: name of the message; a colon and a text may follow, before the number.
        start: the number at the left edge of the other element.
        end: the number at its right edge.
        waits: whether the message is sent only once, when the element is released.
    """
    waiting = " data-fcw-waits" if waits else ""
    return f'{slides(element, name, start, end)} data-fcw-along="{escape(other)}"{waiting}'


def says_size(name: str) -> str:
    """The attribute of an element that sends its size."""
    return f'data-fcw-size="{escape(name)}"'
