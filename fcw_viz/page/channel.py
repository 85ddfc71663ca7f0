"""From the page's own HTML and SVG to the server: viser's HTML has no events of its own.

Elements say by attributes what a click or a drag on them means (`page_channel.js`); a script in the browser
sends it through a hidden field.
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
    """Messages of one tab's page: a name and, after a colon, what it is about.

    Besides those of the page's elements there are `asked:` and `ready:`, once the script runs, with what the
    address says after `asked=` and `at=`, `size:<name> <width>x<height>` of elements that say
    `data-fcw-size="<name>"`, and `docked:` when the panel has a dock again, of viser's own width, after the
    window was too narrow for one.
    """

    def __init__(self, client: viser.ClientHandle, run: Run) -> None:
        """Nothing is heard before `open`.

        Args:
            client: the browser's side.
            run: runs work in the tab's thread, in order.
        """
        self._client = client
        self._run = run
        self._on_message: dict[str, tuple[OnMessage, Run]] = {}

    def on(self, name: str, callback: OnMessage, run: Run | None = None) -> None:
        """Calls back with what a message of that name is about.

        Args:
            name: of the message.
            callback: raises ValueError, LookupError or OverflowError where the page never says such a thing.
            run: runs it, in the place of the channel's own.
        """
        self._on_message[name] = callback, run or self._run

    def open(self) -> None:
        """Starts to listen; what is heard has its callbacks by now."""
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
    """The attribute of an element on which a click is a message."""
    return f'data-fcw="{escape(message)}"'


def leads_to(tab: str, place: str) -> str:
    """The attribute of an element on which a click shows a place of the page, see `is_place`."""
    return f'data-fcw-goto="{escape(f"{tab}/{place}")}"'


def is_place(place: str) -> str:
    """The attribute of an element that `leads_to` leads to."""
    return f'data-fcw-place="{escape(place)}"'


def chooses(name: str) -> str:
    """The attribute of a `select` whose chosen value is a message of that name."""
    return f'data-fcw-choice="{escape(name)}"'


def enters(field: str, name: str, key: str = "") -> str:
    """Attributes of an input whose text is a message of that name when Enter is pressed.

    Args:
        field: its id, by which `script.empty_element` empties it once the text is taken.
        name: of the message.
        key: a small letter that puts the cursor in it; empty for none.
    """
    by_key = f' data-fcw-key="{escape(key)}"' if key else ""
    return f'id="{escape(field)}" data-fcw-enter="{escape(name)}"{by_key}'


def tells_typed(field: str, name: str) -> str:
    """Attributes of an input whose text is a message of that name while it is typed.

    Args:
        field: its id.
        name: of the message.
    """
    return f'id="{escape(field)}" data-fcw-typed="{escape(name)}"'


def is_item(name: str, opens: bool = True) -> str:
    """Attributes of an element of a list that keys lead to, and from there to the one before or after it.

    Args:
        name: by which it is found again when the list is drawn anew.
        opens: whether a click on it opens something; else it is only read.
    """
    role = ' role="link"' if opens else ""
    return f'data-fcw-item="{escape(name)}" tabindex="0"{role}'


def keeps_scroll(name: str) -> str:
    """The attribute of an element that, drawn anew, stays scrolled to where it was under that name."""
    return f'data-fcw-scroll="{escape(name)}"'


def slides(element: str, name: str, start: float, end: float) -> str:
    """Attributes of an element along which a click or a drag is a message with a number.

    Args:
        element: its id, by which it is found again when it is drawn anew during a drag.
        name: of the message.
        start: the number at the element's left edge.
        end: the number at its right edge.
    """
    return f'id="{escape(element)}" data-fcw-slide="{escape(name)}:{start!r}:{end!r}"'


def slides_along(
    element: str, other: str, name: str, start: float, end: float, *, waits: bool = False
) -> str:
    """As `slides`, for a small element that is dragged along another one, whose edges the numbers are of.

    Args:
        element: its id.
        other: the other one's.
        name: of the message; after a colon there may be what it is about, before the number.
        start: the number at the other one's left edge.
        end: the number at its right edge.
        waits: the message is sent once, when the element is let go of.
    """
    waiting = " data-fcw-waits" if waits else ""
    return f'{slides(element, name, start, end)} data-fcw-along="{escape(other)}"{waiting}'


def says_size(name: str) -> str:
    """The attribute of an element that tells its size."""
    return f'data-fcw-size="{escape(name)}"'
