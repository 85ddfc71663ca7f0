"""The boxes of the frames that people labelled, to learn from and to measure with.

A frame is labelled where somebody edited one of its boxes or said that all of them are right. Only what a
person vouched for counts: boxes that were edited, and in a frame said to be right all others too. In a frame
in which some boxes were edited and nobody said so of the whole, the other boxes of the log are ignored:
whether they are right nobody has said, so that they are neither vehicles to find nor background.
"""

from fcw.annotation.records import LabelledBox, track_box_id
from fcw.annotation.review import FrameReview
from fcw.logs.records import FrameResult


def frame_labels(result: FrameResult, frame: FrameReview) -> tuple[LabelledBox, ...]:
    """The boxes of a labelled frame: those of the log's tracks as people left them, then those they added."""
    vouched_for = bool(frame.confirmed)
    boxes: dict[str, LabelledBox | None] = {
        track_box_id(track.track_id): LabelledBox(track.box, track.track_id, ignore=not vouched_for)
        for track in result.tracks
    }
    boxes |= frame.labels
    return tuple(label for label in boxes.values() if label is not None)
