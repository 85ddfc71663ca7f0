"""A drive's look proposes the yaw with the horizon, and corrects nobody who said it."""

import pytest

from fcw.camera.calibration import Gaussian
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Belief, Document
from fcw_viz.calibrate_app.panels.camera.horizon import yaw_to_take
from fcw_viz.calibrate_app.proposals.drive_look import Look

SHOWN = Gaussian(0.03, 0.01)


@pytest.mark.parametrize(
    ("shown", "said", "taken"),
    [(SHOWN, None, Belief(SHOWN)), (SHOWN, Belief(Gaussian(-0.02, 0.005)), None), (None, None, None)],
)
def test_the_yaw_is_taken_where_the_drive_shows_it_and_nobody_said_it(
    shown: Gaussian | None, said: Belief | None, taken: Belief | None
) -> None:
    look = Look(Gaussian(330.0, 2.0), "", yaw_rad=shown)
    assert yaw_to_take(look, Document(ImageSize(1280, 720), yaw=said)) == taken
