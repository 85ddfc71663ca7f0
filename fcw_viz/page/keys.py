"""Keys of a page: each does what some button or drag does, and stands in viser's command palette."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import viser

from fcw_viz.page.controls import Run

ZOOM_STEP = 1.4


class Key(NamedTuple):
    """A command with its key.

    Attributes:
        label: what it does, in the palette.
        key: as viser names it.
        modifier: held with it; None for none.
        action: what it does.
    """

    label: str
    key: str
    modifier: str | None
    action: Callable[[], object]


def picture_keys(fit: Callable[[], object], zoom: Callable[[float], object]) -> tuple[Key, ...]:
    """The keys of a picture: `fit` shows the whole of it, `zoom` makes it larger by a factor."""

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
    """Register keys in a tab; `run` does their work in the tab's thread."""
    for key in keys:
        # viser's type lists letters and a few names; its browser side takes every key.
        hotkey: Any = key.key
        modifier: Any = key.modifier
        command = gui.add_command(key.label, hotkey=hotkey, modifier=modifier)

        @command.on_trigger
        async def _(_event: viser.CommandEvent, action: Callable[[], object] = key.action) -> None:
            run(action)


def help_table(rows: Iterable[tuple[str, str]]) -> str:
    """Keys and what they do, as an HTML table."""
    cells = "".join(
        f"<tr><td><kbd>{keys}</kbd></td><td style='text-align:left;white-space:normal'>{words}</td></tr>"
        for keys, words in rows
    )
    return f"<table>{cells}</table>"
