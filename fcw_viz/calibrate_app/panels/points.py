"""Step 2 of the job: the points in a table, with a field for the distance of each."""

import math
from html import escape

import viser

from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.besides.knowledge import SetTapeError
from fcw_viz.calibrate_app.document.document import Document, Mark
from fcw_viz.calibrate_app.document.edits import SetDistance, SetRowSigma
from fcw_viz.calibrate_app.document.numbers_text import in_units, unit_name
from fcw_viz.calibrate_app.document.state import MarkResidual, SessionState
from fcw_viz.calibrate_app.document.ways.ways import Part, Way, chosen_way
from fcw_viz.calibrate_app.drawing.figures import residual_bar
from fcw_viz.calibrate_app.fields import NumberField
from fcw_viz.calibrate_app.keys import NUMBER_KEYS
from fcw_viz.calibrate_app.panels.preset import PresetPanel
from fcw_viz.calibrate_app.panels.result import rounded
from fcw_viz.calibrate_app.quantities import DISTANCE, ROW_ERROR, TAPE
from fcw_viz.page.controls import on_press
from fcw_viz.page.script import focus
from fcw_viz.page.style import set_html, step_heading, text_block

MINIMUM_POINTS = 3
SWITCH, DELETE, GO_TO = "On / off", "Delete", "Go to picture"
UNDO, REDO = "Undo", "Redo"
EXACT_WORDS = "Three points always fit; a fourth shows errors."


class PointsPanel:
    """The points, a field for each distance, and what can be done with the selected one."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._gui = gui
        self._desk = desk
        self._heading = gui.add_html("")
        self._preset = PresetPanel(gui, desk)
        self._table = gui.add_html("")
        self._folder = gui.add_folder(None)
        self._fields: dict[int, NumberField] = {}
        actions = {
            UNDO: desk.undo,
            REDO: desk.redo,
            SWITCH: desk.switch_selected,
            DELETE: desk.delete_selected,
            GO_TO: desk.go_to_selected,
        }
        self._actions = gui.add_button_group("", tuple(actions), visible=False)
        self._sigma = desk.fields.add(
            gui,
            "Click error, px",
            ROW_ERROR,
            lambda sigma_px: sigma_px is not None and desk.offer(SetRowSigma(sigma_px)),
            hint="Standard deviation of a click in rows: about 1 unzoomed, 0.3 zoomed in",
        )
        self._tape = desk.fields.add(
            gui,
            "Tape error, %",
            TAPE,
            lambda part: part is not None and desk.offer(SetTapeError(part)),
            hint=(
                "How far off all distances may be together, and each by itself by a quarter of that: 1 is "
                "usual"
            ),
        )
        on_press(self._actions, desk.run, actions)

    def show(self, state: SessionState) -> None:
        """Bring table and fields to a moment of the session."""
        document = state.document
        counted = sum(mark.ground_point is not None for mark in document.marks)
        # Fewer do where the lens and the horizon are known besides.
        enough = counted >= MINIMUM_POINTS or (counted > 0 and state.solution.result is not None)
        done = "done" if enough else "now"
        way = chosen_way(document)
        needed = way is None or Part.POINTS in way.parts
        note = f"{counted} points" if enough else f"{counted} of at least {MINIMUM_POINTS}"
        if counted == 1 and enough:
            note = "1 point"
        if not needed:
            done, note = ("done", note) if counted else ("", "none needed")
        heading = step_heading(2, "Points on the road", done, note)
        # A rectangle or plates take the place of the points until there are some.
        set_html(self._heading, "" if _has_own_marks(way) and not document.marks else heading)
        self._sigma.visible = counted > 0
        self._sigma.show(document.row_sigma_px)
        self._tape.visible = counted > 0
        self._tape.show(document.tape_error, 0.01)
        self._preset.show(state)
        set_html(self._table, text_block(self._table_html(state)) if document.marks else "")
        self._actions.visible = bool(document.marks) or state.can_undo or state.can_redo
        self._show_fields(state)

    def focus_on(self, mark_id: int) -> None:
        """Put the cursor in the field of a mark, so that its distance can be typed at once."""
        if mark_id in self._fields:
            focus(self._desk.client, self._fields[mark_id].handle)

    def _show_fields(self, state: SessionState) -> None:
        imperial = state.document.imperial
        ids = {mark.id for mark in state.document.marks}
        for gone in set(self._fields) - ids:
            self._desk.fields.remove(self._fields.pop(gone))
        for mark in state.document.marks:
            if mark.id not in self._fields:
                with self._folder:
                    self._fields[mark.id] = self._new_field(mark)
            field = self._fields[mark.id]
            first = _first_dash(state.document)
            label = f"{mark.name}, {'feet' if imperial else 'metres'}"
            if first is not None:
                label = f"{mark.name}, {unit_name(imperial)} after {first.name}"
            field.handle.label = label
            field.place(mark.id)
            distance_m = mark.distance_m
            if first is not None and first.distance_m is not None and distance_m is not None:
                distance_m -= first.distance_m
            # Where the dashes begin follows from the rest.
            field.visible = first is None or mark.id != first.id
            field.show(distance_m, 1 / FEET_PER_METRE if imperial else 1.0)

    def _new_field(self, mark: Mark) -> NumberField:
        def commit(distance_m: float | None) -> None:
            first = _first_dash(self._desk.state.document)
            if first is not None and first.distance_m is not None and distance_m is not None:
                distance_m += first.distance_m
            self._desk.offer(SetDistance(mark.id, distance_m))

        hint = f"Distance of {mark.name} along the road; leave it empty while unknown"
        return self._desk.fields.add(self._gui, mark.name, DISTANCE, commit, hint)

    def _table_html(self, state: SessionState) -> str:
        troubled = {mark_id for trouble in state.solution.troubles for mark_id in trouble.mark_ids}
        result = state.solution.result
        residuals = {} if result is None else result.residuals
        exact = result is not None and result.exact
        unit = unit_name(state.document.imperial)
        lines = [f"<tr><th></th><th>row</th><th>column</th><th colspan=3>error, px and {unit}</th></tr>"]
        for number, mark in enumerate(state.document.marks, 1):
            classes = {
                "selected": mark.id == self._desk.selected,
                "off": not mark.enabled,
                "trouble": mark.id in troubled,
            }
            residual = None if exact else residuals.get(mark.id)
            lines.append(
                f'<tr class="{" ".join(name for name, holds in classes.items() if holds)}"{_key(number)}>'
                f"<td>{'⚠ ' if mark.id in troubled else ''}{escape(mark.name)}</td>"
                f"<td>{mark.row_px:.1f}</td><td>{mark.column_px:.1f}</td>"
                + _residual_cells(residual, state.document.row_sigma_px, state.document.imperial)
                + "</tr>"
            )
        words = f'<p class="dim">{EXACT_WORDS}</p>' if exact else ""
        return f"<table>{''.join(lines)}</table>{words}"


def _has_own_marks(way: Way | None) -> bool:
    return way is not None and not {Part.RECTANGLE, Part.PLATES}.isdisjoint(way.parts)


def _first_dash(document: Document) -> Mark | None:
    """The dash that the others' distances count from, where its own is not known."""
    told = [mark for mark in document.marks if mark.distance_m is not None]
    return min(told, key=lambda mark: mark.distance_m or 0.0, default=None) if document.paced else None


def _key(number: int) -> str:
    """What makes a click on a point's row the key that selects the point."""
    return f' data-key="{number}"' if number <= NUMBER_KEYS else ""


def _residual_cells(residual: MarkResidual | None, row_sigma_px: float, imperial: bool) -> str:
    """The three cells of a residual: pixels, distance, and the bar."""
    if residual is None:
        return "<td></td><td></td><td></td>"
    distance = in_units(residual.distance_m, imperial)
    distance_text = f"{rounded(distance, 2):+.2f}" if math.isfinite(distance) else "∞"
    bar = residual_bar(residual.row_px / row_sigma_px)
    return f"<td>{rounded(residual.row_px, 2):+.2f}</td><td>{distance_text}</td><td>{bar}</td>"
