"""The keys of a page; each does the same as a button or drag, and is listed in viser's command palette."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import viser

from fcw_viz.page.controls import Run

ZOOM_STEP = 1.4


class Key(NamedTuple):
    """A command with its key.

    Attributes:
        label: its description in the palette.
        key: its name in viser.
        modifier: the modifier to hold; None for none.
        action: what it does.
    """

    label: str
    key: str
    modifier: str | None
    action: Callable[[], object]


def picture_keys(fit: Callable[[], object], zoom: Callable[[float], object]) -> tuple[Key, ...]:
    """The keys of a picture: `fit` shows all of it, `zoom` enlarges it by a factor."""

    def larger() -> None:
        zoom(ZOOM_STEP)

    return (
        Key("Whole picture", "F", None, fit),
        Key("Zoom in", "=", None, larger),
        Key("Zoom in", "[plus]", None, larger),
        Key("Zoom in", "[plus]", "shift", larger),
        Key("Zoom out", "-", None, lambda: zoom(1 / ZOOM_STEP)),
    )


def add_keys(gui: viser.GuiApi, run: Run, keys: Iterable[Key]) -> None:
    """Register keys in a tab; `run` runs their actions in the thread of the tab."""
    for key in keys:
        # viser's type lists letters and a few names; its browser side takes every key.
        hotkey: Any = key.key
        modifier: Any = key.modifier
        command = gui.add_command(key.label, hotkey=hotkey, modifier=modifier)

        @command.on_trigger
        async def _(_event: viser.CommandEvent, action: Callable[[], object] = key.action) -> None:
            run(action)


def help_table(rows: Iterable[tuple[str, str]]) -> str:
    """An HTML table of keys and what they do."""
    cells = "".join(
        f"<tr><td><kbd>{keys}</kbd></td><td style='text-align:left;white-space:normal'>{words}</td></tr>"
        for keys, words in rows
    )
    return f"<table>{cells}</table>"
