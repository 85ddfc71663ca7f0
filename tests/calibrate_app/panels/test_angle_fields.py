"""What an angle's field refuses is answered in the words of its label."""

import math
from unittest.mock import MagicMock

import pytest

from fcw.errors import UserError
from fcw_viz.calibrate_app.panels.camera.besides import BesidesPanel


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        ("Roll to the right, °", "'45' is not a tilt to the right: expected -30 to 30°"),
        ("Yaw to the left, °", "'45' is not an angle to the side: expected -30 to 30°"),
    ],
)
def test_what_is_no_angle_is_answered_with_what_its_field_expects(label: str, expected: str):
    desk = MagicMock()
    desk.pictures.count = 1
    BesidesPanel(MagicMock(), desk)
    quantities = {call.args[1]: call.args[2] for call in desk.fields.add.call_args_list}
    with pytest.raises(UserError, match=f"^{expected}$"):
        quantities[label].read("45", math.radians(1))
