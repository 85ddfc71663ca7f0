"""Controls of a tab: choices and clicks are handled in the thread of the tab, in order."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import viser

Run = Callable[[Callable[[], object]], None]
"""Runs work in the thread of the tab."""
Actions = Mapping[str, Callable[[], object]]
"""The actions of the buttons of a group, by label."""


def on_choice(handle: Any, run: Run, choose: Callable[[Any], object]) -> None:  # noqa: ANN401 - any viser input
    """Call `choose` with what the user chose in a list, a box or a slider, not with what the page set."""

    @handle.on_update
    async def _(event: viser.GuiEvent[Any]) -> None:
        if event.client is not None:
            run(partial(choose, event.target.value))


def on_press(group: viser.GuiButtonGroupHandle, run: Run, actions: Actions) -> None:
    """Run the action of a button when it is pressed."""

    @group.on_click
    async def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
        run(actions[event.target.value])


def on_button(button: viser.GuiButtonHandle, run: Run, action: Callable[[], object]) -> None:
    """Run the action when the button is pressed."""

    @button.on_click
    async def _(_: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
        run(action)
