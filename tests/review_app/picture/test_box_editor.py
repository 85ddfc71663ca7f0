"""Boxes that people corrected, over the picture with its own words."""

from unittest.mock import MagicMock

import pytest
from review_drives import BOX, CAUTION_S, SIZE

from fcw.annotation.records import BoxEdit, LabelledBox, track_box_id
from fcw.box import Box
from fcw_viz.page.picture.label_layout import LABEL_HEIGHT_CSS_PX, Area, text_width_css_px
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.picture.box_editor import BoxEditor
from fcw_viz.review_app.picture.frames import FramePictures
from fcw_viz.review_app.place import Place


@pytest.mark.parametrize("screen_px", [1280, 390])
def test_the_word_on_a_corrected_box_leaves_the_pictures_words_free(place: Place, screen_px: int):
    scale = SIZE.width / screen_px
    tab = MagicMock()
    tab.view.away, tab.view.window_px = False, (-0.5, -0.5, SIZE.width - 0.5, SIZE.height - 0.5)
    tab.view.pixels_per_screen_pixel = scale
    tab.view.world = lambda column_px, row_px, layer=0: (column_px, row_px, layer)
    annotating = Annotating(place, lambda title, text: None)
    editor = BoxEditor(tab, place, annotating, lambda: None)
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
