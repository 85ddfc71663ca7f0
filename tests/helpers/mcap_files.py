"""MCAP files as others make them: with Foxglove's SDK and with the ROS 2 registry's own writer."""

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import islice
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import Any

import av
import cv2
import foxglove
import numpy as np
from foxglove.channels import CompressedImageChannel, CompressedVideoChannel, RawImageChannel
from foxglove.messages import CompressedImage, CompressedVideo, RawImage, Timestamp
from mcap_ros2.writer import Writer
from numpy.typing import NDArray

from fcw.frame import Frame
from fcw.sources import open_source

DEMO = Path(__file__).parents[2] / "recordings" / "demo"
START_NS = 1_760_000_000_123_456_789
"""A day in 2025: recorders stamp with the wall clock."""
DELAY_NS = 40_000_000
"""From the camera's stamp to the log."""

HEADER = """================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
VECTOR = """================================================================================
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
COVARIANT = """================================================================================
MSG: geometry_msgs/TwistWithCovariance
geometry_msgs/Twist twist
float64[36] covariance
"""
ROS_SCHEMAS = {
    "sensor_msgs/msg/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data\n" + HEADER,
    "sensor_msgs/msg/Image": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
        "uint32 step\nuint8[] data\n" + HEADER
    ),
    "geometry_msgs/msg/TwistStamped": "std_msgs/Header header\ngeometry_msgs/Twist twist\n" + HEADER + VECTOR,
    "geometry_msgs/msg/TwistWithCovarianceStamped": (
        "std_msgs/Header header\ngeometry_msgs/TwistWithCovariance twist\n" + HEADER + COVARIANT + VECTOR
    ),
    "sensor_msgs/msg/CameraInfo": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\n"
        "float64[9] k\nfloat64[9] r\nfloat64[12] p\n" + HEADER
    ),
}


def demo_frames(count: int) -> list[Frame]:
    """The first frames of the shipped drive."""
    return list(islice(open_source(DEMO / "drive.mp4").frames(), count))


def stamp_ns(frame: Frame) -> int:
    """The wall clock at a frame."""
    return START_NS + frame.time_ns


def jpeg(image: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 90])[1].tobytes()


def _timestamp(time_ns: int) -> Timestamp:
    return Timestamp(sec=time_ns // 10**9, nsec=time_ns % 10**9)


def foxglove_images(path: Path, frames: Iterable[Frame], topics: Sequence[str] = ("/camera",)) -> Path:
    """foxglove.CompressedImage with JPEG on each topic."""
    context = foxglove.Context()
    with foxglove.open_mcap(path, context=context):
        channels = [CompressedImageChannel(topic, context=context) for topic in topics]
        for frame in frames:
            for channel in channels:
                message = CompressedImage(
                    timestamp=_timestamp(stamp_ns(frame)), data=jpeg(frame.image), format="jpeg"
                )
                channel.log(message, log_time=stamp_ns(frame) + DELAY_NS)
    return path


def foxglove_raw_images(path: Path, frames: Iterable[Frame]) -> Path:
    """foxglove.RawImage with rgb8."""
    context = foxglove.Context()
    with foxglove.open_mcap(path, context=context):
        channel = RawImageChannel("/camera", context=context)
        for frame in frames:
            height, width = frame.image.shape[:2]
            message = RawImage(
                timestamp=_timestamp(stamp_ns(frame)),
                width=width,
                height=height,
                encoding="rgb8",
                step=3 * width,
                data=np.ascontiguousarray(frame.image[..., ::-1]).tobytes(),
            )
            channel.log(message, log_time=stamp_ns(frame) + DELAY_NS)
    return path


def encoded(frames: list[Frame], codec_name: str, options: dict[str, str]) -> list[tuple[int, bytes]]:
    """Stamps and packets of 320x180 pixels, by an encoder of FFmpeg."""
    codec = av.CodecContext.create(codec_name, "w")
    assert isinstance(codec, av.VideoCodecContext)
    codec.width, codec.height, codec.pix_fmt = 320, 180, "yuv420p"
    codec.time_base, codec.options = Fraction(1, 30), options
    packets = []
    for number, frame in enumerate(frames):
        smaller = np.asarray(cv2.resize(frame.image, (320, 180)), np.uint8)
        picture = av.VideoFrame.from_ndarray(smaller, format="bgr24")
        picture.pts = number
        packets += codec.encode(picture)
    packets += codec.encode(None)
    return [(stamp_ns(frames[packet.pts]), bytes(packet)) for packet in packets]


def foxglove_video(
    path: Path,
    packets: Iterable[tuple[int, bytes]],
    video_format: str = "h264",
    wrong_by_ns: Mapping[int, int] = MappingProxyType({}),
) -> Path:
    """foxglove.CompressedVideo of times and packets; the stamps of some, by their numbers, are wrong."""
    context = foxglove.Context()
    with foxglove.open_mcap(path, context=context):
        channel = CompressedVideoChannel("/video", context=context)
        for number, (time_ns, data) in enumerate(packets):
            stamp = _timestamp(time_ns + wrong_by_ns.get(number, 0))
            message = CompressedVideo(timestamp=stamp, data=data, format=video_format)
            channel.log(message, log_time=time_ns + DELAY_NS)
    return path


def ros_header(time_ns: int) -> SimpleNamespace:
    stamp = SimpleNamespace(sec=time_ns // 10**9, nanosec=time_ns % 10**9)
    return SimpleNamespace(stamp=stamp, frame_id="camera")


def ros_image(image: NDArray[np.uint8], encoding: str, time_ns: int, padding: int = 0) -> SimpleNamespace:
    """sensor_msgs/Image of an array that is in the encoding already; rows may be padded."""
    height, width = image.shape[:2]
    rows = np.pad(image.reshape(height, -1), ((0, 0), (0, padding)))
    return SimpleNamespace(
        header=ros_header(time_ns),
        height=height,
        width=width,
        encoding=encoding,
        is_bigendian=0,
        step=rows.shape[1],
        data=rows.tobytes(),
    )


def ros_jpeg(frame: Frame, time_ns: int | None = None) -> SimpleNamespace:
    """sensor_msgs/CompressedImage of a frame."""
    time_ns = stamp_ns(frame) if time_ns is None else time_ns
    data = jpeg(frame.image)
    return SimpleNamespace(header=ros_header(time_ns), format="bgr8; jpeg compressed bgr8", data=data)


def ros_twist(time_ns: int, speed_mps: float) -> SimpleNamespace:
    """geometry_msgs/TwistStamped straight ahead."""
    zero = SimpleNamespace(x=0.0, y=0.0, z=0.0)
    linear = SimpleNamespace(x=speed_mps, y=0.0, z=0.0)
    return SimpleNamespace(header=ros_header(time_ns), twist=SimpleNamespace(linear=linear, angular=zero))


def ros_file(
    path: Path, messages: Iterable[tuple[str, str, int, Any]], chunk_size: int = 1024 * 1024
) -> Path:
    """A ROS 2 recording of (topic, type, log time, message)."""
    with path.open("wb") as file:
        writer = Writer(file, chunk_size)
        schemas: dict[str, Any] = {}
        for topic, kind, log_ns, message in messages:
            if kind not in schemas:
                schemas[kind] = writer.register_msgdef(kind, ROS_SCHEMAS[kind])
            writer.write_message(topic, schemas[kind], message, log_ns, log_ns)
        writer.finish()
    return path
