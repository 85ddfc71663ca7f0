"""Where the words of a box may stand."""

from fcw.box import Box
from fcw_viz.page.picture.lines import box_line


def test_words_that_do_not_belong_above_a_box_stand_there_last():
    box = Box(100.0, 50.0, 40.0, 30.0)
    usual = box_line(box, (255, 0, 0), "30 m")
    other = box_line(box, (255, 0, 0), "30 m", above=False)
    assert usual.places[0].row_px == box.y
    assert other.places[0].row_px == box.bottom
    assert all(place.row_px == box.y for place in other.places[-3:])
    assert sorted(other.places) == sorted(usual.places)
