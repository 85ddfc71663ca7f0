"""All that is known of a camera and its road: what a fit of everything takes."""

from dataclasses import dataclass, replace

from fcw.camera.calibration import Gaussian, Priors
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.rectangle import RECTANGLE_FACTS
from fcw.camera.lens.model import Lens
from fcw.camera.prior_sigmas import TAPE_ERROR
from fcw.frame import ImageSize

CLOSED_SIGMA = 1e-6
"""Of an unknown that is not open."""


@dataclass(frozen=True, slots=True)
class Known:
    """What somebody has said and clicked.

    Attributes:
        evidence: what is known of the road in the picture.
        image_size: of the picture.
        height_m: of the camera, and how well it is known.
        reference_offset_m: from the camera forward to where distances start.
        click_sigma_px: standard deviation of a clicked column or row.
        priors: what else is stated; what is not is as in every lens.
        lens: the camera's intrinsics and distortion, where they are known.
        tape_error: standard deviation of all distances together, as a part of them; of a period, too.
        bend: k1 of a lens that is not known but bends the picture (Brown 1971); it is fitted with the rest.
            None of a picture free of distortion.
        axis_column_px: column of the axis in pictures that were made straight through a lens; None in the
            middle. Of a lens that is known it is its own.
        rough: where nothing tells where the road lies, take the camera as most people put it up.
    """

    evidence: Evidence
    image_size: ImageSize
    height_m: Gaussian
    reference_offset_m: float = 0.0
    click_sigma_px: float = 1.0
    priors: Priors = Priors()  # noqa: RUF009 - immutable
    lens: Lens | None = None
    tape_error: float = TAPE_ERROR
    bend: Gaussian | None = None
    axis_column_px: float | None = None
    rough: bool = False

    @property
    def is_of_rows(self) -> bool:
        """Whether a fit of rows (`fcw.camera.solve`) has a place for all of it.

        It has none for anything but taped points, and none for where these lie across the picture, which
        tells how the camera is rolled.
        """
        said = replace(self.evidence, points=(), edges=()) != Evidence()
        columns = {point.column_px for point in self.evidence.points if point.column_px is not None}
        return not said and self.lens is None and self.bend is None and len(columns) < 2

    @property
    def tells_of_the_road(self) -> bool:
        """Whether anything but how cameras usually are tells where the road lies in the picture."""
        evidence, priors = self.evidence, self.priors
        road = len(evidence.points) + 2 * (len(evidence.lines) > 1) + 2 * (evidence.horizon is not None)
        road += 2 * (evidence.travel_px is not None) + len(evidence.rulers) + len(evidence.plates)
        road += RECTANGLE_FACTS * len(evidence.rectangles) + (priors.horizon_row_px is not None)
        # A lens and a speed say how far away what is seen of the road is, but not where it lies.
        lens = (priors.field_of_view_rad is not None) + (priors.principal_row_px is not None)
        lens += (evidence.scale_px_m is not None) + 2 * (self.lens is not None)
        return road > 0 and road + lens >= 2


@dataclass(frozen=True, slots=True)
class Slip:
    """How dashes may lie elsewhere than their period has them, all by one unknown.

    Attributes:
        by_mark_m: what a slip of 1 moves each mark by; empty where none moves.
        sigma: of the slip.
    """

    by_mark_m: tuple[float, ...]
    sigma: float


NO_SLIP = Slip((), CLOSED_SIGMA)
