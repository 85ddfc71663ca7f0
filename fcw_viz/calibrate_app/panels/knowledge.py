"""What else is known: the lens, the horizon, two lane lines, each a switch with its effect; the clicks."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import viser

from fcw.camera.calibration import Gaussian
from fcw.camera.prior_sigmas import (
    FIELD_OF_VIEW_SIGMA_DEG,
    HORIZON_ROW_SIGMA_PX,
    PRINCIPAL_ROW_SIGMA_HEIGHTS,
)
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.document import Belief, Document, Line
from fcw_viz.calibrate_app.document.edits import (
    Edit,
    EnableLaneLines,
    SetFieldOfView,
    SetHorizon,
    SetLaneLine,
    SetPrincipalRow,
    SetRowSigma,
)
from fcw_viz.calibrate_app.document.numbers_text import percent_text, row_distance_text
from fcw_viz.calibrate_app.document.solution import EFFECT_DISTANCE_M
from fcw_viz.calibrate_app.document.state import BeliefEffect, SessionState
from fcw_viz.calibrate_app.tools import Tool
from fcw_viz.page.controls import on_choice, on_press
from fcw_viz.page.style import set_html, text_block

UNMOVED = 0.0005
"""A smaller relative change would be shown as 0.0 %."""
DRAG_HORIZON, DRAW_LINES, CLEAR = "Drag the horizon", "Draw two lane lines", "Remove them"
FIRST_WORDS = '<p class="dim">Each of these makes far distances better, or stands in for a point.</p>'
HORIZON_WORDS = "Drag the horizon to where a flat, straight road would end, or click there. Esc when done."
LINE_WORDS = (
    "Click a point of the left lane marking, near the bottom of the picture.",
    "Click the left marking again, far away.",
    "Click a point of the right lane marking, near the bottom of the picture.",
    "Click the right marking again, far away.",
)


@dataclass(frozen=True, slots=True)
class _BeliefKind:
    """One of the beliefs that are a number.

    Attributes:
        field: of the document, and of the solution's effects.
        label: before its field.
        hint: what hovering shows.
        unit: what one of the typed units is in the document's.
        sigma: its standard deviation until another is typed, in the document's units.
        edit: the edit that states it.
    """

    field: str
    label: str
    hint: str
    unit: float
    sigma: float
    edit: Callable[[Belief | None], Edit]

    def stated(self, document: Document) -> Belief | None:
        """What the document has."""
        return getattr(document, self.field)


class KnowledgePanel:
    """Field of view, principal row, horizon and lane lines."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        height_px = desk.pictures.image_size.height
        gui.add_html(text_block(FIRST_WORDS))
        self._beliefs = [
            _BeliefControls(gui, desk, kind)
            for kind in (
                _BeliefKind(
                    "field_of_view",
                    "Field of view, °",
                    "Of the whole picture from left to right, as the lens's data sheet has it",
                    math.radians(1),
                    math.radians(FIELD_OF_VIEW_SIGMA_DEG),
                    SetFieldOfView,
                ),
                _BeliefKind(
                    "principal_row",
                    "Lens axis, row",
                    f"Row that the lens looks at: {(height_px - 1) / 2:g}, unless the picture was cropped",
                    1.0,
                    PRINCIPAL_ROW_SIGMA_HEIGHTS * height_px,
                    SetPrincipalRow,
                ),
                _BeliefKind(
                    "horizon",
                    "Horizon, row",
                    "Where a flat road would end",
                    1.0,
                    HORIZON_ROW_SIGMA_PX,
                    SetHorizon,
                ),
            )
        ]
        self._horizon = gui.add_button_group("", (DRAG_HORIZON,))
        self._lines = gui.add_button_group("", (DRAW_LINES, CLEAR))
        self._lines_used = gui.add_checkbox("Use them", False, visible=False)
        self._lines_words = gui.add_html("")
        self._sigma = desk.fields.add(
            gui,
            "Click error, px",
            lambda sigma_px: sigma_px is not None and desk.apply(SetRowSigma(sigma_px)),
            hint="Standard deviation of a click in rows: about 1 at fit, 0.3 where you zoomed in",
        )
        self._line_start: tuple[float, float] | None = None

        on_press(
            self._horizon,
            desk.run,
            {DRAG_HORIZON: lambda: desk.use(Tool.HORIZON, self._horizon_clicked, HORIZON_WORDS)},
        )
        on_choice(self._lines_used, desk.run, lambda enabled: desk.apply(EnableLaneLines(enabled)))
        on_press(self._lines, desk.run, {DRAW_LINES: self._draw_lines, CLEAR: self._clear_lines})

    def show(self, state: SessionState) -> None:
        """Bring the switches to a moment of the session."""
        for controls in self._beliefs:
            controls.show(state)
        self._sigma.show(state.document.row_sigma_px)
        drawn = any(line is not None for line in state.document.lane_lines)
        self._lines_used.visible = drawn
        self._lines_used.value = state.document.lane_lines_enabled
        horizon = state.solution.lane_horizon
        words = "" if horizon is None else f"They meet at row {horizon.value:.1f} ± {horizon.sigma:.1f}. "
        effect = effect_words(state.solution.effects.get("lane_lines"), state.document)
        set_html(self._lines_words, text_block(f'<p class="dim">{words}{effect}</p>') if words else "")

    def _horizon_clicked(self, _: float, row_px: float) -> None:
        believed = self._desk.state.document.horizon
        sigma_px = HORIZON_ROW_SIGMA_PX if believed is None else believed.prior.sigma
        self._desk.apply(SetHorizon(Belief(Gaussian(row_px, sigma_px))))

    def _draw_lines(self) -> None:
        self._line_start = None
        self._desk.use(Tool.LANE_LINES, partial(self._line_clicked, 0), LINE_WORDS[0])

    def _line_clicked(self, step: int, column_px: float, row_px: float) -> None:
        """The clicks of the tool in turn: start and end of the left line, start and end of the right one."""
        index, is_end = divmod(step, 2)
        if not is_end:
            self._line_start = (column_px, row_px)
        elif self._line_start is not None:
            line = Line(self._line_start, (column_px, row_px))
            if not self._desk.apply(SetLaneLine(index, line)):
                return
        if step + 1 < len(LINE_WORDS):
            self._desk.use(Tool.LANE_LINES, partial(self._line_clicked, step + 1), LINE_WORDS[step + 1])
        else:
            self._desk.use(Tool.POINTS)

    def _clear_lines(self) -> None:
        self._desk.apply(SetLaneLine(0, None), SetLaneLine(1, None))


class _BeliefControls:
    """A belief's fields: the value, and once there is one its sigma, its switch and its effect."""

    def __init__(self, gui: viser.GuiApi, desk: Desk, kind: _BeliefKind) -> None:
        self._desk = desk
        self._kind = kind
        self._value = desk.fields.add(gui, kind.label, self._typed, hint=kind.hint)
        self._sigma = desk.fields.add(
            gui, "± (1 sigma)", self._sigma_typed, hint="How uncertain it is: its standard deviation"
        )
        self._used = gui.add_checkbox("Use it", True, visible=False)
        self._words = gui.add_html("")

        on_choice(self._used, desk.run, self._switch)

    def show(self, state: SessionState) -> None:
        """Bring them to a moment of the session."""
        belief = self._kind.stated(state.document)
        self._value.show(None if belief is None else belief.prior.value, self._kind.unit)
        self._sigma.show(None if belief is None else belief.prior.sigma, self._kind.unit)
        self._sigma.handle.visible = self._used.visible = belief is not None
        self._used.value = belief is not None and belief.enabled
        words = effect_words(state.solution.effects.get(self._kind.field), state.document)
        set_html(self._words, text_block(f'<p class="dim">{words}</p>') if words else "")

    def _typed(self, value: float | None) -> None:
        belief = self._kind.stated(self._desk.state.document)
        sigma = self._kind.sigma if belief is None else belief.prior.sigma
        self._desk.apply(self._kind.edit(None if value is None else Belief(Gaussian(value, sigma))))

    def _sigma_typed(self, sigma: float | None) -> None:
        belief = self._kind.stated(self._desk.state.document)
        if belief is not None:
            prior = replace(belief.prior, sigma=self._kind.sigma if sigma is None else sigma)
            self._desk.apply(self._kind.edit(replace(belief, prior=prior)))

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
        return f"{at}: ± {percent_text(effect.error_with)} with it; without it nothing is determined."
    moves = (
        "leaves that distance where it is"
        if abs(effect.shift) < UNMOVED
        else f"moves that distance by {effect.shift:+.1%}"
    )
    return (
        f"{at}: ± {percent_text(effect.error_with)} with it, ± {percent_text(effect.error_without)} without; "
        f"it {moves}."
    )
