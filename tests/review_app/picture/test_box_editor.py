"""Boxes that people corrected, over the picture with its own words."""

from unittest.mock import MagicMock

import pytest
from review_drives import BOX, CAUTION_S, SIZE

from fcw.annotation.records import BoxEdit, LabelledBox, track_box_id
from fcw.box import Box
from fcw.errors import UserError
from fcw_viz.page.picture.label_layout import LABEL_HEIGHT_CSS_PX, Area, text_width_css_px
from fcw_viz.page.picture.plane import PicturePlane
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.picture.box_editor import BoxEditor
from fcw_viz.review_app.picture.frames import FramePictures
from fcw_viz.review_app.place import Place


def editor_of(place: Place, tab: MagicMock, scale: float = 1.0) -> BoxEditor:
    """An editor on a picture that is seen whole."""
    tab.view.away, tab.view.window_px = False, (-0.5, -0.5, SIZE.width - 0.5, SIZE.height - 0.5)
    tab.view.pixels_per_screen_pixel, tab.view.plane = scale, PicturePlane(SIZE)
    tab.view.world = lambda column_px, row_px, layer=0: (column_px, row_px, layer)
    return BoxEditor(tab, place, Annotating(place, lambda title, text: None), lambda: None)


def corrects(place: Place) -> BoxEditor:
    """An editor at work on the first warning's frame, with the lead's box."""
    place.row = place.opened.row_at(CAUTION_S)
    editor = editor_of(place, MagicMock())
    editor.start()
    editor.show(place.opened.log.result_at(place.row), tuple)
    editor.click(BOX.x + 1, BOX.y + 1)
    assert editor.selected == track_box_id(7)
    return editor


def labels(place: Place) -> list[LabelledBox | None]:
    frame = place.review.review.frames.get(place.row)
    return [] if frame is None else list(frame.labels.values())


def test_a_box_drawn_or_dragged_out_of_the_picture_is_no_label(place: Place):
    editor = corrects(place)
    with pytest.raises(UserError, match="smaller than 3 pixels"):
        editor.draw(-80.0, 100.0, -20.0, 160.0)
    editor._move("start", BOX.x + 1, BOX.y + 1)
    with pytest.raises(UserError, match="at least 3 pixels wide and high, inside the picture"):
        editor._move("end", BOX.x - SIZE.width, BOX.y)
    assert labels(place) == []


def test_what_is_drawn_next_is_asked_for_once_and_left_by_asking_again_or_by_a_click(place: Place):
    editor = corrects(place)
    editor.switch_drawing()
    assert editor.draws
    editor.switch_drawing(rear=True)
    assert editor.draws
    editor.draw(BOX.x + 10, BOX.y + 10, BOX.x + 40, BOX.y + 40)
    (label,) = labels(place)
    assert label is not None
    assert label.rear_box == Box(BOX.x + 10, BOX.y + 10, 30.0, 30.0)
    assert not editor.draws
    editor.switch_drawing(rear=True)
    editor.switch_drawing(rear=True)
    assert (editor.draws, editor.draws_rear) == (False, False)
    editor.switch_drawing()
    editor.click(BOX.x + 1, BOX.y + 1)
    assert not editor.draws


def test_a_rear_face_is_cut_at_the_edge_of_the_picture_with_its_box(place: Place):
    editor = corrects(place)
    rear = Box(BOX.x + 40, BOX.y, 40.0, BOX.h)
    editor.change(LabelledBox(BOX, 7, rear_box=rear))
    for to_px, kept_px in ((SIZE.width - 0.5 - 60.0, 20.0), (SIZE.width - 0.5 - 30.0, None)):
        editor._move("start", 0.0, 0.0)
        editor._move("end", to_px - editor.told()[1].box.x, 0.0)
        (label,) = labels(place)
        assert label is not None
        assert label.box.right == pytest.approx(SIZE.width - 0.5)
        kept = label.rear_box
        assert (kept and kept.w) == (kept_px and pytest.approx(kept_px))
        assert kept is None or kept.right == pytest.approx(SIZE.width - 0.5)


@pytest.mark.parametrize("screen_px", [1280, 390])
def test_the_word_on_a_corrected_box_leaves_the_pictures_words_free(place: Place, screen_px: int):
    scale = SIZE.width / screen_px
    tab = MagicMock()
    editor, annotating = editor_of(place, tab, scale), Annotating(place, lambda title, text: None)
    place.row = place.opened.row_at(CAUTION_S)
    pictures = FramePictures(place.opened)
    result = pictures.result(place.row)
    annotating.say(
        BoxEdit(place.row, track_box_id(7), LabelledBox(Box(BOX.x + 4, BOX.y, BOX.w, BOX.h), 7)),
    )
    editor.show(result, lambda: pictures.words(result))
    pictures.close()
    (label,) = tab.client.scene.add_label.call_args_list
    (_, text), (left_px, row_px, _) = label.args, label.kwargs["position"]
    assert text == "corrected"
    half_px = LABEL_HEIGHT_CSS_PX / 2 * scale
    covered = Area(left_px, row_px - half_px, left_px + text_width_css_px(text) * scale, row_px + half_px)
    words = pictures.words(result)
    assert len(words) > 3  # of the rows, the lead, the time and the warning
    assert not any(covered.overlaps(one) for one in words)
    assert pictures.words(None) == ()
