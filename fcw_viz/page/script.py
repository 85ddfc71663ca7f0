"""What the page does in the browser that viser has no call for."""

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
"""Enter and Escape leave a field, and a button or slider loses the focus when it is released, so that keys
belong to the page again. A click on a table row with a key presses that key, because viser's HTML has no
events."""
_LAYOUT = Path(__file__).with_name("layout.js").read_text(encoding="utf-8")
_FIELDS = Path(__file__).with_name("fields.js").read_text(encoding="utf-8")


def install(client: viser.ClientHandle, title: str) -> None:
    """Set the title of the page, and how its fields handle keys."""
    run_script(client, _SCRIPT % {"title": json.dumps(title)})
    run_script(client, _LAYOUT)
    run_script(client, _FIELDS)


def focus(client: viser.ClientHandle, field: viser.GuiTextHandle) -> None:
    """Put the cursor into a labelled field, also one that was just added."""
    run_script(client, f"window.fcwFocus({json.dumps(field._impl.uuid)});")


def expect_typing(client: viser.ClientHandle, after_click: bool, after_key: str) -> None:
    """Set what asks for a number, so that digits typed right after it wait for the field.

    Args:
        client: the tab.
        after_click: whether a click on the picture asks for a number.
        after_key: the lower-case letter that asks for a number; empty for none.
    """
    asks = {"click": after_click, "key": after_key}
    run_script(client, f"window.fcwExpectsTyping = {json.dumps(asks)};")


def expect_no_typing(client: viser.ClientHandle) -> None:
    """Treat digits typed since the last click as keys, because the click asks for no number."""
    run_script(client, "window.fcwNoField();")


def turn_to_tab(client: viser.ClientHandle, name: str) -> None:
    """Open a tab of the panel; `turn_back` goes back."""
    run_script(client, f"window.fcwTurnTo({json.dumps(name)});")


def turn_back(client: viser.ClientHandle, name: str) -> None:
    """Open the tab that was open before `turn_to_tab`, unless the user has changed the tab since."""
    run_script(client, f"window.fcwTurnBack({json.dumps(name)});")


def focus_element(client: viser.ClientHandle, element_id: str) -> None:
    """Put the cursor into a field of the page's own HTML."""
    run_script(client, f"document.getElementById({json.dumps(element_id)})?.focus();")


def empty_element(client: viser.ClientHandle, element_id: str, taken: str) -> None:
    """Clear a field of the page's own HTML, unless its text has changed since it was taken."""
    run_script(
        client,
        f"const field = document.getElementById({json.dumps(element_id)});"
        f"if (field?.value === {json.dumps(taken)}) {{ field.value = '';"
        "field.dispatchEvent(new Event('input', { bubbles: true })); }",
    )


def note_in_address(client: viser.ClientHandle, name: str, text: str) -> None:
    """Write a text into the address of the page, so that a reload or a copied address contains it."""
    run_script(
        client,
        "const address = new URL(location);"
        f"address.searchParams.set({json.dumps(name)}, {json.dumps(text)});"
        "history.replaceState(null, '', address);",
    )


def run_script(client: viser.ClientHandle, source: str) -> None:
    """Run JavaScript in the page, after what was sent before."""
    client.gui._websock_interface.queue_message(_messages.RunJavascriptMessage(source))
