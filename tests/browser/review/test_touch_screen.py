"""The review page under a finger: no mouse, no keyboard."""

from pathlib import Path

import pytest
from review_drives import BOX, CAUTION_S, OTHER_BOX
from review_helpers import OpenPage, Review, Reviewer, WaitFor, node_is_there, row_of, said_of

from fcw.box import Box

WORST_ROW = row_of(CAUTION_S)


def test_a_box_is_selected_by_a_tap_dragged_by_its_corner_put_back_and_another_one_drawn(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(review({"made": drive_log}).url, window_px=(768, 1024), phone=True))
    wait_for(lambda: person.sees(WORST_ROW))
    person.browser.page.get_by_role("tab", name="Boxes").tap()
    person.browser.page.get_by_role("button", name="Correct boxes").tap()
    wait_for(lambda: node_is_there(person, "/lines/boxes/lines_8"))
    person.browser.wait_until_still()
    undo = person.browser.page.get_by_role("button", name="Undo")
    assert undo.is_disabled()
    # Sliding the picture by a box does not select that one.
    person.browser.touch([(OTHER_BOX.x + 9, OTHER_BOX.y + 9), (OTHER_BOX.x + 29, OTHER_BOX.y + 19)])
    person.browser.wait_until_still()
    assert not node_is_there(person, "/handles/corner bottom right")
    person.browser.touch([(BOX.x + BOX.w / 2, BOX.y + BOX.h / 2)])
    wait_for(lambda: node_is_there(person, "/handles/corner bottom right"))
    person.browser.wait_until_still()
    person.browser.touch(
        [(BOX.right, BOX.bottom), (BOX.right + 20, BOX.bottom + 10), (BOX.right + 37, BOX.bottom + 21)]
    )
    wait_for(lambda: bool(said_of(drive_log).frames))
    (label,) = said_of(drive_log).frames[WORST_ROW].labels.values()
    assert label is not None
    assert (label.box.x, label.box.y, label.track_id) == (BOX.x, BOX.y, 7)
    wait_for(undo.is_enabled)
    person.browser.wait_until_still()  # a panel that is drawn anew under a finger misses the tap
    undo.tap()
    wait_for(lambda: not said_of(drive_log).frames)
    wait_for(undo.is_disabled)

    # Drawn over another box: that one is neither moved nor selected.
    person.browser.page.get_by_role("button", name="Draw a box").tap()
    wait_for(lambda: not node_is_there(person, "/handles/corner bottom right"))
    person.browser.wait_until_still()
    camera = person.browser.camera()
    drawn = Box(BOX.x - 60, BOX.y - 40, 100, 80)
    person.browser.touch([(drawn.x, drawn.y), (BOX.x, BOX.y), (drawn.right, drawn.bottom)])
    wait_for(lambda: bool(said_of(drive_log).frames))
    (label,) = said_of(drive_log).frames[WORST_ROW].labels.values()
    assert label is not None
    assert label.track_id is None
    pixel = 2 * 640 / 768  # touches have whole CSS pixels
    assert (label.box.x, label.box.y) == pytest.approx((drawn.x, drawn.y), abs=pixel)
    assert (label.box.right, label.box.bottom) == pytest.approx((drawn.right, drawn.bottom), abs=pixel)
    # Then fingers slide again.
    wait_for(lambda: node_is_there(person, "/handles/corner bottom right"))
    person.browser.wait_until_still()
    assert person.browser.camera() == camera
    person.browser.touch([(500, 60), (460, 60), (400, 60)])
    wait_for(lambda: person.browser.camera() != camera)
