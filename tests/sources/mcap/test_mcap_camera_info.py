"""Which camera info of an MCAP file is that of the pictures, by the names of topics and frames."""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mcap_files import START_NS, ros_file, ros_header, ros_image

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.lens.model import Lens
from fcw.frame import ImageSize
from fcw.sources.mcap.facts import McapFacts, mcap_facts

IMAGE, INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
WIDTH = 640


def info(angle_degrees: float, frame_id: str) -> SimpleNamespace:
    focal_px = WIDTH / 2 / math.tan(math.radians(angle_degrees / 2))
    k = [focal_px, 0.0, 320.0, 0.0, focal_px, 180.0, 0.0, 0.0, 1.0]
    size = {"height": 360, "width": WIDTH, "distortion_model": "plumb_bob"}
    return SimpleNamespace(header=header(frame_id), **size, d=[], k=k, r=[0.0] * 9, p=[0.0] * 12)


def lens_notes(folder: Path, topic: str, model: str, d: list[float], calibration: Calibration) -> list[str]:
    """What is told of the lens of a camera info beside pictures."""
    image = ros_image(np.zeros((4, 6, 1), np.uint8), "mono8", START_NS)
    bent = SimpleNamespace(**vars(info(60.0, "")) | {"d": d, "distortion_model": model})
    messages = [(topic, IMAGE, START_NS, image), ("/front/camera_info", INFO, START_NS, bent)]
    return [*mcap_facts(ros_file(folder / "drive.mcap", messages)).notes_on_lens(calibration)]


def test_a_lens_of_the_file_that_the_calibration_lacks_is_told_with_what_it_does(tmp_path: Path) -> None:
    camera = GroundPlaneCamera(0.03, 554.0, 179.5, 1.4, 319.5)
    plain = Calibration.from_camera(camera, ImageSize(WIDTH, 360))
    k1 = [-0.1, 0.0, 0.0, 0.0, 0.0]
    (note,) = lens_notes(tmp_path, "/front/image", "plumb_bob", k1, plain)
    # At the farthest corner, (-320, -180) px from the axis, x / z and y / z are less by k1 r^2 of them.
    focal_px = WIDTH / 2 / math.tan(math.radians(30))
    corner_px = math.hypot(320, 180)
    assert f"corners by {0.1 * corner_px * (corner_px / focal_px) ** 2:.0f} px" in note
    assert "/front/camera_info" in note
    assert lens_notes(tmp_path, "/front/image_rect_color", "plumb_bob", k1, plain) == []
    for straight in ([], [0.0] * 5, [1e-4, 0.0, 0.0, 0.0, 0.0], [math.nan] * 5):
        assert lens_notes(tmp_path, "/front/image", "plumb_bob", straight, plain) == []
    assert lens_notes(tmp_path, "/front/image", "another", k1, plain) == []
    lens = Lens("radtan", 554.0, 554.0, 319.5, 179.5, tuple(k1), ImageSize(WIDTH, 360))
    assert lens_notes(tmp_path, "/front/image", "plumb_bob", k1, replace(plain, lens=lens)) == []


def header(frame_id: str) -> SimpleNamespace:
    return SimpleNamespace(stamp=ros_header(START_NS).stamp, frame_id=frame_id)


def facts(
    folder: Path, pictures: Mapping[str, str], infos: Mapping[str, tuple[float, str]], topic: str
) -> McapFacts:
    """Of a file with pictures on topics in frames, and with camera infos of some degrees in frames."""
    messages = []
    for name, frame_id in pictures.items():
        image = ros_image(np.zeros((4, 6, 1), np.uint8), "mono8", START_NS)
        image.header = header(frame_id)
        messages.append((name, IMAGE, START_NS, image))
    messages += [(name, INFO, START_NS, info(*what)) for name, what in infos.items()]
    return mcap_facts(ros_file(folder / "drive.mcap", messages), topic)


@pytest.mark.parametrize(
    ("pictures", "infos", "expected"),
    [
        pytest.param(
            {"/a_wide/image/compressed": "", "/b_tele/image/compressed": ""},
            {"/a_wide/camera_info": (116.0, ""), "/b_tele/camera_info": (39.0, "")},
            {"/a_wide/image/compressed": 116.0, "/b_tele/image/compressed": 39.0},
            id="the same name space",
        ),
        pytest.param(
            {"/front_image": "front", "/rear_image": "rear"},
            {"/front_info": (60.0, "front"), "/rear_info": (90.0, "rear")},
            {"/front_image": 60.0, "/rear_image": 90.0},
            id="the same frame",
        ),
        pytest.param(
            {"/stereo/left/image": "stereo", "/stereo/right/image": "stereo"},
            {"/stereo/left/camera_info": (60.0, "stereo"), "/stereo/right/camera_info": (61.0, "stereo")},
            {"/stereo/left/image": 60.0, "/stereo/right/image": 61.0},
            id="one frame of two cameras",
        ),
        pytest.param(
            {"/front/image": "", "/rear/image": ""},
            {"/front/camera_info": (60.0, "")},
            {"/front/image": 60.0, "/rear/image": None},
            id="that of the other camera only",
        ),
        pytest.param({"/camera": ""}, {"/camera_info": (60.0, "")}, {"/camera": 60.0}, id="one of each"),
        pytest.param(
            {"/image": "x"},
            {"/a/camera_info": (60.0, "a"), "/b/camera_info": (90.0, "b")},
            {"/image": None},
            id="nobody knows whose",
        ),
        pytest.param(
            {"/image": "camera"},
            {"/a/camera_info": (60.0, "other"), "/b/camera_info": (90.0, "camera")},
            {"/image": 90.0},
            id="only the frame tells",
        ),
    ],
)
def test_the_field_of_view_is_that_of_the_camera_of_the_pictures(
    pictures: Mapping[str, str],
    infos: Mapping[str, tuple[float, str]],
    expected: Mapping[str, float | None],
    tmp_path: Path,
) -> None:
    for topic, degrees in expected.items():
        found = facts(tmp_path, pictures, infos, topic)
        assert found.pictures == topic
        assert set(found.other_pictures) == set(pictures) - {topic}
        if degrees is None:
            assert (found.field_of_view_rad, found.camera_topic) == (None, "")
        else:
            assert found.field_of_view_rad == pytest.approx(math.radians(degrees))
            assert infos[found.camera_topic][0] == degrees
