"""Encoding for the logs: one packet a frame, at once, no B frames, a keyframe a second."""

import cv2
import numpy as np
import pytest
from av.codec.context import CodecContext
from av.packet import Packet
from av.video.codeccontext import VideoCodecContext

from fcw.errors import UserError
from fcw.frame import Frame, ImageSize
from fcw.logs.encode import VideoEncoder
from fcw.sources import h264

NS = 1_000_000_000


def moving_scene(width: int, height: int, count: int) -> list[np.ndarray]:
    """Smooth colours that move, as a picture of a road does."""
    generator = np.random.default_rng(1)
    wide = cv2.resize(generator.integers(60, 190, (5, 12, 3), np.uint8), (2 * width, height))
    return [np.ascontiguousarray(wide[:, 2 * i : 2 * i + width]) for i in range(count)]


@pytest.mark.parametrize(("width", "height"), [(64, 48), (65, 48), (64, 49), (125, 37)])
def test_each_packet_decodes_at_once_to_its_frame(width: int, height: int):
    images = moving_scene(width, height, 30)
    encoder = VideoEncoder(ImageSize(width, height), 30.0)
    decoder = CodecContext.create("h264", "r")
    assert isinstance(decoder, VideoCodecContext)
    decoder.thread_type = "SLICE"
    decoder.flags |= 1 << 19  # AV_CODEC_FLAG_LOW_DELAY: give a picture with its packet
    for i, image in enumerate(images):
        (packet,) = encoder.encode(Frame(i, i * NS // 30, image))
        assert (packet.time_ns, packet.shown) == (i * NS // 30, True)
        (picture,) = decoder.decode(Packet(packet.data))
        shown = picture.to_ndarray(format="bgr24")
        # Coordinates stay: only a last column or row may be added.
        assert shown.shape == (height + height % 2, width + width % 2, 3)
        assert cv2.PSNR(shown[:height, :width], image) > 30
    encoder.close()


@pytest.mark.parametrize("step_ns", [NS // 30, NS // 10, NS * 3 // 4, 7 * NS])
def test_a_keyframe_each_second_of_the_drive_and_no_b_frames(step_ns: int):
    images = moving_scene(64, 48, 40)
    encoder = VideoEncoder(ImageSize(64, 48), NS / step_ns)
    keyframes: list[int] = []
    for i, image in enumerate(images):
        (packet,) = encoder.encode(Frame(i, i * step_ns, image))
        unit = h264.inspect(packet.data)
        assert unit is not None
        assert not unit.bidirectional
        assert unit.idr == packet.keyframe
        assert unit.parameter_sets or not packet.keyframe
        if packet.keyframe:
            keyframes.append(packet.time_ns)
    encoder.close()
    period = max(1, -(-NS // step_ns))
    assert keyframes == [i * step_ns for i in range(0, 40, period)]


def test_an_encoder_that_cannot_be_started_says_so_at_once():
    with pytest.raises(UserError, match=r"pictures of 40000x40000: the encoder .* cannot be started"):
        VideoEncoder(ImageSize(40000, 40000), 30)
