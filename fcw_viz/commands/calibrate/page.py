"""`fcw calibrate SOURCE` without points: the page in the browser."""

from pathlib import Path

from fcw.camera.file import default_path
from fcw.errors import UserError
from fcw_viz.calibrate_app.document.besides.knowledge import SetLens, SetTapeError
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
from fcw_viz.commands.calibrate.evidence import stated_evidence, stated_height
from fcw_viz.commands.calibrate.options import CalibrateCommand
from fcw_viz.commands.calibrate.priors import stated_lens, stated_priors
from fcw_viz.console import RESULTS

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
    if command.exact:
        raise UserError("--exact: only with --points; the page always uses what is typical of a lens, too")
    stated_evidence(command)  # refuses what belongs to a mark that is not there
    page = CalibrationPage(
        source, command.save or default_path(source), command.port, command.dark, command.topic
    )
    try:
        _say(page, command)
        page.announce(RESULTS, "calibrate", "Ctrl-C ends; every click is kept", not command.no_open)
        page.wait()
    finally:
        page.stop()
        state = page.session.state
        if state.saved:
            RESULTS.print(f"saved {state.save_path}", soft_wrap=True)
        elif state.document.marks:
            RESULTS.print(
                "not saved; your points are kept, the same command brings them back", soft_wrap=True
            )
    return 0


def _say(page: CalibrationPage, command: CalibrateCommand) -> None:
    """Tell the session what the command line says, where that is new to it."""
    document = page.session.state.document
    edits = [edit for edit in _edits(command, document) if edit.apply(document) != document]
    if edits:
        page.session.apply(COMMAND_LINE, *edits)


def _edits(command: CalibrateCommand, document: Document) -> list[Edit]:
    size = document.image_size
    priors, lens = stated_priors(command, size), stated_lens(command, size)
    edits: list[Edit] = []
    if command.height is not None:
        stated_height(command)  # refuses what is none
        known_m = document.height_sigma_m if command.height == document.height_m else None
        edits.append(SetHeight(command.height, command.height_sigma or known_m))
    if lens is not None:
        edits.append(SetLens(lens))
    if command.tape_error != Document(size).tape_error:
        edits.append(SetTapeError(command.tape_error))
    if command.reference_offset:
        edits.append(SetReference(True, command.reference_offset))
    if command.row_sigma != Document(size).row_sigma_px:
        edits.append(SetRowSigma(command.row_sigma))
    if priors.field_of_view_rad is not None:
        edits.append(SetFieldOfView(Belief(priors.field_of_view_rad)))
    if priors.principal_row_px is not None:
        edits.append(SetPrincipalRow(Belief(priors.principal_row_px)))
    if priors.horizon_row_px is not None:
        edits.append(SetHorizon(Belief(priors.horizon_row_px)))
    if command.units == "imperial":
        edits.append(SetUnits(True))
    return edits
