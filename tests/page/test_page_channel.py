"""What the page's elements say: attributes that hold any words."""

import xml.etree.ElementTree as ET

import pytest

from fcw_viz.page.channel import chooses, enters, says, says_size, slides


@pytest.mark.parametrize("words", ["event:4", "open:a \"b\" <c> & 'd'#3", "note:ü"])
def test_any_words_come_through(words: str):
    assert ET.fromstring(f"<p {says(words)}/>").get("data-fcw") == words


def test_a_slide_tells_both_of_its_ends_exactly():
    element = ET.fromstring(f"<p {slides('plots', 'seek', 0.1, 1e3 / 3)}/>")
    name, start, end = element.get("data-fcw-slide", "").split(":")
    assert (element.get("id"), name, float(start), float(end)) == ("plots", "seek", 0.1, 1e3 / 3)


def test_fields_and_sizes():
    assert ET.fromstring(f"<p {chooses('reason')}/>").get("data-fcw-choice") == "reason"
    assert ET.fromstring(f"<p {says_size('strip')}/>").get("data-fcw-size") == "strip"
    assert 'data-fcw-enter="note"' in enters("field", "note")
