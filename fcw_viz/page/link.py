"""The link between a page and its program: what the page says and does when that is away, or has ended."""

import json
from pathlib import Path

import viser

from fcw_viz.page.script import run_script

_BROWSER_SIDE = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


def watch_link(client: viser.ClientHandle) -> None:
    """Have the page say when the program does not answer, and come back when it does."""
    run_script(client, _BROWSER_SIDE)


def say_goodbye(client: viser.ClientHandle, words: str) -> None:
    """Have the page say that the program ends; it closes the connection once it has."""
    run_script(client, f"window.fcwLink.ended({json.dumps(words)});")
    client.flush()
