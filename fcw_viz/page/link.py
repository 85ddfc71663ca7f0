"""The link between a page and its program: what the page does when the program is away or has ended."""

import json
from pathlib import Path

import viser

from fcw_viz.page.script import run_script

_BROWSER_SIDE = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


def watch_link(client: viser.ClientHandle) -> None:
    """Make the page show when the program does not answer, and return when it does."""
    run_script(client, _BROWSER_SIDE)


def say_goodbye(client: viser.ClientHandle, words: str) -> None:
    """Make the page show that the program ends; the page then closes the connection."""
    run_script(client, f"window.fcwLink.ended({json.dumps(words)});")
    client.flush()
