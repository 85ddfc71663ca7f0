"""Edits of the other knowledge: tape, lens, yaw, roll, lane width, vehicles, speed, edges."""

import math
from dataclasses import dataclass, replace

from fcw.camera.joint.evidence import Ruler
from fcw.camera.lens.model import Lens
from fcw.camera.points import LARGEST_TAPE_ERROR
from fcw.camera.prior_sigmas import ROLL_SIGMA_RAD, YAW_SIGMA_RAD
from fcw.errors import UserError
from fcw_viz.calibrate_app.document.document import Belief, Document

STEEPEST_TURN_RAD = math.radians(45.0)
SEEN_YAW_SIGMA_RAD, SEEN_ROLL_SIGMA_RAD = YAW_SIGMA_RAD / 5, ROLL_SIGMA_RAD / 3
"""Standard deviations of yaw and roll that were typed or dragged without saying how sure they are."""


@dataclass(frozen=True, slots=True)
class SetTapeError:
    """The common error of all measured distances, as a part of them."""

    tape_error: float

    def apply(self, document: Document) -> Document:
        """The document with this error.

        Raises:
            UserError: it is not a valid part of a distance.
        """
        if not 0 <= self.tape_error < LARGEST_TAPE_ERROR:
            raise UserError(
                f"tape error {self.tape_error:.3g}: expected 0 to {LARGEST_TAPE_ERROR:.0%} of the distance"
            )
        return replace(document, tape_error=self.tape_error)


@dataclass(frozen=True, slots=True)
class SetPaced:
    """Whether the marks are dashes, whose first distance is unknown."""

    paced: bool

    def apply(self, document: Document) -> Document:
        """The document with this choice."""
        return replace(document, paced=self.paced)


@dataclass(frozen=True, slots=True)
class SetLens:
    """The lens from a file of another tool; None removes it."""

    lens: Lens | None

    def apply(self, document: Document) -> Document:
        """The document with this lens, for the size of its pictures.

        Raises:
            UserError: the lens is for pictures of another aspect ratio.
        """
        lens = self.lens and self.lens.for_image_size(document.image_size)
        return replace(document, lens=lens)


@dataclass(frozen=True, slots=True)
class SetYaw:
    """How far the camera looks to the left of the direction of travel."""

    belief: Belief | None

    def apply(self, document: Document) -> Document:
        """The document with this yaw.

        Raises:
            UserError: no camera that looks ahead is turned so far.
        """
        _check_turn("yaw", self.belief)
        return replace(document, yaw=self.belief)


@dataclass(frozen=True, slots=True)
class SetRoll:
    """How far the camera is tilted to the right."""

    belief: Belief | None

    def apply(self, document: Document) -> Document:
        """The document with this roll.

        Raises:
            UserError: no camera that somebody put up is tilted so far.
        """
        _check_turn("roll", self.belief)
        return replace(document, roll=self.belief)


@dataclass(frozen=True, slots=True)
class SetLaneWidth:
    """The distance between the lane lines."""

    belief: Belief | None

    def apply(self, document: Document) -> Document:
        """The document with this width.

        Raises:
            UserError: it is not a width.
        """
        _check_above_zero("lane width", self.belief, "metres from the middle of one line to the other's")
        return replace(document, lane_width=self.belief)


@dataclass(frozen=True, slots=True)
class SetVehicles:
    """Vehicles of the drive, used as rulers; an empty list removes them."""

    vehicles: tuple[Ruler, ...]

    def apply(self, document: Document) -> Document:
        """The document with them."""
        return replace(document, vehicles=self.vehicles)


@dataclass(frozen=True, slots=True)
class SetSpeed:
    """The mean speed over the measured part of the drive, and the scale for each m/s of it."""

    belief: Belief | None
    scale_per_mps: float | None

    def apply(self, document: Document) -> Document:
        """The document with this speed.

        Raises:
            UserError: it is not a speed.
        """
        _check_above_zero("speed", self.belief, "metres a second")
        return replace(document, speed=self.belief, scale_per_mps=self.scale_per_mps)


@dataclass(frozen=True, slots=True)
class SetEdges:
    """Places (column, row) along lines that are straight in the world; an empty list removes them."""

    edges: tuple[tuple[tuple[float, float], ...], ...]

    def apply(self, document: Document) -> Document:
        """The document with them."""
        return replace(document, edges=self.edges, bent=document.bent and bool(self.edges))


@dataclass(frozen=True, slots=True)
class SetBent:
    """Whether the lens bends the picture, so that its distortion is fitted with the rest."""

    bent: bool

    def apply(self, document: Document) -> Document:
        """The document with this choice."""
        return replace(document, bent=self.bent)


Knowledge = (
    SetTapeError
    | SetPaced
    | SetLens
    | SetYaw
    | SetRoll
    | SetLaneWidth
    | SetVehicles
    | SetSpeed
    | SetEdges
    | SetBent
)


def _check_turn(name: str, belief: Belief | None) -> None:
    if belief is None:
        return
    value, sigma = belief.prior.value, belief.prior.sigma
    if not (abs(value) < STEEPEST_TURN_RAD and 0 < sigma < math.inf):
        raise UserError(
            f"{name} {math.degrees(value):.3g} degrees: expected less than "
            f"{math.degrees(STEEPEST_TURN_RAD):.0f} to either side, with an error above 0"
        )


def _check_above_zero(name: str, belief: Belief | None, meaning: str) -> None:
    if belief is None:
        return
    value, sigma = belief.prior.value, belief.prior.sigma
    if not (math.isfinite(value) and value > 0 and math.isfinite(sigma) and sigma > 0):
        raise UserError(f"{name} {value:g} ± {sigma:g}: expected numbers above 0, {meaning}")
