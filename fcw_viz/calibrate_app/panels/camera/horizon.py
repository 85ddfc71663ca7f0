"""The horizon: proposed by the drive, dragged, or where two lane lines meet."""

from functools import partial
from html import escape

import viser

from fcw.camera.calibration import Gaussian
from fcw.camera.prior_sigmas import HORIZON_ROW_SIGMA_PX
from fcw.frame import ImageSize
from fcw.self_calibration.lane_lines import propose_lane_lines
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.besides.knowledge import SetYaw
from fcw_viz.calibrate_app.document.document import Belief, Document, Line
from fcw_viz.calibrate_app.document.edits import EnableLaneLines, SetHorizon, SetLaneLine
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.document.ways.ways import Part, chosen_way
from fcw_viz.calibrate_app.drawing.drawing import HORIZON_COLOR
from fcw_viz.calibrate_app.panels.camera.belief import effect_words
from fcw_viz.calibrate_app.proposals.drive_look import Look, assumed_camera
from fcw_viz.calibrate_app.tools import Tool
from fcw_viz.page.controls import on_button, on_choice, on_press
from fcw_viz.page.picture.lines import LabelledLine, LineOverlay, Place
from fcw_viz.page.style import set_html, text_block

LOOK = "Find the horizon from the drive"
TAKE, TAKE_BOTH = "Use this horizon", "Use this horizon and yaw"
LOOKING_WORDS = "Analysing the drive: {} pictures so far."
DRAG_HORIZON = "Drag the horizon"
FIND_LINES, DRAW_LINES, CLEAR = "Find lane lines", "Draw lane lines", "Remove lines"
HORIZON_WORDS = (
    "Drag the horizon to where a flat, straight road would end, or click there. "
    "Drag its right end to set the roll, the middle of the path to set the yaw. Press Esc when done."
)
LINE_WORDS = (
    "Click a point of the left lane marking, near the bottom of the picture.",
    "Click the left marking again, far away.",
    "Click a point of the right lane marking, near the bottom of the picture.",
    "Click the right marking again, far away.",
)


def proposal_lines(horizon: Gaussian, size: ImageSize) -> tuple[LabelledLine, ...]:
    """The horizon that the drive shows, to be seen before it is taken."""
    row_px = horizon.value
    ends = ((-0.5, row_px), (size.width - 0.5, row_px))
    words = f"horizon from the drive  ±{horizon.sigma:.0f} px"
    places = tuple(Place(size.width * part, row_px, 0.0, -0.7) for part in (0.02, 0.3, 0.7))
    return (LabelledLine(ends, HORIZON_COLOR, words, places),)


def yaw_to_take(look: Look, document: Document) -> Belief | None:
    """The yaw that a look shows; None where it shows none, or somebody said it: nobody is corrected."""
    return None if document.yaw is not None or look.yaw_rad is None else Belief(look.yaw_rad)


class HorizonPanel:
    """The buttons and words; the row itself is a belief beside it."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        drive = desk.pictures.count > 1
        self._look = gui.add_button(LOOK, icon=viser.Icon.SEARCH, visible=drive)
        self._words = gui.add_html("")
        self._horizon = gui.add_button_group("", (DRAG_HORIZON,))
        self._lines = gui.add_button_group("", (FIND_LINES, DRAW_LINES, CLEAR))
        self._lines_used = gui.add_checkbox("Use lane lines", False, visible=False)
        self._lines_words = gui.add_html("")
        self._line_start: tuple[float, float] | None = None
        self._proposed = LineOverlay(desk.view, desk.client, "proposal", lambda: desk.overlay.label_areas)

        on_button(self._look, desk.run, self._pressed)
        on_press(
            self._horizon,
            desk.run,
            {DRAG_HORIZON: lambda: desk.use(Tool.HORIZON, self._horizon_clicked, HORIZON_WORDS)},
        )
        on_choice(self._lines_used, desk.run, lambda enabled: desk.apply(EnableLaneLines(enabled)))
        on_press(
            self._lines,
            desk.run,
            {FIND_LINES: self._find_lines, DRAW_LINES: self._draw_lines, CLEAR: self._clear_lines},
        )

    def show(self, state: SessionState) -> None:
        """Bring it to a moment of the session, and to what is known of the drive."""
        way = chosen_way(state.document)
        if way is not None and Part.LENS in way.parts:
            self._desk.looks.horizon.start()
        look, belief = self._desk.looks.horizon.look, state.document.horizon
        taken = look is not None and belief is not None and belief.prior == look.horizon
        self._look.visible = (
            self._desk.pictures.count > 1 and not taken and (look is None or bool(look.horizon))
        )
        self._look.disabled = self._desk.looks.horizon.running
        take = TAKE if look is None or yaw_to_take(look, state.document) is None else TAKE_BOTH
        self._look.label = LOOK if look is None else take
        proposed = None if look is None or belief is not None else look.horizon
        size = self._desk.pictures.image_size
        self._proposed.show(() if proposed is None else proposal_lines(proposed, size))
        words = "" if look is None else look.words
        if self._desk.looks.horizon.running:
            words = LOOKING_WORDS.format(self._desk.looks.horizon.picture_count)
        set_html(self._words, text_block(f'<p class="dim">{escape(words)}</p>') if words else "")
        drawn = any(line is not None for line in state.document.lane_lines)
        self._lines_used.visible = drawn
        self._lines_used.value = state.document.lane_lines_enabled
        horizon = state.solution.lane_horizon
        words = "" if horizon is None else f"They meet at row {horizon.value:.1f} ± {horizon.sigma:.1f}. "
        effect = effect_words(state.solution.effects.get("lane_lines"), state.document)
        set_html(self._lines_words, text_block(f'<p class="dim">{words}{effect}</p>') if words else "")

    def _pressed(self) -> None:
        look = self._desk.looks.horizon.look
        if look is None:
            self._desk.looks.horizon.start()
        elif look.horizon is not None:
            yaw = yaw_to_take(look, self._desk.state.document)
            turned = () if yaw is None else (SetYaw(yaw),)
            self._desk.apply(SetHorizon(Belief(look.horizon)), *turned)

    def _horizon_clicked(self, _: float, row_px: float) -> None:
        self._desk.apply(SetHorizon(Belief(Gaussian(row_px, HORIZON_ROW_SIGMA_PX))))

    def _find_lines(self) -> None:
        """Propose the lane's lines in this picture; they count once the person says so."""
        desk, shown, look = self._desk, self._desk.state.shown, self._desk.looks.horizon.look
        size = desk.pictures.image_size
        horizon = None if look is None else look.horizon
        camera = assumed_camera(size, horizon) if shown is None else shown.calibration.camera
        lines = propose_lane_lines(desk.pictures.read(desk.frame_index).image, camera)
        left, right = (Line(*line) for line in lines)
        desk.apply(EnableLaneLines(False), SetLaneLine(0, left), SetLaneLine(1, right))
        desk.notify(
            "Are these the lines of your lane?", "If so, tick “Use lane lines”; if not, drag their ends."
        )

    def _draw_lines(self) -> None:
        self._line_start = None
        if not self._desk.state.document.lane_lines_enabled:
            self._desk.apply(EnableLaneLines(True))
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
