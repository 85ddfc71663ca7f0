"""Pictures as cameras encode them, and clear words on messages in an encoding that is not read here."""

import json
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mcap.writer import Writer
from mcap_files import ROS_SCHEMAS, START_NS, ros_file, ros_header, ros_image

from fcw.errors import UserError
from fcw.sources import open_source

COMPRESSED = "sensor_msgs/msg/CompressedImage"
JSON = ("foxglove.CompressedImage", "jsonschema", json.dumps({"type": "object"}), "json")
IDL = (COMPRESSED, "ros2idl", "module sensor_msgs { module msg { struct CompressedImage {}; }; };", "cdr")
DAMAGED = (COMPRESSED, "ros2msg", "std_msgs/Header", "cdr")
READ = (COMPRESSED, "ros2msg", ROS_SCHEMAS[COMPRESSED], "cdr")


def recording(path: Path, topics: Mapping[str, tuple[str, str, str, str]]) -> Path:
    """A message without content on each topic: of a schema's name, encoding and text, in an encoding."""
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        for topic, (name, schema_encoding, text, encoding) in topics.items():
            schema = writer.register_schema(name, schema_encoding, text.encode())
            writer.add_message(writer.register_channel(topic, encoding, schema), START_NS, b"", START_NS)
        writer.finish()
    return path


@pytest.mark.parametrize(
    ("of", "told"),
    [
        (JSON, r"its messages are json with jsonschema; expected protobuf with protobuf or cdr with ros2msg"),
        (IDL, r"its messages are cdr with ros2idl; expected"),
        (DAMAGED, r"the schema of its messages \(cdr with ros2msg\) is damaged"),
    ],
)
@pytest.mark.parametrize("topic", [None, "/front"])
def test_of_pictures_that_cannot_be_read_their_encoding_is_named(tmp_path, of, told, topic):
    path = recording(tmp_path / "drive.mcap", {"/front": of})
    with pytest.raises(UserError, match=told):
        open_source(path, topic=topic)


def test_the_one_camera_that_can_be_read_is_not_taken_for_the_one_that_is_meant(tmp_path):
    path = recording(tmp_path / "drive.mcap", {"/front": JSON, "/rear": READ})
    with pytest.raises(UserError, match=r"several topics of pictures: /front \(.*; /rear \(.*--topic"):
        open_source(path)
    with pytest.raises(UserError, match=r"/front: its messages are json .*; expected one of: /rear \("):
        open_source(path, topic="/front")


def test_a_video_in_messages_of_single_pictures_is_told_by_its_format(tmp_path):
    message = SimpleNamespace(header=ros_header(START_NS), format="h264", data=b"\0\0\1\x67")
    path = ros_file(tmp_path / "drive.mcap", [("/front", COMPRESSED, START_NS, message)])
    with pytest.raises(UserError, match=r"can be decoded \(they state the format 'h264'\); expected"):
        open_source(path)


@pytest.mark.parametrize("pattern", ["rggb", "grbg", "gbrg", "bggr"])
@pytest.mark.parametrize("size", [(8, 6), (7, 5)])
def test_what_a_colour_filter_lets_through_becomes_the_colour(tmp_path, pattern, size):
    # sensor_msgs/image_encodings: the letters are the filters of the first two rows' first two pixels.
    width, height = size
    seen = {"b": 10, "g": 120, "r": 250}
    filters = [[seen[letter] for letter in pattern[row : row + 2]] for row in (0, 2)]
    mosaic = np.tile(np.array(filters, np.uint8), (height, width))[:height, :width, None]
    message = ros_image(np.ascontiguousarray(mosaic), f"bayer_{pattern}8", START_NS)
    path = ros_file(tmp_path / "drive.mcap", [("/front", "sensor_msgs/msg/Image", START_NS, message)])
    (frame,) = open_source(path).frames()
    assert np.array_equal(frame.image, np.full((height, width, 3), [10, 120, 250]))
