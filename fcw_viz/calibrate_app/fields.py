"""Fields in which a number is typed: with a comma or a point, or left empty for "not said yet"."""

import asyncio
import contextlib
import math
from collections.abc import Callable
from functools import partial

import viser

from fcw.errors import UserError

TYPING_PAUSE_S = 0.6
"""A number counts as typed after this long without a key: the "1" on the way to "15" is none."""
REFUSED_S = 4.0
"""What was refused stays so long, to be corrected; then the field says again what counts."""
SHOWN_DIGITS = 5
"""Significant digits of a number that was not typed here."""


def parse_number(text: str) -> float | None:
    """The number of a text; None for an empty one.

    Raises:
        UserError: it is not a number.
    """
    text = text.strip().replace(",", ".")
    if not text:
        return None
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise UserError(f"{text!r} is not a number; type one such as 6 or 4.5, or leave the field empty")
    return number


class NumberField:
    """One field: it commits what was typed after a pause, and never writes over what is being typed.

    Everything but the keys' arrival happens in one thread, that of `run`.

    Attributes:
        handle: the text input.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        label: str,
        run: Callable[[Callable[[], None]], None],
        commit: Callable[[float | None], object],
        refuse: Callable[[UserError], object],
        hint: str | None = None,
    ) -> None:
        """An empty field.

        Args:
            gui: where it is added.
            label: before the field.
            run: runs work in the thread that owns the field.
            commit: takes the number, in metres, pixels or whatever `show` was given.
            refuse: takes what is wrong with a text that is no number; the text stays, to be corrected.
            hint: what hovering shows.
        """
        self.handle = gui.add_text(label, "", hint=hint)
        self._commit = commit
        self._refuse = refuse
        self._shown: float | None = None
        self._unit = 1.0
        self._keys = self._committed_keys = 0

        @self.handle.on_update
        async def _(event: viser.GuiEvent[viser.GuiTextHandle]) -> None:
            if event.client is not None:
                self._keys += 1
                loop = asyncio.get_running_loop()
                loop.call_later(TYPING_PAUSE_S, run, partial(self._paused, self._keys))
                loop.call_later(REFUSED_S, run, partial(self._settle, self._keys))

    def show(self, value: float | None, unit: float = 1.0) -> None:
        """Show a value, unless it is the one shown already or somebody is typing.

        Args:
            value: what the field stands for; None for nothing.
            unit: what one of the typed units is, in those of `value`: 0.3048 for feet.
        """
        if self._keys != self._committed_keys or (value, unit) == (self._shown, self._unit):
            return
        same_unit = unit == self._unit
        self._shown, self._unit = value, unit
        self._write(keep_typed=same_unit)

    def flush(self) -> None:
        """Commit what is being typed, without waiting for the pause; nothing where nobody types."""
        if self._keys == self._committed_keys:
            return
        self._committed_keys = self._keys
        try:
            typed = self._typed()
        except UserError as error:
            self._refuse(error)
            return
        if typed != self._shown:
            self._commit(typed)

    def _paused(self, keys: int) -> None:
        if keys == self._keys:
            self.flush()

    def _settle(self, keys: int) -> None:
        if keys == self._keys:
            self._write(keep_typed=True)

    def _write(self, keep_typed: bool) -> None:
        """Write the value shown, unless the text means that already."""
        with contextlib.suppress(UserError):
            if keep_typed and self._typed() == self._shown:
                return
        shown = self._shown
        self.handle.value = "" if shown is None else f"{shown / self._unit:.{SHOWN_DIGITS}g}"

    def _typed(self) -> float | None:
        number = parse_number(self.handle.value)
        return None if number is None else number * self._unit


class NumberFields:
    """The fields of a page: what is being typed in one of them counts before anything else that is done."""

    def __init__(
        self, run: Callable[[Callable[[], None]], None], refuse: Callable[[UserError], object]
    ) -> None:
        """None yet; `run` and `refuse` are those of each `NumberField`."""
        self._run = run
        self._refuse = refuse
        self._fields: list[NumberField] = []

    def add(
        self,
        gui: viser.GuiApi,
        label: str,
        commit: Callable[[float | None], object],
        hint: str | None = None,
    ) -> NumberField:
        """A new field."""
        field = NumberField(gui, label, self._run, commit, self._refuse, hint)
        self._fields.append(field)
        return field

    def remove(self, field: NumberField) -> None:
        """Take a field away."""
        self._fields.remove(field)
        field.handle.remove()

    def flush(self) -> None:
        """Commit what is being typed, without waiting for the pause."""
        for field in list(self._fields):
            field.flush()
