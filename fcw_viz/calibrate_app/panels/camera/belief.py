"""Something known of the camera before any click: its field, its uncertainty, its switch, its effect."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import viser

from fcw.camera.calibration import Gaussian
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.document import Belief, Document
from fcw_viz.calibrate_app.document.edits import Edit
from fcw_viz.calibrate_app.document.numbers_text import percent_text, row_distance_text
from fcw_viz.calibrate_app.document.solution import EFFECT_DISTANCE_M
from fcw_viz.calibrate_app.document.state import BeliefEffect, SessionState
from fcw_viz.calibrate_app.quantities import Quantity
from fcw_viz.page.controls import on_choice
from fcw_viz.page.style import set_html, text_block

UNMOVED = 0.0005
"""A smaller relative change would be shown as 0.0 %."""


@dataclass(frozen=True, slots=True)
class BeliefKind:
    """One of the beliefs that are a number.

    Attributes:
        field: of the document, and of the solution's effects.
        label: before its field.
        hint: what hovering shows.
        quantity: what is typed.
        error: what is typed as its uncertainty.
        unit: what a number without a unit counts in, in the document's.
        sigma: its standard deviation until another is typed, in the document's units.
        edit: the edit that states it.
        imperial: label and unit where distances are in feet; None where they are the same.
    """

    field: str
    label: str
    hint: str
    quantity: Quantity
    error: Quantity
    unit: float
    sigma: float
    edit: Callable[[Belief | None], Edit]
    imperial: tuple[str, float] | None = None

    def stated(self, document: Document) -> Belief | None:
        """What the document has."""
        return getattr(document, self.field)


class BeliefControls:
    """A belief's fields: the value, and once there is one its sigma, its switch and its effect."""

    def __init__(self, gui: viser.GuiApi, desk: Desk, kind: BeliefKind) -> None:
        self._desk = desk
        self._kind = kind
        self._value = desk.fields.add(gui, kind.label, kind.quantity, self._typed, hint=kind.hint)
        self._sigma = desk.fields.add(
            gui, "±", kind.error, self._sigma_typed, hint="Uncertainty, as a standard deviation"
        )
        self._used = gui.add_checkbox("Use it", True, visible=False)
        self._words = gui.add_html("")

        on_choice(self._used, desk.run, self._switch)

    def show(self, state: SessionState) -> None:
        """Bring them to a moment of the session."""
        belief = self._kind.stated(state.document)
        label, unit = self._kind.label, self._kind.unit
        if state.document.imperial and self._kind.imperial is not None:
            label, unit = self._kind.imperial
        self._value.handle.label = label
        self._value.show(None if belief is None else belief.prior.value, unit)
        self._sigma.show(None if belief is None else belief.prior.sigma, unit)
        self._sigma.visible = self._used.visible = belief is not None
        self._sigma.handle.label = f"{self._kind.label.split(',')[0]} ±"
        self._used.value = belief is not None and belief.enabled
        words = effect_words(state.solution.effects.get(self._kind.field), state.document)
        set_html(self._words, text_block(f'<p class="dim">{words}</p>') if words else "")

    def _typed(self, value: float | None) -> None:
        belief = self._kind.stated(self._desk.state.document)
        sigma = self._kind.sigma if belief is None else belief.prior.sigma
        self._desk.offer(self._kind.edit(None if value is None else Belief(Gaussian(value, sigma))))

    def _sigma_typed(self, sigma: float | None) -> None:
        belief = self._kind.stated(self._desk.state.document)
        if belief is not None:
            prior = replace(belief.prior, sigma=self._kind.sigma if sigma is None else sigma)
            self._desk.offer(self._kind.edit(replace(belief, prior=prior)))

    def _switch(self, enabled: bool) -> None:
        belief = self._kind.stated(self._desk.state.document)
        if belief is not None:
            self._desk.apply(self._kind.edit(replace(belief, enabled=enabled)))


def effect_words(effect: BeliefEffect | None, document: Document) -> str:
    """What a belief changes, in words; nothing where it is not known."""
    if effect is None or not math.isfinite(effect.error_with):
        return ""
    at = f"At {row_distance_text(EFFECT_DISTANCE_M, document.imperial)}"
    if not math.isfinite(effect.error_without):
        return f"{at}: ± {percent_text(effect.error_with)} with it; without it, nothing is determined."
    moves = (
        "leaves that distance where it is"
        if abs(effect.shift) < UNMOVED
        else f"moves that distance by {effect.shift:+.1%}"
    )
    return (
        f"{at}: ± {percent_text(effect.error_with)} with it, ± {percent_text(effect.error_without)} without; "
        f"it {moves}."
    )
