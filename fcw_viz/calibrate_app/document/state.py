"""What a tab is shown: one immutable value for each moment of a session."""

from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.plausibility import Finding
from fcw.camera.uncertainty import CameraSigmas, NextClick
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edits import Edit


class Status(Enum):
    """How far a document determines a camera."""

    INCOMPLETE = "incomplete"
    """Something has still to be said; nobody made a mistake."""
    DEGENERATE = "degenerate"
    """What was said determines no camera; nothing can be saved."""
    IMPLAUSIBLE = "implausible"
    """It determines one that can hardly be behind a windscreen; saved, it carries its warning."""
    DOUBTFUL = "doubtful"
    """It determines a plausible one, and only its maker can answer a question about it."""
    GOOD = "good"
    """It determines a plausible one."""


@dataclass(frozen=True, slots=True)
class Mend:
    """A proposal that a button applies.

    Attributes:
        label: what the button says, e.g. "Distances are from the bumper, 2.29 m ahead of the camera".
        edits: what it does, as one step of undo.
    """

    label: str
    edits: tuple[Edit, ...]


@dataclass(frozen=True, slots=True)
class Trouble:
    """Something wrong, in words, beside what causes it.

    Attributes:
        text: one paragraph, with the likely cause.
        mark_ids: the marks that cause it; empty where it is none of them.
        mend: the proposal, where there is one.
    """

    text: str
    mark_ids: tuple[int, ...] = ()
    mend: Mend | None = None


@dataclass(frozen=True, slots=True)
class MarkResidual:
    """How far a mark lies from the row and the distance that the solution gives it.

    Attributes:
        row_px: clicked row less row of the solution.
        distance_m: distance that the solution sees at the clicked row, less the distance typed; inf where
            the clicked row is at or above the solution's horizon.
    """

    row_px: float
    distance_m: float


@dataclass(frozen=True, slots=True)
class DistanceRow:
    """One distance of the result, as drawn and listed.

    Attributes:
        distance_m: from the reference.
        row_px: its row; may lie outside the picture.
        row_sigma_px: standard deviation of that row.
        low_m: 16th percentile of the distance seen there.
        high_m: 84th percentile; inf where unbounded.
    """

    distance_m: float
    row_px: float
    row_sigma_px: float
    low_m: float
    high_m: float


@dataclass(frozen=True, slots=True)
class Result:
    """A camera and all that is shown of it, computed once for all tabs.

    Attributes:
        calibration: the camera with its uncertainty.
        sigmas: of its parameters.
        rows: the distances drawn, nearest first.
        quality: one plain sentence, e.g. "A reading of 40 m means 38.8 to 41.2 m."
        next_click: where one more point helps most, if anywhere.
        residuals: by the id of the mark; only of marks that took part.
        exact: whether any points would be met nearly, so that residuals say nothing.
        findings: what speaks against it, empty when all is well.
    """

    calibration: Calibration
    sigmas: CameraSigmas
    rows: tuple[DistanceRow, ...]
    quality: str
    next_click: NextClick | None
    residuals: dict[int, MarkResidual]
    exact: bool
    findings: tuple[Finding, ...]


@dataclass(frozen=True, slots=True)
class BeliefEffect:
    """What one belief changes, shown beside its switch.

    Attributes:
        error_without: relative 1-sigma error of the distance at `EFFECT_DISTANCE_M` without it; inf where
            the camera is undetermined without it.
        error_with: the same with it.
        shift: relative change of the distance seen at that distance's row when it is switched on; 0 where
            the camera is undetermined without it.
    """

    error_without: float
    error_with: float
    shift: float


@dataclass(frozen=True, slots=True)
class Solution:
    """What follows from a document.

    Attributes:
        status: how far it determines a camera.
        result: the camera; None unless implausible or good, or all that is missing was assumed.
        hint: what to do next, one sentence ("Two more points: click them and type their distances").
        troubles: what is wrong.
        lane_horizon: row where the two lane lines meet, with its standard deviation; None without them.
        height_assumed: whether the height has still to be said, so that one was assumed for the preview
            (`fcw.camera.prior_sigmas.CAR_CAMERA_HEIGHT_M`); the status is incomplete then.
        effects: of the beliefs, by the name of the document's field ("field_of_view", "principal_row",
            "horizon", "lane_lines"); only of those that are stated.
    """

    status: Status
    result: Result | None
    hint: str
    troubles: tuple[Trouble, ...]
    lane_horizon: Gaussian | None
    height_assumed: bool
    effects: dict[str, BeliefEffect]

    @property
    def can_save(self) -> bool:
        """Whether this state may be saved: it determines a camera, and nothing in it was assumed."""
        return self.status in (Status.GOOD, Status.DOUBTFUL, Status.IMPLAUSIBLE)

    @property
    def warnings(self) -> tuple[str, ...] | None:
        """What a saved calibration carries: all that is shown as wrong; None where nothing is."""
        if self.status is not Status.IMPLAUSIBLE:
            return None
        return tuple(trouble.text for trouble in self.troubles) or None


@dataclass(frozen=True, slots=True)
class SessionState:
    """One moment of a session, the same for all tabs.

    Attributes:
        revision: grows with each change.
        document: what was said; while somebody drags, with the drag's position.
        solution: what follows.
        shown: the result drawn: that of the solution, or the last good one; None before the first.
        current: whether `shown` belongs to this document; a last good one is marked as not current.
        can_undo: whether there is an edit to undo.
        can_redo: whether there is an undone edit.
        save_path: where the calibration is saved.
        saved: whether the file there is this document's calibration.
        people: the names of the tabs present, e.g. "tab 1", in the order of their coming.
        notice: what everybody should know, e.g. of a resumed session; empty otherwise.
    """

    revision: int
    document: Document
    solution: Solution
    shown: Result | None
    current: bool
    can_undo: bool
    can_redo: bool
    save_path: Path
    saved: bool
    people: tuple[str, ...]
    notice: str = ""
