"""What a tab shows: one immutable value for each state of a session."""

from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.plausibility import Finding
from fcw.camera.uncertainty import CameraSigmas, NextClick
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edits import Edit


class Status(Enum):
    """How well a document determines a camera."""

    INCOMPLETE = "incomplete"
    """Some input is still missing; there is no mistake."""
    DEGENERATE = "degenerate"
    """The input does not determine a camera; nothing can be saved."""
    IMPLAUSIBLE = "implausible"
    """It determines one that can hardly be behind a windscreen; a saved file contains the warning."""
    DOUBTFUL = "doubtful"
    """It determines a plausible one, but there is a question that only the user can answer."""
    GOOD = "good"
    """It determines a plausible one."""


@dataclass(frozen=True, slots=True)
class Mend:
    """A correction that a button applies.

    Attributes:
        label: text of the button, for example "Distances are from the bumper, 2.29 m ahead of the camera".
        edits: its edits, as one step of undo.
    """

    label: str
    edits: tuple[Edit, ...]


@dataclass(frozen=True, slots=True)
class Trouble:
    """A problem in words, with its cause.

    Attributes:
        text: one paragraph with the probable cause.
        mark_ids: the marks that cause it; empty if none of them does.
        mend: the proposed correction, if there is one.
    """

    text: str
    mark_ids: tuple[int, ...] = ()
    mend: Mend | None = None


@dataclass(frozen=True, slots=True)
class MarkResidual:
    """The difference between a mark and the solution.

    Attributes:
        row_px: clicked row minus the row of the solution.
        distance_m: distance of the solution at the clicked row, minus the typed distance; inf if the clicked
            row is at or above the horizon of the solution.
    """

    row_px: float
    distance_m: float


@dataclass(frozen=True, slots=True)
class DistanceRow:
    """One distance of the result, which is drawn and listed.

    Attributes:
        distance_m: distance from the reference.
        row_px: its row, which may be outside the picture.
        row_sigma_px: standard deviation of this row.
        low_m: 16th percentile of the distance at this row.
        high_m: 84th percentile; inf if unbounded.
    """

    distance_m: float
    row_px: float
    row_sigma_px: float
    low_m: float
    high_m: float


@dataclass(frozen=True, slots=True)
class Result:
    """A camera and everything that is shown about it, computed once for all tabs.

    Attributes:
        calibration: the camera with its uncertainty.
        sigmas: standard deviations of its parameters.
        rows: the distances that are drawn, nearest first.
        quality: one plain sentence, for example "A reading of 40 m means 38.8 to 41.2 m."
        next_click: where one more point helps most, if anywhere.
        residuals: residuals by the id of the mark, only for marks that were used.
        exact: whether any points would fit almost exactly, so that residuals say nothing.
        findings: what is implausible; empty if all is well.
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
    """The effect of one prior, shown beside its switch.

    Attributes:
        error_without: relative standard deviation of the distance at `EFFECT_DISTANCE_M` without it; inf if
            the camera is undetermined without it.
        error_with: the same with it.
        shift: relative change of the distance at this row when it is switched on; 0 if the camera is
            undetermined without it.
    """

    error_without: float
    error_with: float
    shift: float


@dataclass(frozen=True, slots=True)
class Solution:
    """The solution that follows from a document.

    Attributes:
        status: how well it determines a camera.
        result: the camera; None unless there is one, perhaps with assumptions for what is missing.
        hint: what to do next, one sentence ("Two more points: click them and type their distances").
        troubles: the problems.
        lane_horizon: row where the two lane lines meet, with its standard deviation; None without them.
        height_assumed: whether the height is missing, so that one was assumed for the preview
            (`fcw.camera.prior_sigmas.CAR_CAMERA_HEIGHT_M`); the status is then incomplete.
        effects: effects of the stated priors, by the name of the field of the document ("field_of_view",
            "principal_row", "horizon", "lane_lines").
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
        """Whether it can be saved: it determines a camera, and nothing was assumed."""
        return self.status in (Status.GOOD, Status.DOUBTFUL, Status.IMPLAUSIBLE)

    @property
    def warnings(self) -> tuple[str, ...] | None:
        """The warnings for a saved calibration: all problems that are shown; None if there are none."""
        if self.status is not Status.IMPLAUSIBLE:
            return None
        return tuple(trouble.text for trouble in self.troubles) or None


@dataclass(frozen=True, slots=True)
class SessionState:
    """One state of a session, the same for all tabs.

    Attributes:
        revision: a number that grows with each change.
        document: the input, including the present position of a drag.
        solution: the solution that follows from it.
        shown: the result that is drawn: that of the solution, or the last good one; None before the first.
        current: whether `shown` belongs to this document; the last good one is marked as outdated.
        can_undo: whether there is a step to undo.
        can_redo: whether there is a step to redo.
        save_path: where the calibration is saved.
        saved: whether the file there contains the calibration of this document.
        people: names of the open tabs, for example "tab 1", in the order in which they were opened.
        notice: a message for everybody, for example about a resumed session; else empty.
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
