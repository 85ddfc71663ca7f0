"""The boxes of labelled frames, for training and evaluation.

A frame is labelled if somebody edited one of its boxes or confirmed the frame, which means that all of its
boxes are right. Only what a person approved counts: the edited boxes and, in a confirmed frame, all others.
In a frame that was edited but not confirmed, the other boxes of the log have `ignore`: nobody said whether
they are right, so they are neither vehicles to find nor background.
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
    """The boxes of a labelled frame: those of the log's tracks with all edits, then those that were added."""
    vouched_for = bool(frame.confirmed)
    boxes: dict[str, LabelledBox | None] = {
        track_box_id(track.track_id): LabelledBox(track.box, track.track_id, ignore=not vouched_for)
        for track in result.tracks
    }
    boxes |= frame.labels
    return tuple(label for label in boxes.values() if label is not None)


def labelled_indices(clip: DriveClip, review: Review) -> list[int]:
    """The indices of the labelled frames of a clip, in order."""
    series = clip.log.series()
    in_clip = series.frame_index[np.isin(series.time_ns, clip.times_ns)]
    return sorted(review.frames.keys() & set(in_clip.tolist()))


def labelled_frames(clip: DriveClip, review: Review, on_frame: Callable[[], None]) -> Iterator[FrameBoxes]:
    """The labelled frames of a clip with their boxes, for `write_coco`.

    An annotation has `ignore`, a `track_id` if it belongs to a track of the log, and `view`, `kind`,
    `occluded` and `rear_box` if somebody stated them.
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
