"""The Foxglove layout that ships: every panel stands in it once, and shows what a drive log has."""

import json
import re
from collections.abc import Iterator
from importlib.resources import files
from typing import Any

import pytest

from fcw.logs.mcap import format as mcap_format
from fcw.logs.mcap import writer as mcap_writer

LAYOUT = json.loads((files("fcw_viz") / "foxglove_layout.json").read_text())
PANELS: dict[str, Any] = LAYOUT["configById"]
TOPICS = {topic: kind.DESCRIPTOR for topic, kind in mcap_writer._TOPICS.items()}


def leaves(node: Any) -> Iterator[str]:
    if isinstance(node, str):
        yield node
    else:
        assert node["direction"] in ("row", "column")
        assert 0 < node.get("splitPercentage", 50) < 100
        yield from leaves(node["first"])
        yield from leaves(node["second"])


def test_every_panel_stands_in_the_layout_once() -> None:
    placed = list(leaves(LAYOUT["layout"]))
    assert sorted(placed) == sorted(PANELS)
    assert {name.split("!")[0] for name in placed} == {"Image", "3D", "StateTransitions", "Plot", "RosOut"}


def message_paths() -> list[str]:
    return [path["value"] for panel in PANELS.values() for path in panel.get("paths", [])]


@pytest.mark.parametrize("path", message_paths())
def test_every_path_is_a_field_of_its_topics_messages(path: str) -> None:
    topic, field = re.fullmatch(r"(/[\w/]+)\.(\w+)", path).groups()  # pyright: ignore[reportOptionalMemberAccess]
    assert field in TOPICS[topic].fields_by_name


def test_the_picture_has_its_annotations_and_its_calibration() -> None:
    mode = PANELS["Image!camera"]["imageMode"]
    assert TOPICS[mode["imageTopic"]].full_name == "foxglove.CompressedVideo"
    assert TOPICS[mode["calibrationTopic"]].full_name == "foxglove.CameraCalibration"
    assert [TOPICS[topic].full_name for topic in mode["annotations"]] == ["foxglove.ImageAnnotations"]
    assert TOPICS[PANELS["RosOut!log"]["topicToRender"]].full_name == "foxglove.Log"


def test_the_ground_is_seen_in_the_vehicles_axes() -> None:
    ground = PANELS["3D!ground"]
    shown = [topic for topic, state in ground["topics"].items() if state["visible"]]
    assert [TOPICS[topic].full_name for topic in shown] == ["foxglove.SceneUpdate"]
    assert ground["followTf"] == ground["layers"]["grid"]["frameId"] == "ego"
    assert mcap_format.TRANSFORMS_TOPIC in TOPICS
