"""The boxes of the frames that people labelled, to learn from and to measure with.

A frame is labelled where somebody edited one of its boxes or said that all of them are right. Only what a
person vouched for counts: boxes that were edited, and in a frame said to be right all others too. In a frame
in which some boxes were edited and nobody said so of the whole, the other boxes of the log are ignored:
whether they are right nobody has said, so that they are neither vehicles to find nor background.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from fcw.annotation.records import LabelledBox, track_box_id
from fcw.annotation.review import FrameReview, Review
from fcw.logs.export.clip import DriveClip
from fcw.logs.export.coco import FrameBoxes
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


def labelled_indices(clip: DriveClip, review: Review) -> list[int]:
    """Which frames of a clip are labelled, in order; what was said of others is left out."""
    series = clip.log.series()
    in_clip = series.frame_index[np.isin(series.time_ns, clip.times_ns)]
    return sorted(review.frames.keys() & set(in_clip.tolist()))


def labelled_frames(clip: DriveClip, review: Review, on_frame: Callable[[], None]) -> Iterator[FrameBoxes]:
    """The labelled frames of a clip with their boxes, for `write_coco`.

    An annotation has `ignore`; `track_id` where it belongs to a track of the log; and `view`, `kind`,
    `occluded` and `rear_box` where somebody said so.
    """
    for index in labelled_indices(clip, review):
        result = clip.log.result_at(index)
        boxes = []
        for label in frame_labels(result, review.frames[index]):
            boxes.append((label.box, {"ignore": label.ignore, **_said_fields(label)}))
        yield result, boxes
        on_frame()


def _said_fields(label: LabelledBox) -> dict[str, Any]:
    rear = label.rear_box
    fields = {
        "track_id": label.track_id,
        "view": label.view and label.view.value,
        "kind": label.kind and label.kind.value,
        "occluded": label.occluded,
        "rear_box": rear and [rear.x, rear.y, rear.w, rear.h],
    }
    return {name: value for name, value in fields.items() if value is not None}
