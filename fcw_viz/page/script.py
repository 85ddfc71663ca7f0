"""What the page itself has to do in the browser, which viser has no call for."""

import json
from pathlib import Path

import viser
from viser import _messages  # RunJavascriptMessage is how viser itself loads plotly; it has no public call

_SCRIPT = """
document.title = %(title)s;
if (!window.fcwManners) {
  window.fcwManners = true;
  document.addEventListener('keydown', event => {
    const leaves = event.key === 'Enter' || event.key === 'Escape';
    if (leaves && event.target.matches('input[type=text], input:not([type])')) event.target.blur();
  });
  document.addEventListener('click', event => {
    const row = event.target.closest?.('[data-key]');
    if (row) document.documentElement.dispatchEvent(
      new KeyboardEvent('keydown', {key: row.dataset.key, code: `Digit${row.dataset.key}`, bubbles: true}));
  });
  document.addEventListener('pointerup', () => setTimeout(() => {
    const active = document.activeElement;
    if (active && active.matches('[role=slider], input[type=checkbox]')) active.blur();
  }));
}
"""
"""Enter and Escape leave a field, and a slider or a box let go of is left: keys are the page's again. A click
on a row of a table that names a key is that key, as viser's HTML has no events of its own."""
_FIELDS = Path(__file__).with_name("fields.js").read_text()
FOCUS_TRIES = 20
"""The browser builds a new field a moment after it was told to."""


def install(client: viser.ClientHandle, title: str) -> None:
    """Give the page its title, and its fields their manners."""
    run_script(client, _SCRIPT % {"title": json.dumps(title)})
    run_script(client, _FIELDS)


def focus(client: viser.ClientHandle, field: viser.GuiTextHandle) -> None:
    """Put the cursor in a labelled field, also in one that was added just now."""
    run_script(client, f"window.fcwFocus({json.dumps(field._impl.uuid)}, {FOCUS_TRIES});")


def expect_typing(client: viser.ClientHandle, expected: bool) -> None:
    """Whether a click on the picture asks for a number: digits typed after it wait for the field."""
    run_script(client, f"window.fcwExpectsTyping = {json.dumps(expected)};")


def focus_element(client: viser.ClientHandle, element_id: str) -> None:
    """Put the cursor in a field of the page's own HTML."""
    run_script(client, f"document.getElementById({json.dumps(element_id)})?.focus();")


def run_script(client: viser.ClientHandle, source: str) -> None:
    """Run JavaScript in the page, after what was sent before."""
    client.gui._websock_interface.queue_message(_messages.RunJavascriptMessage(source))
