"""Controls of a tab: what somebody chooses or presses is done in the tab's own thread, in order."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import viser

Run = Callable[[Callable[[], object]], None]
"""Runs work in the tab's thread."""
Actions = Mapping[str, Callable[[], object]]
"""What the buttons of a group do, by their labels."""


def on_choice(handle: Any, run: Run, choose: Callable[[Any], object]) -> None:  # noqa: ANN401 - any viser input
    """Call `choose` with what somebody chose in a list, a box or a slider, not with what the page set."""

    @handle.on_update
    async def _(event: viser.GuiEvent[Any]) -> None:
        if event.client is not None:
            run(partial(choose, event.target.value))


def on_press(group: viser.GuiButtonGroupHandle, run: Run, actions: Actions) -> None:
    """Do the action of the button that is pressed."""

    @group.on_click
    async def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
        run(actions[event.target.value])


def on_button(button: viser.GuiButtonHandle, run: Run, action: Callable[[], object]) -> None:
    """Do the action when the button is pressed."""

    @button.on_click
    async def _(_: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
        run(action)
