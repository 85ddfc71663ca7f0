"""All that is known about a camera and its road: the input of the joint fit."""

from dataclasses import dataclass, replace

from fcw.camera.calibration import Gaussian, Priors
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.rectangle import RECTANGLE_FACTS
from fcw.camera.lens.model import Lens
from fcw.camera.prior_sigmas import TAPE_ERROR
from fcw.frame import ImageSize

CLOSED_SIGMA = 1e-6
"""Standard deviation of an unknown that is held fixed."""


@dataclass(frozen=True, slots=True)
class Known:
    """What the user has stated and clicked.

    Attributes:
        evidence: what is known about the road in the picture.
        image_size: size of the picture.
        height_m: height of the camera, and how well it is known.
        reference_offset_m: distance from the camera forward to where distances start.
        click_sigma_px: standard deviation of a clicked column or row.
        priors: other stated values; the rest is assumed as for usual lenses.
        lens: intrinsics and distortion of the camera, if they are known.
        tape_error: standard deviation of all distances together, as a part of them; also of a period.
        bend: k1 of an unknown lens that bends the picture (Brown 1971), which is fitted with the rest; None
            for a picture without distortion.
        axis_column_px: principal column of pictures that were straightened with a lens; None for the middle.
            With a known lens, the lens's own column is used.
        rough: if nothing shows where the road is, assume the usual mounting of a camera.
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
        """Whether the fit of rows (`fcw.camera.solve`) can use all of it.

        That fit takes only measured points, and ignores their columns, which would show the roll.
        """
        said = replace(self.evidence, points=(), edges=()) != Evidence()
        columns = {point.column_px for point in self.evidence.points if point.column_px is not None}
        return not said and self.lens is None and self.bend is None and len(columns) < 2

    @property
    def tells_of_the_road(self) -> bool:
        """Whether anything besides the usual mounting shows where the road is in the picture."""
        evidence, priors = self.evidence, self.priors
        road = len(evidence.points) + 2 * (len(evidence.lines) > 1) + 2 * (evidence.horizon is not None)
        road += 2 * (evidence.travel_px is not None) + len(evidence.rulers) + len(evidence.plates)
        road += RECTANGLE_FACTS * len(evidence.rectangles) + (priors.horizon_row_px is not None)
        # A lens and a speed give the scale of distances, but do not show where the road is.
        lens = (priors.field_of_view_rad is not None) + (priors.principal_row_px is not None)
        lens += (evidence.scale_px_m is not None) + 2 * (self.lens is not None)
        return road > 0 and road + lens >= 2


@dataclass(frozen=True, slots=True)
class Slip:
    """How dashes may differ from their period, described by a single unknown.

    Attributes:
        by_mark_m: how far a slip of 1 moves each mark; empty if none moves.
        sigma: standard deviation of the slip.
    """

    by_mark_m: tuple[float, ...]
    sigma: float


NO_SLIP = Slip((), CLOSED_SIGMA)
