"""Fields in which a number is typed, with or without its unit, or left empty for "not said yet"."""

import asyncio
from collections.abc import Callable
from functools import partial
from html import escape

import viser

from fcw.errors import UserError
from fcw_viz.calibrate_app.quantities import Quantity
from fcw_viz.page.style import set_html, text_block

TYPING_PAUSE_S = 0.6
"""A number counts as typed after this long without a key: the "1" on the way to "15" is none."""
SHOWN_DIGITS = 5
"""Significant digits of a number that was not typed here."""

Run = Callable[[Callable[[], None]], None]


class NumberField:
    """One field: it commits what was typed after a pause, and never writes over what is being typed.

    What is refused stays in the field, marked, with the reason below it, until it is corrected. Everything
    but the keys' arrival happens in one thread, that of `run`.

    Attributes:
        handle: the text input.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        label: str,
        quantity: Quantity,
        run: Run,
        commit: Callable[[float | None], object],
        hint: str | None = None,
    ) -> None:
        """An empty field.

        Args:
            gui: where it is added.
            label: before the field.
            quantity: what is typed in it.
            run: runs work in the thread that owns the field.
            commit: takes the value; a UserError that it raises is the reason below the field.
            hint: what hovering shows.
        """
        self.handle = gui.add_text(label, "", hint=hint)
        self._reason = gui.add_html("", visible=False)
        self._quantity = quantity
        self._commit = commit
        self._shown: float | None = None
        self._unit = 1.0
        self._keys = self._committed_keys = 0
        self._removed = False

        @self.handle.on_update
        async def _(event: viser.GuiEvent[viser.GuiTextHandle]) -> None:
            if event.client is not None:
                self._keys += 1
                asyncio.get_running_loop().call_later(TYPING_PAUSE_S, run, partial(self._paused, self._keys))

    @property
    def visible(self) -> bool:
        """Whether it is seen."""
        return self.handle.visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self.handle.visible = visible
        self._reason.visible = visible and bool(self._reason.content)

    def place(self, order: float) -> None:
        """Put it, with its reason, at a place among its neighbours."""
        self.handle.order, self._reason.order = order, order + 0.5

    def show(self, value: float | None, unit: float = 1.0) -> None:
        """Show a value, unless it is the one shown already or somebody is typing.

        Args:
            value: what the field stands for; None for nothing.
            unit: what a number without a unit counts in, in those of `value`: 0.3048 for feet.
        """
        if self._keys != self._committed_keys or (value, unit) == (self._shown, self._unit):
            return
        same_unit = unit == self._unit
        self._shown, self._unit = value, unit
        self._say("")
        if not (same_unit and self._means_that()):
            self.handle.value = "" if value is None else f"{value / unit:.{SHOWN_DIGITS}g}"

    def flush(self) -> None:
        """Commit what is being typed, without waiting for the pause; nothing where nobody types."""
        if self._removed or self._keys == self._committed_keys:
            return
        self._committed_keys = self._keys
        try:
            typed = self._quantity.read(self.handle.value, self._unit)
            if typed != self._shown:
                self._commit(typed)
        except UserError as error:
            self._say(str(error))
        else:
            self._say("")

    def remove(self) -> None:
        """Take it away, with what is typed in it."""
        self._removed = True
        self.handle.remove()
        self._reason.remove()

    def _paused(self, keys: int) -> None:
        if keys == self._keys:
            self.flush()

    def _means_that(self) -> bool:
        """Whether the text already says the value shown: it stays as it was typed, then."""
        try:
            return self._quantity.read(self.handle.value, self._unit) == self._shown
        except UserError:
            return False

    def _say(self, reason: str) -> None:
        """Say below the field what is wrong with it; nothing takes that back. `fields.js` marks the field."""
        if self._removed:  # by what it committed, or while its pause lasted
            return
        field = escape(self.handle._impl.uuid)
        words = f'<p class="fcw-wrong" role="alert" data-fcw-wrong="{field}">{escape(reason)}</p>'
        set_html(self._reason, text_block(words) if reason else "")
        self._reason.visible = bool(reason) and self.handle.visible


class NumberFields:
    """The fields of a page: what is being typed in one of them counts before anything else that is done."""

    def __init__(self, run: Run) -> None:
        """None yet; `run` is that of each `NumberField`."""
        self._run = run
        self._fields: list[NumberField] = []

    def add(
        self,
        gui: viser.GuiApi,
        label: str,
        quantity: Quantity,
        commit: Callable[[float | None], object],
        hint: str | None = None,
    ) -> NumberField:
        """A new field."""
        field = NumberField(gui, label, quantity, self._run, commit, hint)
        self._fields.append(field)
        return field

    def remove(self, field: NumberField) -> None:
        """Take a field away."""
        self._fields.remove(field)
        field.remove()

    def flush(self) -> None:
        """Commit what is being typed, without waiting for the pause."""
        for field in list(self._fields):
            field.flush()
