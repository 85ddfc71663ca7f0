"""The pictures of a drive log, decoded where they are asked for."""

from collections.abc import Iterator

import numpy as np
from av.codec.context import CodecContext, Flags
from av.error import FFmpegError
from av.packet import Packet
from av.video.codeccontext import VideoCodecContext
from av.video.frame import VideoFrame
from numpy.typing import NDArray

from fcw.bounded.pictures import DECODER_OPTIONS
from fcw.errors import UserError
from fcw.logs.decoded import bgr
from fcw.logs.mcap.reader import DriveLog


class LogPictures:
    """Pictures by the number of their frame.

    One after the other they are decoded on; a jump starts at the keyframe before. Not for several threads.
    """

    def __init__(self, log: DriveLog) -> None:
        self._log = log
        self._series = log.series()
        self._decoder: VideoCodecContext | None = None
        self._pictures: Iterator[VideoFrame] = iter(())
        self._last: VideoFrame | None = None

    def at(self, frame_index: int) -> NDArray[np.uint8]:
        """The picture of a frame: (height, width, 3) uint8, BGR.

        Raises:
            IndexError: the log has no such frame.
            UserError: its picture is missing, as at the end of a torn log, or damaged beyond decoding.
        """
        row = self._series.row_of(frame_index)
        time_ns = int(self._series.time_ns[row])
        if not self._decodes_on_to(row, time_ns):
            self._seek(time_ns)
        while self._last is None or self._last.pts != time_ns:
            self._last = next(self._pictures, None)
            if self._last is None or (self._last.pts or 0) > time_ns:
                raise UserError(
                    f"{self._log.path}: no picture of frame {frame_index} at {time_ns / 1e9:.3f} s in it; "
                    "it is missing or damaged"
                )
        size = self._log.header.image_size
        image = bgr(self._last)
        return image[: size.height, : size.width]  # H.264 of our own may have a row or column more

    def close(self) -> None:
        """Let the decoder and the file go."""
        self._pictures = iter(())
        self._last = self._decoder = None

    def _decodes_on_to(self, row: int, time_ns: int) -> bool:
        """Whether the picture is reached from the last one no later than from its keyframe."""
        if self._last is None or self._last.pts is None or self._last.pts > time_ns:
            return False
        keyframe_ns = self._series.keyframe_before(time_ns)
        is_next = row > 0 and self._series.time_ns[row - 1] == self._last.pts
        return is_next or keyframe_ns is None or keyframe_ns <= self._last.pts

    def _seek(self, time_ns: int) -> None:
        self.close()
        decoder = CodecContext.create("h264", "r")
        assert isinstance(decoder, VideoCodecContext)
        # Frame threads would hold pictures back, and a decoder dropped with them waits for ever.
        decoder.thread_type = "SLICE"
        decoder.options = DECODER_OPTIONS
        decoder.flags |= Flags.low_delay  # no B frames in a log: each packet gives its picture at once
        self._decoder = decoder
        self._pictures = self._decoded(decoder, time_ns)

    def _decoded(self, decoder: VideoCodecContext, time_ns: int) -> Iterator[VideoFrame]:
        for video_packet in self._log.video_packets(time_ns):
            packet = Packet(video_packet.data)
            packet.pts = packet.dts = video_packet.time_ns
            try:
                yield from decoder.decode(packet)
            except FFmpegError:
                continue  # its picture is missing; others can still come
        try:
            yield from decoder.decode(None)
        except FFmpegError:
            return
