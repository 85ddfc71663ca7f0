"""`fcw calibrate SOURCE` without points: the page in the browser."""

import math
import webbrowser
from pathlib import Path

from rich.console import Console

from fcw.camera.calibration import Gaussian
from fcw.camera.file import default_path
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Belief, Document
from fcw_viz.calibrate_app.document.edits import (
    Edit,
    SetFieldOfView,
    SetHeight,
    SetHorizon,
    SetPrincipalRow,
    SetReference,
    SetRowSigma,
    SetUnits,
)
from fcw_viz.calibrate_app.server import CalibrationPage
from fcw_viz.calibrate_app.session import Person
from fcw_viz.commands.calibrate import (
    FIELD_OF_VIEW_SIGMA_DEG,
    HORIZON_ROW_SIGMA_PX,
    PRINCIPAL_ROW_SIGMA_HEIGHTS,
    CalibrateCommand,
    parse_gaussian,
)

COMMAND_LINE = Person("command line")
"""Who said it, in the journal."""


def run_calibrate_page(command: CalibrateCommand, source: Path) -> int:
    """Serve the page until Ctrl-C, which is how it ends.

    What is said on the command line (height, offset, field of view ...) is said on the page already.

    Raises:
        UserError: the source, the port or what was said is wrong.
        KeyboardInterrupt: the end.
    """
    for option, given in (("--json", command.json), ("--export", command.export is not None)):
        if given:
            raise UserError(f"{option}: only with --points; the page has a button for it")
    page = CalibrationPage(
        source, command.save or default_path(source), command.port, command.dark, command.topic
    )
    console = Console(highlight=False, soft_wrap=True)
    try:
        _say(page, command)
        if page.port != command.port:
            console.print(f"port {command.port} is taken, this is the next free one: {page.port}")
        console.print(f"calibrate at {page.url} (Ctrl-C ends; every click is kept)")
        if not command.no_open:
            webbrowser.open(page.url)
        page.wait()
    finally:
        page.stop()
        state = page.session.state
        if state.saved:
            console.print(f"saved {state.save_path}")
        elif state.document.marks:
            console.print("not saved; your points are kept, the same command brings them back")
    return 0


def _say(page: CalibrationPage, command: CalibrateCommand) -> None:
    """Tell the session what the command line says, where that is new to it."""
    document = page.session.state.document
    edits = [edit for edit in _edits(command, document.image_size) if edit.apply(document) != document]
    if edits:
        page.session.apply(COMMAND_LINE, *edits)


def _edits(command: CalibrateCommand, size: ImageSize) -> list[Edit]:
    degrees = parse_gaussian("--field-of-view", command.field_of_view, FIELD_OF_VIEW_SIGMA_DEG)
    field_of_view = degrees and Gaussian(math.radians(degrees.value), math.radians(degrees.sigma))
    principal_row_sigma_px = PRINCIPAL_ROW_SIGMA_HEIGHTS * size.height
    principal_row = parse_gaussian("--principal-row", command.principal_row, principal_row_sigma_px)
    horizon = parse_gaussian("--horizon-row", command.horizon_row, HORIZON_ROW_SIGMA_PX)
    edits: list[Edit] = []
    if command.height is not None:
        edits.append(SetHeight(command.height))
    if command.reference_offset:
        edits.append(SetReference(True, command.reference_offset))
    if command.row_sigma != Document(size).row_sigma_px:
        edits.append(SetRowSigma(command.row_sigma))
    if field_of_view is not None:
        edits.append(SetFieldOfView(Belief(field_of_view)))
    if principal_row is not None:
        edits.append(SetPrincipalRow(Belief(principal_row)))
    if horizon is not None:
        edits.append(SetHorizon(Belief(horizon)))
    if command.units == "imperial":
        edits.append(SetUnits(True))
    return edits
