"""Keys of a page: each does what some button or drag does, and stands in viser's command palette."""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, Generic, NamedTuple, TypeVar

import viser

ZOOM_STEP = 1.4

Tab = TypeVar("Tab")


class Key(NamedTuple, Generic[Tab]):
    """A command with its key.

    Attributes:
        label: what it does, in the palette.
        key: as viser names it.
        modifier: held with it; None for none.
        action: what it does, in a tab.
    """

    label: str
    key: str
    modifier: str | None
    action: Callable[[Tab], object]


def add_keys(
    gui: viser.GuiApi, tab: Tab, keys: Iterable[Key[Tab]], run: Callable[[Callable[[], object]], None]
) -> None:
    """Register keys in a tab; `run` does their work in the tab's thread."""
    for key in keys:
        # viser's type lists letters and a few names; its browser side takes every key.
        hotkey: Any = key.key
        modifier: Any = key.modifier
        command = gui.add_command(key.label, hotkey=hotkey, modifier=modifier)

        @command.on_trigger
        async def _(_event: viser.CommandEvent, action: Callable[[Tab], object] = key.action) -> None:
            run(partial(action, tab))


def help_table(rows: Iterable[tuple[str, str]]) -> str:
    """Keys and what they do, as an HTML table."""
    cells = "".join(
        f"<tr><td><kbd>{keys}</kbd></td><td style='text-align:left;white-space:normal'>{words}</td></tr>"
        for keys, words in rows
    )
    return f"<table>{cells}</table>"
