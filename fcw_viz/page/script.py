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
    const fields = 'input[type=text], input[type=search], input:not([type])';
    if (leaves && event.target.matches(fields)) event.target.blur();
  });
  document.addEventListener('click', event => {
    const row = event.target.closest?.('[data-key]');
    if (row) document.documentElement.dispatchEvent(
      new KeyboardEvent('keydown', {key: row.dataset.key, code: `Digit${row.dataset.key}`, bubbles: true}));
  });
  const pressed = 'button, select, [role=slider], [role=tab], input[type=checkbox], input[type=radio]';
  document.addEventListener('pointerup', ({target}) => setTimeout(() => {
    const active = document.activeElement;
    if (active && active.matches(pressed) && !active.contains(target.closest('select'))) active.blur();
  }));
}
"""
"""Enter and Escape leave a field, and a button or a slider let go of is left: keys are the page's again. A
click on a row of a table that names a key is that key, as viser's HTML has no events of its own."""
_LAYOUT = Path(__file__).with_name("layout.js").read_text(encoding="utf-8")
_FIELDS = Path(__file__).with_name("fields.js").read_text(encoding="utf-8")


def install(client: viser.ClientHandle, title: str) -> None:
    """Give the page its title, and its fields their manners."""
    run_script(client, _SCRIPT % {"title": json.dumps(title)})
    run_script(client, _LAYOUT)
    run_script(client, _FIELDS)


def focus(client: viser.ClientHandle, field: viser.GuiTextHandle) -> None:
    """Put the cursor in a labelled field, also in one that was added just now."""
    run_script(client, f"window.fcwFocus({json.dumps(field._impl.uuid)});")


def expect_typing(client: viser.ClientHandle, after_click: bool, after_key: str) -> None:
    """Say what asks for a number: digits typed right after it wait for the field.

    Args:
        client: the tab.
        after_click: whether a click on the picture does.
        after_key: the small letter that does; empty for none.
    """
    asks = {"click": after_click, "key": after_key}
    run_script(client, f"window.fcwExpectsTyping = {json.dumps(asks)};")


def expect_no_typing(client: viser.ClientHandle) -> None:
    """What was clicked asks for no number: digits typed since then are keys."""
    run_script(client, "window.fcwNoField();")


def turn_to_tab(client: viser.ClientHandle, name: str) -> None:
    """Open a tab of the panel; `turn_back` leads back."""
    run_script(client, f"window.fcwTurnTo({json.dumps(name)});")


def turn_back(client: viser.ClientHandle, name: str) -> None:
    """Open the tab that was open before `turn_to_tab`, unless somebody has left that one since."""
    run_script(client, f"window.fcwTurnBack({json.dumps(name)});")


def focus_element(client: viser.ClientHandle, element_id: str) -> None:
    """Put the cursor in a field of the page's own HTML."""
    run_script(client, f"document.getElementById({json.dumps(element_id)})?.focus();")


def empty_element(client: viser.ClientHandle, element_id: str, taken: str) -> None:
    """Empty a field of the page's own HTML, unless something else stands there by now than what was taken."""
    run_script(
        client,
        f"const field = document.getElementById({json.dumps(element_id)});"
        f"if (field?.value === {json.dumps(taken)}) {{ field.value = '';"
        "field.dispatchEvent(new Event('input', { bubbles: true })); }",
    )


def note_in_address(client: viser.ClientHandle, name: str, text: str) -> None:
    """Keep a text in the page's address: loaded anew, or sent to somebody, it is there."""
    run_script(
        client,
        "const address = new URL(location);"
        f"address.searchParams.set({json.dumps(name)}, {json.dumps(text)});"
        "history.replaceState(null, '', address);",
    )


def run_script(client: viser.ClientHandle, source: str) -> None:
    """Run JavaScript in the page, after what was sent before."""
    client.gui._websock_interface.queue_message(_messages.RunJavascriptMessage(source))
