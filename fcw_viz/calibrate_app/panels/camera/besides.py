"""What else may be known: the lane's width, a speed, vehicles, how the camera is turned, its whole lens."""

import math
import tempfile
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import TypeVar

import viser

from fcw.camera.calibration import Gaussian
from fcw.camera.joint.bent import FEWEST_PLACES
from fcw.camera.lens.files import read_lens
from fcw.camera.lens.model import Lens
from fcw.errors import UserError
from fcw.units import FEET_PER_METRE
from fcw.warning.ego_speed import EgoSpeed
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.besides.joint_fit import FEWEST_VEHICLES
from fcw_viz.calibrate_app.document.besides.knowledge import (
    SEEN_ROLL_SIGMA_RAD,
    SEEN_YAW_SIGMA_RAD,
    SetBent,
    SetEdges,
    SetLaneWidth,
    SetLens,
    SetRoll,
    SetSpeed,
    SetVehicles,
    SetYaw,
)
from fcw_viz.calibrate_app.document.document import Belief, Document
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.panels.camera.belief import BeliefControls, BeliefKind
from fcw_viz.calibrate_app.proposals.drive_look import Look
from fcw_viz.calibrate_app.quantities import (
    ANGLE_ERROR,
    LENGTH_ERROR,
    SPEED,
    SPEED_ERROR,
    TILT,
    TURN,
    WIDTH,
)
from fcw_viz.calibrate_app.tools import Tool
from fcw_viz.page.controls import on_button
from fcw_viz.page.style import set_html, text_block

Read = TypeVar("Read")
LANE_WIDTH_SIGMA_M = 0.1
SPEED_SIGMA_MPS = 0.5
KILOMETRES_PER_HOUR, MILES_PER_HOUR = 1 / 3.6, 1609.344 / 3600
FIND_VEHICLES, FORGET_VEHICLES = "Use the vehicles ahead as rulers", "Remove the vehicles"
LOOKING_WORDS = "Looking for vehicles; this takes about half a minute."
CLICK_EDGE = "Click along a straight edge"
EDGE_HINT = "Shows whether the lens bends the picture, and how much"
EDGE_WORDS = (
    f"Click {FEWEST_PLACES} or more places along something straight, such as a pole, a wall or a bridge, "
    "preferably far from the middle of the picture. Press Esc when done."
)
NOT_USED = "The field of view and lens axis above are not used."
IMPORT, FORGET_LENS, FORGET_EDGES = "Import a lens", "Remove the lens", "Remove the edges"
LENS_WORDS = (
    "camera_info, Kalibr or OpenCV, as YAML. Without a lens file, the picture is assumed to have no "
    "distortion."
)
WIDE_RAD = math.radians(80.0)
WIDE_WORDS = (
    "A lens with so wide a view usually bends lines. The lines of your own lane do not show it: they bend "
    "by less than a third of a pixel. Import the lens, or click along something straight at the side of "
    "the picture."
)
LARGEST_LENS_BYTES = 1_000_000
SPEED_FILE = "Use the speed of a GPX or CSV file"
SPEED_FILE_HINT = "A GPX track that begins with the drive, or a CSV file with time_s and speed_mps"


class BesidesPanel:
    """A field each, beside the lens and the horizon."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._lane = BeliefControls(
            gui,
            desk,
            BeliefKind(
                "lane_width",
                "Lane width, m",
                "From the middle of the left line to that of the right one; needs both lane lines",
                WIDTH,
                LENGTH_ERROR,
                1.0,
                LANE_WIDTH_SIGMA_M,
                SetLaneWidth,
                ("Lane width, ft", 1 / FEET_PER_METRE),
            ),
        )
        self._speed = BeliefControls(
            gui,
            desk,
            BeliefKind(
                "speed",
                "Mean speed, km/h",
                "Over the stretch that the program analysed; it can replace the lens and the height",
                SPEED,
                SPEED_ERROR,
                KILOMETRES_PER_HOUR,
                SPEED_SIGMA_MPS,
                self._speed_edit,
                ("Mean speed, mph", MILES_PER_HOUR),
            ),
        )
        several = desk.pictures.count > 1
        self._speed_file = gui.add_upload_button(
            SPEED_FILE,
            color="gray",
            icon=viser.Icon.UPLOAD,
            mime_type=".gpx,.csv",
            hint=SPEED_FILE_HINT,
            visible=several,
        )
        self._find = gui.add_button(FIND_VEHICLES, color="gray", icon=viser.Icon.CAR, visible=several)
        self._vehicle_words = gui.add_html("")
        self._turns = [
            BeliefControls(gui, desk, kind)
            for kind in (
                BeliefKind(
                    "yaw",
                    "Yaw to the left, °",
                    "From the direction of travel; negative: to the right",
                    TURN,
                    ANGLE_ERROR,
                    math.radians(1),
                    SEEN_YAW_SIGMA_RAD,
                    SetYaw,
                ),
                BeliefKind(
                    "roll",
                    "Roll to the right, °",
                    "The horizon then falls to the left in the picture; negative: to the left",
                    TILT,
                    ANGLE_ERROR,
                    math.radians(1),
                    SEEN_ROLL_SIGMA_RAD,
                    SetRoll,
                ),
            )
        ]
        self._edge = gui.add_button(CLICK_EDGE, color="gray", icon=viser.Icon.LINE, hint=EDGE_HINT)
        self._import = gui.add_upload_button(
            IMPORT, color="gray", icon=viser.Icon.UPLOAD, mime_type=".yaml,.yml", hint=LENS_WORDS
        )
        self._lens_words = gui.add_html("")
        self._forget = gui.add_button(FORGET_LENS, color="gray", visible=False)

        on_button(self._find, desk.run, self._vehicles_pressed)
        on_button(self._forget, desk.run, lambda: desk.apply(SetLens(None), SetBent(False), SetEdges(())))
        on_button(self._edge, desk.run, self._click_edge)

        @self._speed_file.on_upload
        async def _(_: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
            file = self._speed_file.value
            desk.run(lambda: self._speed_imported(file.name, file.content))

        @self._import.on_upload
        async def _(_: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
            file = self._import.value
            desk.run(lambda: self._imported(file.name, file.content))

    def show(self, state: SessionState) -> None:
        """Bring the fields to a moment of the session."""
        document = state.document
        self._lane.show(state)
        self._speed.show(state)
        for controls in self._turns:
            controls.show(state)
        self._find.label = FORGET_VEHICLES if document.vehicles else FIND_VEHICLES
        look = self._desk.looks.vehicles
        too_few = look.look is not None and len(look.look.vehicles) < FEWEST_VEHICLES
        self._find.disabled = look.running or (too_few and not document.vehicles)
        words = "" if look.look is None else looked_words(document, look.look)
        words = LOOKING_WORDS if look.running else words
        set_html(self._vehicle_words, _dim(words))
        lens = document.lens
        self._forget.visible = lens is not None or document.bent or bool(document.edges)
        self._forget.label = FORGET_LENS if lens is not None or document.bent else FORGET_EDGES
        view = document.field_of_view
        wide = view is not None and view.enabled and view.prior.value >= WIDE_RAD
        words = edge_words(len(document.edges[-1])) if document.edges else WIDE_WORDS if wide else ""
        if document.bent and state.shown is not None and state.shown.calibration.lens is not None:
            words = f"Fitted with the rest. {lens_words(state.shown.calibration.lens)}"
        set_html(self._lens_words, _dim(words if lens is None else f"{lens_words(lens)} {NOT_USED}"))

    def _click_edge(self) -> None:
        """A new edge, to which each click on the picture adds a place."""
        before = self._desk.state.document.edges

        def clicked(column_px: float, row_px: float) -> None:
            edges = self._desk.state.document.edges
            now = edges[len(before)] if len(edges) > len(before) else ()
            self._desk.apply(SetEdges((*before, (*now, (column_px, row_px)))))

        self._desk.use(Tool.EDGE, clicked, EDGE_WORDS)

    def _speed_edit(self, belief: Belief | None) -> SetSpeed:
        if belief is None:
            return SetSpeed(None, self._desk.state.document.scale_per_mps)
        if self._desk.looks.horizon.look is None and self._desk.state.document.scale_per_mps is not None:
            return SetSpeed(belief, self._desk.state.document.scale_per_mps)
        return SetSpeed(belief, self._look_for_speed().scale_per_mps)

    def _speed_imported(self, name: str, content: bytes) -> None:
        look = self._look_for_speed()
        speed_mps = look.mean_speed_mps(_read_as_file(name, content, _own_speed), name)
        self._desk.apply(SetSpeed(Belief(Gaussian(speed_mps, SPEED_SIGMA_MPS)), look.scale_per_mps))

    def _look_for_speed(self) -> Look:
        """The look at the drive, which tells how fast the road goes by.

        Raises:
            UserError: it is under way, and begins now at the latest; or it does not tell.
        """
        look = self._desk.looks.horizon.look
        if look is None:
            self._desk.looks.horizon.start()
            raise UserError(
                "how fast the road goes by is still being measured; type the speed when that is done"
            )
        if look.scale_per_mps is None:
            raise UserError(
                "the drive does not show how fast the road goes by: the road is too plain or too dark, or "
                "the car stands still. A speed cannot help here; type the field of view instead"
            )
        return look

    def _vehicles_pressed(self) -> None:
        desk = self._desk
        if desk.state.document.vehicles:
            desk.apply(SetVehicles(()))
            return
        look = desk.looks.vehicles.look
        if look is None:
            desk.looks.vehicles.start()
        elif len(look.vehicles) >= FEWEST_VEHICLES:
            desk.apply(SetVehicles(look.vehicles))

    def _imported(self, name: str, content: bytes) -> None:
        if len(content) > LARGEST_LENS_BYTES:
            raise UserError(f"{name}: {len(content)} bytes, expected a lens file of at most a megabyte")
        self._desk.apply(SetLens(_read_as_file(name, content, read_lens)))


def looked_words(document: Document, look: Look) -> str:
    """What came of a look for vehicles, and what else would do unless it is there."""
    if document.vehicles:
        return f"{len(document.vehicles)} vehicles are used as rulers."
    shown = document.horizon is not None or None not in document.lane_lines
    return look.words if shown or not look.instead else f"{look.words} {look.instead}"


def _own_speed(path: Path) -> EgoSpeed:
    return EgoSpeed.read_gpx(path) if path.suffix.lower() == ".gpx" else EgoSpeed.read_csv(path)


def _read_as_file(name: str, content: bytes, read: Callable[[Path], Read]) -> Read:
    """What a file that was uploaded holds; an error names it as its owner does.

    Raises:
        UserError: it cannot be read.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / (Path(name).name or "file")
        path.write_bytes(content)
        try:
            return read(path)
        except UserError as error:
            raise UserError(str(error).replace(str(path), Path(name).name)) from None


def lens_words(lens: Lens) -> str:
    """The lens in a line."""
    view_deg = math.degrees(2 * math.atan(lens.image_size.width / 2 / lens.focal_x_px))
    first = ", ".join(f"{value:.3g}" for value in lens.coefficients[:2])
    return (
        f"Lens: field of view {view_deg:.0f}°, axis at column {lens.column_px:.0f}, row "
        f"{lens.row_px:.0f}, distortion {lens.model} {first}."
    )


def edge_words(places: int) -> str:
    """What the edge clicked last still needs."""
    if places < FEWEST_PLACES:
        return f"{places} of at least {FEWEST_PLACES} places along the edge."
    return "What you click must be straight in reality; if the lens bends it, a warning says so."


def _dim(words: str) -> str:
    return text_block(f'<p class="dim">{escape(words)}</p>') if words else ""
