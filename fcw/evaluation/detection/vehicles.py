"""Finds boxes of the same vehicle in different pictures, because these are not independent.

Labels may have identities (`track_id`). Without them, boxes in neighbouring pictures of a clip are linked if
they overlap. Pictures of a clip without times have no neighbours, so each box is a vehicle of its own.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from fcw.detection.boxes.overlap import intersection_over_union
from fcw.evaluation.detection.labels import AnnotatedImage

IDENTITY = "track_id"
LINK_IOU = 0.2
"""Least overlap of linked boxes; a vehicle ahead keeps more than this over half a second."""
LARGEST_GAP_S = 1.0
BLOCK_S = 2.0
"""Pictures within this time are drawn together, because a false positive stays for about so long."""


def vehicle_identities(images: Sequence[AnnotatedImage]) -> tuple[NDArray[np.int64], ...]:
    """For each picture, a number for each of its boxes that is the same for the same vehicle."""
    parent: list[int] = []
    first: list[int] = []
    named: dict[tuple[str, object], int] = {}

    def root(number: int) -> int:
        while parent[number] != number:
            number = parent[number]
        return number

    def join(a: int, b: int) -> None:
        parent[root(a)] = root(b)

    for image in images:
        first.append(len(parent))
        for fields in image.attributes:
            number = len(parent)
            parent.append(number)
            if fields.get(IDENTITY) is not None:
                join(number, named.setdefault((image.labelled.clip, fields[IDENTITY]), number))
    for a, b in _neighbours(images):
        overlap = intersection_over_union(images[a].labelled.boxes, images[b].labelled.boxes)
        for i, j in zip(*linear_sum_assignment(-overlap), strict=True):
            unnamed = not any(
                images[k].attributes[n].get(IDENTITY) is not None for k, n in ((a, int(i)), (b, int(j)))
            )
            if overlap[i, j] >= LINK_IOU and unnamed:
                join(first[a] + int(i), first[b] + int(j))
    roots = np.array([root(number) for number in range(len(parent))], np.int64)
    return tuple(
        roots[start : start + len(image.attributes)] for start, image in zip(first, images, strict=True)
    )


def frame_blocks(images: Sequence[AnnotatedImage]) -> NDArray[np.int64]:
    """A number for each picture that is the same within two seconds of a clip; unique if there are no
    times."""
    numbers: dict[tuple[str, object], int] = {}
    return np.array(
        [
            numbers.setdefault(
                (image.labelled.clip, index if image.time_s is None else ("s", image.time_s // BLOCK_S)),
                len(numbers),
            )
            for index, image in enumerate(images)
        ],
        np.int64,
    )


def _neighbours(images: Sequence[AnnotatedImage]) -> Iterator[tuple[int, int]]:
    """Pairs of pictures of one clip that follow each other within a second."""
    times = [
        (image.labelled.clip, image.time_s, index)
        for index, image in enumerate(images)
        if image.time_s is not None and len(image.labelled.boxes)
    ]
    for (clip, time_s, index), (next_clip, next_s, next_index) in pairwise(sorted(times)):
        if clip == next_clip and next_s - time_s <= LARGEST_GAP_S:
            yield index, next_index
