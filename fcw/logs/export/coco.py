"""Writes boxes of drives as COCO, with the pictures and calibrations that `fcw train` needs."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

import cv2

from fcw.box import Box
from fcw.camera.file import calibration_text
from fcw.files import make_folder, whole_file, write_whole
from fcw.logs.export.clip import DriveClip
from fcw.logs.pictures import LogPictures
from fcw.logs.records import FrameResult
from fcw.versions import __version__

VEHICLE = {"id": 1, "name": "vehicle", "supercategory": "vehicle"}
PICTURES_NAME, CALIBRATIONS_NAME = "images", "calibration"
"""Folders beside the labels, as `fcw train --data` expects them."""
_JPEG_QUALITY = 95

FrameBoxes = tuple[FrameResult, Sequence[tuple[Box, Mapping[str, Any]]]]
"""A frame, and its boxes with the fields of their annotations besides those of COCO."""


def write_coco(
    path: Path,
    clips: Sequence[DriveClip],
    frames_of: Callable[[DriveClip], Iterable[FrameBoxes]],
    *,
    with_pictures: bool = False,
) -> int:
    """Write frames of drives as one file of COCO labels.

    The `file_name` of an image is `<drive>/<frame>.jpg`, `clip` is its drive, and `frame` and `time_ns` are
    its place in the drive.

    Args:
        path: the file.
        clips: the drives.
        frames_of: gives the frames of a drive with their boxes in order; `track_frames` gives the log's.
        with_pictures: also write the pictures to `images/` and the calibrations to `calibration/` beside it.

    Returns:
        The number of boxes.

    Raises:
        UserError: a picture is missing in a log, or a file cannot be written.
    """
    with whole_file(path) as partial, partial.open("w", encoding="utf-8") as file:
        return _write(file, path.parent, clips, frames_of, with_pictures)


def _write(
    file: TextIO,
    folder: Path,
    clips: Sequence[DriveClip],
    frames_of: Callable[[DriveClip], Iterable[FrameBoxes]],
    with_pictures: bool,
) -> int:
    """Write the labels to an open file, the boxes at once, because those of hours would fill the memory."""
    head = json.dumps(
        {"info": {"description": "vehicles followed by fcw", "version": __version__}, "categories": [VEHICLE]}
    )
    file.write(f'{head[:-1]}, "annotations": [')
    images: list[str] = []
    count = 0
    for clip in clips:
        pictures = LogPictures(clip.log) if with_pictures else None
        if pictures:
            make_folder(folder / PICTURES_NAME / clip.name)
            make_folder(folder / CALIBRATIONS_NAME)
            write_whole(
                folder / CALIBRATIONS_NAME / f"{clip.name}.yaml",
                calibration_text(clip.log.header.calibration),
            )
        for result, boxes in frames_of(clip):
            image = _image(len(images) + 1, clip, result)
            if pictures:
                _write_picture(folder / PICTURES_NAME / image["file_name"], pictures, result.index)
            images.append(json.dumps(image, allow_nan=False))
            for annotation in _annotations(image["id"], count + 1, boxes):
                file.write(", " if count else "")
                file.write(json.dumps(annotation, allow_nan=False))
                count += 1
        if pictures:
            pictures.close()
    file.write(f'], "images": [{", ".join(images)}]}}\n')
    return count


def track_frames(clip: DriveClip, on_frame: Callable[[], None], every: int = 1) -> Iterator[FrameBoxes]:
    """Frames of a drive with the boxes of its tracks.

    An annotation has `track_id`, which counts within a drive, `score`, `seen_by` and `coasting`.

    Args:
        clip: the drive.
        on_frame: called after each frame, also after those that are left out.
        every: keep only the frames 0, every, 2 every, ... of the drive.
    """
    for result in clip.results():
        if result.index % every == 0:
            yield (
                result,
                [
                    (
                        track.box,
                        {
                            "track_id": track.track_id,
                            "score": track.score,
                            "seen_by": track.seen_by.value,
                            "coasting": track.coasting,
                        },
                    )
                    for track in result.tracks
                ],
            )
        on_frame()


def _image(image_id: int, clip: DriveClip, result: FrameResult) -> dict[str, Any]:
    header = clip.log.header
    return {
        "id": image_id,
        "file_name": f"{clip.name}/{result.index:06d}.jpg",
        "width": header.image_size.width,
        "height": header.image_size.height,
        "clip": clip.name,
        "frame": result.index,
        "fps": header.frame_rate_hz,
        "time_ns": result.time_ns,
    }


def _annotations(
    image_id: int, first_id: int, boxes: Sequence[tuple[Box, Mapping[str, Any]]]
) -> list[dict[str, Any]]:
    return [
        {
            "id": first_id + i,
            "image_id": image_id,
            "category_id": VEHICLE["id"],
            "bbox": [box.x, box.y, box.w, box.h],
            "segmentation": [
                [box.x, box.y, box.right, box.y, box.right, box.bottom, box.x, box.bottom]
            ],  # the box again: readers make masks of it
            "area": box.w * box.h,
            "iscrowd": 0,
            **fields,
        }
        for i, (box, fields) in enumerate(boxes)
    ]


def _write_picture(path: Path, pictures: LogPictures, index: int) -> None:
    encoded = cv2.imencode(".jpg", pictures.at(index), [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1]
    with whole_file(path) as partial:
        partial.write_bytes(encoded.tobytes())
