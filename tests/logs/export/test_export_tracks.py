"""Tracks and boxes for others: read back by pandas, motmetrics, pycocotools and our own readers."""

import contextlib
import io
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import motmetrics
import numpy as np
import pandas as pd
import pytest
from export_drives import drive_header, in_time, marked_drive, marked_picture, write_log
from hypothesis import HealthCheck, given
from hypothesis import strategies as st
from pycocotools.coco import COCO
from searching import examples

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.detection.training.dataset import read_labels
from fcw.detection.training.folders import load_training_set
from fcw.evaluation.detection.labels import calibration_source, count_only, read_annotated
from fcw.evaluation.distance.kitti_tracking import read_sequence
from fcw.logs.export.clip import DriveClip
from fcw.logs.export.coco import FrameBoxes, track_frames, write_coco
from fcw.logs.export.tracks import write_kitti, write_mot
from fcw.logs.records import FrameResult
from fcw.tracking.types import SeenBy, Track

KITTI_COLUMNS = [
    *("frame", "track_id", "type", "truncated", "occluded", "alpha", "left", "top", "right", "bottom"),
    *("height", "width", "length", "x", "y", "z", "rotation_y", "score"),
]
metres = st.floats(2, 150)
box_strategy = st.builds(Box, st.floats(-50, 700), st.floats(-50, 400), st.floats(1, 300), st.floats(1, 300))
widths = st.floats(1.5, 2.6)
tracks_strategy = st.lists(
    st.tuples(box_strategy, st.floats(-5, 50), metres, st.floats(-9, 9), widths), max_size=3
)


def drawn_drive(data: st.DataObject, any_frame_result: st.SearchStrategy[FrameResult]) -> list[FrameResult]:
    """Frames with vehicles as a tracker gives them: different ids, boxes in and near the picture."""
    results = []
    for drawn in data.draw(st.lists(tracks_strategy, min_size=1, max_size=5)):
        tracks = tuple(
            Track(
                *(i + 1, box, score, far, far, far, left, 0, 1, None, 0, list(SeenBy)[i % 3], False),
                width_m=width_m,
            )
            for i, (box, score, far, left, width_m) in enumerate(drawn)
        )
        results.append(replace(data.draw(any_frame_result), tracks=tracks))
    return in_time(results)


def clip_of(folder: Path, results: list[FrameResult]) -> DriveClip:
    write_log(folder / "trip" / "drive.mcap", [(result, ()) for result in results], drive_header())
    return DriveClip.open(folder / "trip" / "drive.mcap")


searched = examples(20, suppress_health_check=[HealthCheck.function_scoped_fixture])


@searched
@given(data=st.data())
def test_kitti_lines_hold_the_boxes_and_where_the_rear_stands_in_the_camera(any_frame_result, tmp_path, data):
    results = drawn_drive(data, any_frame_result)
    clip = clip_of(tmp_path, results)
    flat = [(result, track) for result in results for track in result.tracks]
    assert write_kitti(tmp_path / "k.txt", clip, lambda: None) == len(flat)
    rows = [line.split(" ") for line in (tmp_path / "k.txt").read_text().splitlines()]
    assert [len(row) for row in rows] == [len(KITTI_COLUMNS)] * len(flat)
    calibration = clip.log.header.calibration
    camera = calibration.camera
    for fields, (result, track) in zip(rows, flat, strict=True):
        row: Any = dict(zip(KITTI_COLUMNS, fields, strict=True))
        assert (int(row["frame"]), int(row["track_id"]), row["type"]) == (result.index, track.track_id, "Car")
        assert [row[name] for name in ("truncated", "occluded", "alpha", "rotation_y")] == [
            "-1",
            "-1",
            "-10",
            "-10",
        ]
        corners = [float(row[name]) for name in ("left", "top", "right", "bottom")]
        assert corners == [track.box.x, track.box.y, track.box.x + track.box.w, track.box.y + track.box.h]
        assert float(row["score"]) == track.score
        x, y, z, width, length = (float(row[name]) for name in ("x", "y", "z", "width", "length"))
        # Through the camera's pinhole the place is seen where the calibration sees that point of the road.
        assert camera.focal_y_px * y / z + camera.principal_row_px == pytest.approx(
            calibration.row_at(track.distance_m)
        )
        assert camera.focal_y_px * x / z + camera.principal_column_px == pytest.approx(
            calibration.column_at(track.lateral_m, track.distance_m)
        )
        assert (width, length) == (track.width_m, 0)
        assert float(row["height"]) * camera.focal_y_px / z == pytest.approx(track.box.h)


def test_our_own_reader_of_kitti_labels_finds_the_distance(tmp_path):
    drive = [result for result, _ in marked_drive(10)]
    clip = clip_of(tmp_path, drive)
    (tmp_path / "label_02").mkdir()
    (tmp_path / "calib").mkdir()
    write_kitti(tmp_path / "label_02" / "0000.txt", clip, lambda: None)
    (tmp_path / "calib" / "0000.txt").write_text("P2: 500 0 320 0 0 500 180 0 0 0 1 0\n")
    frames = read_sequence(tmp_path, "0000").frames
    assert [len(frame) for frame in frames] == [1, 1, 1, 1, 0, 1, 1, 1, 1]  # the last frame is empty
    # 20 m from the bumper, 21.5 m from the camera, 1.3 m high and 0.02 rad down.
    depth_m = 21.5 * np.cos(0.02) + 1.3 * np.sin(0.02)
    assert [frame[0].rear_m for frame in frames if frame] == pytest.approx([depth_m] * 8)
    assert frames[1][0].lateral_m == 0.4
    assert frames[1][0].box == Box(41.5, 180.0, 72.0, 54.0)


def test_a_vehicle_without_a_distance_has_kittis_marks_for_what_is_unknown(tmp_path):
    result = marked_drive(1)[0][0]
    lost = replace(result, tracks=(replace(result.tracks[0], distance_m=float("inf")),))
    write_kitti(tmp_path / "k.txt", clip_of(tmp_path, [lost]), lambda: None)
    assert (tmp_path / "k.txt").read_text().split()[10:17] == ["-1"] * 3 + ["-1000"] * 3 + ["-10"]


@searched
@given(data=st.data())
def test_motmetrics_reads_the_tracks_in_our_pixels(any_frame_result, tmp_path, data):
    results = drawn_drive(data, any_frame_result)
    clip = clip_of(tmp_path, results)
    expected = [
        (result.index + 1, t.track_id, t.box.x, t.box.y, t.box.w, t.box.h, t.score)
        for result in results
        for t in result.tracks
    ]
    assert write_mot(tmp_path / "m.txt", clip, lambda: None) == len(expected)
    if not expected:
        assert (tmp_path / "m.txt").read_text() == ""
        return
    # motmetrics takes MOTChallenge's origin of (1, 1) away again.
    frame = motmetrics.io.loadtxt(
        tmp_path / "m.txt", fmt=motmetrics.io.Format.MOT15_2D, min_confidence=-np.inf
    ).reset_index()
    columns = ["FrameId", "Id", "X", "Y", "Width", "Height", "Confidence"]
    found = list(frame[columns].itertuples(index=False, name=None))
    assert np.array(found) == pytest.approx(np.array(expected), abs=1e-12, rel=1e-12)


def coco_api(path: Path) -> COCO:
    with contextlib.redirect_stdout(io.StringIO()):  # it prints as it loads
        return COCO(str(path))


@searched
@given(data=st.data())
def test_pycocotools_reads_every_box_with_its_track(any_frame_result, tmp_path, data):
    results = drawn_drive(data, any_frame_result)
    clip = clip_of(tmp_path, results)
    write_coco(tmp_path / "labels.json", [clip], all_frames)
    api = coco_api(tmp_path / "labels.json")
    images: Any = api.loadImgs(api.getImgIds())
    assert [(image["frame"], image["time_ns"], image["clip"]) for image in images] == [
        (result.index, result.time_ns, "trip") for result in results
    ]
    for image, result in zip(images, results, strict=True):
        found: Any = api.loadAnns(api.getAnnIds(imgIds=[image["id"]]))
        assert [(a["bbox"], a["track_id"], a["score"], a["seen_by"]) for a in found] == [
            ([t.box.x, t.box.y, t.box.w, t.box.h], t.track_id, t.score, t.seen_by) for t in result.tracks
        ]
        assert [a["area"] for a in found] == [t.box.w * t.box.h for t in result.tracks]
    (category,) = api.loadCats(api.getCatIds())
    assert category["name"] == "vehicle"


def all_frames(clip: DriveClip) -> Iterator[FrameBoxes]:
    return track_frames(clip, lambda: None)


def third_frames(clip: DriveClip) -> Iterator[FrameBoxes]:
    return track_frames(clip, lambda: None, every=3)


def two_drives(folder: Path) -> list[DriveClip]:
    for name, frames in (("first", 12), ("second", 7)):
        write_log(folder / name / "drive.mcap", marked_drive(frames), drive_header())
    return [DriveClip.open(folder / name / "drive.mcap", name) for name in ("first", "second")]


def test_drives_with_pictures_are_a_folder_that_training_and_evaluation_read(tmp_path):
    out = tmp_path / "labelled"
    out.mkdir()
    boxes = write_coco(out / "labels.json", two_drives(tmp_path), third_frames, with_pictures=True)
    assert boxes == 3 + 3  # frames 0, 3, 6, 9 and 0, 3, 6, of which 4 and 9 hold no vehicle
    training = load_training_set(out)
    assert [image.labelled.clip for image in training] == ["first"] * 4 + ["second"] * 3
    assert training[0].calibration == drive_header().calibration
    annotated = read_annotated(out / "labels.json", out / "images")
    assert [image.time_s for image in annotated] == [0.0, 0.12, 0.24, 0.36, 0.0, 0.12, 0.24]
    calibration_of = calibration_source(out / "calibration")
    for image in annotated:
        assert isinstance(calibration_of(image.labelled), Calibration)
    assert count_only(annotated, ["coasting=false"])[1].counted.tolist() == [False]  # frame 3 coasts
    second = training[1].labelled
    picture = second.read()
    truth = marked_picture(3)
    assert np.abs(picture.astype(int) - truth).mean() < 4  # H.264 and JPEG lose a little
    assert second.boxes.tolist() == [[44.5, 180.0, 72.0, 54.0]]


def test_labels_without_pictures_write_one_file_only(tmp_path):
    out = tmp_path / "labelled"
    out.mkdir()
    write_coco(out / "labels.json", two_drives(tmp_path), all_frames)
    assert [path.name for path in out.iterdir()] == ["labels.json"]
    content = json.loads((out / "labels.json").read_text())
    identities = [annotation["id"] for annotation in content["annotations"]]
    assert len(set(identities)) == len(identities) == 10 + 6
    assert content["images"][-1]["file_name"] == "second/000006.jpg"
    assert len(read_labels(out / "labels.json", out / "images")) == 19


def test_boxes_do_not_wait_in_memory_for_the_end_of_a_long_drive(tmp_path):
    waiting: list[int] = []

    def many_boxes(clip: DriveClip) -> Iterator[FrameBoxes]:
        for result, boxes in all_frames(clip):
            waiting.append(sum(path.stat().st_size for path in tmp_path.glob(".*.partial.json")))
            yield result, list(boxes) * 200

    write_coco(tmp_path / "labels.json", two_drives(tmp_path)[:1], many_boxes)
    size = (tmp_path / "labels.json").stat().st_size
    assert waiting[-1] > 0.8 * size  # the last two of twelve frames are still to be written
    assert len(json.loads((tmp_path / "labels.json").read_text())["annotations"]) == 10 * 200


def test_pandas_reads_kitti_as_a_table(tmp_path):
    clip = clip_of(tmp_path, [result for result, _ in marked_drive(6)])
    write_kitti(tmp_path / "k.txt", clip, lambda: None)
    frame = pd.read_csv(tmp_path / "k.txt", sep=" ", names=KITTI_COLUMNS)
    assert frame["frame"].tolist() == [0, 1, 2, 3, 5]
    assert frame["left"].tolist() == [40.0, 41.5, 43.0, 44.5, 47.5]
