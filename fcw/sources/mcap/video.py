"""Reads a stream of video packets, one for each picture, as in MCAP logs."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from av.codec.context import CodecContext
from av.error import FFmpegError
from av.packet import Packet
from av.video.codeccontext import VideoCodecContext
from av.video.frame import VideoFrame
from numpy.typing import NDArray

from fcw.bounded.pictures import DECODER_OPTIONS
from fcw.errors import UserError
from fcw.frame import FALLBACK_RATE_HZ, Frame, ImageSize, VideoPacket
from fcw.logs.decoded import bgr
from fcw.sources import h264
from fcw.units import NS_PER_S

REORDERING_PACKETS = 16
"""H.264 and its successors delay at most 16 pictures; older packets have already given theirs."""

PacketStream = Callable[[int | None], Iterator[VideoPacket]]
"""Gives packets in decoding order: all of them, or from the keyframe at a time."""


@dataclass(frozen=True, slots=True)
class _Table:
    """What one pass over the packets shows, without decoding.

    Attributes:
        times_ns: times of the pictures that are meant to be shown, ascending.
        keyframes_ns: times of the packets at which decoding can start, ascending.
        relayable: whether there are no B slices, and the first packet is a keyframe.
        disordered: whether pictures refer to later ones but are stored in presentation order.
    """

    times_ns: NDArray[np.int64]
    keyframes_ns: NDArray[np.int64]
    relayable: bool
    disordered: bool


class PacketVideoSource:
    """Reads the pictures of a stream of packets.

    Attributes:
        name: name of the file.
        image_size: size of every picture.
        zero_utc_ns: see `fcw.frame.DatedSource`; a log of this program may have it.
    """

    zero_utc_ns: int | None = None

    def __init__(
        self,
        name: str,
        label: str,
        packets: PacketStream,
        codec: str = "h264",
        file_notes: Callable[[], tuple[str, ...]] = tuple,
        stated_size: ImageSize | None = None,
    ) -> None:
        """Decode the first picture.

        Args:
            name: name of the source.
            label: file and topic, for messages.
            packets: gives the stream, once for each pass.
            codec: FFmpeg's name of its codec.
            file_notes: gives the present notes about the file.
            stated_size: size of the pictures, if the file states it; encoded pictures of odd size have one
                more row or column.

        Raises:
            UserError: no picture in it decodes.
        """
        self.name, self._label = name, label
        self._packets, self._codec, self._file_notes = packets, codec, file_notes
        self._notes: tuple[str, ...] = ()
        self._undecodable = self._swallowed = 0
        self._reorders = False
        first = next((picture for picture, _ in self._pictures(None)), None)
        if first is None:
            raise UserError(f"{label}: no picture in its {codec} video can be decoded; expected at least one")
        self._coded_size = size = ImageSize(first.width, first.height)
        if stated_size is not None and size == _even(stated_size):
            size = stated_size
        self.image_size = size
        self._plain = codec == "h264" and first.format.name in ("yuv420p", "yuvj420p")

    @property
    def frame_count(self) -> int:
        """Number of pictures to be shown, if all decode."""
        return len(self.times_ns)

    @property
    def times_ns(self) -> NDArray[np.int64]:
        """Times of all pictures, ascending, from one pass over the packets without decoding."""
        return self._table.times_ns

    @property
    def frame_rate_hz(self) -> float:
        """Rate from the median step of the times."""
        return frame_rate_hz(self.times_ns)

    @property
    def relays_video(self) -> bool:
        """Whether frames carry packets: 8-bit 4:2:0 H.264 without B frames."""
        return self._plain and self._table.relayable

    @property
    def notes(self) -> tuple[str, ...]:
        """After iteration, what could not be read."""
        return self._notes + self._file_notes()

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """Frames from the first one at or after `start_ns`.

        The first frame carries the earlier packets that its decoding needs, marked as not shown. So does a
        frame after pictures that were left out.
        """
        table, relays = self._table, self.relays_video
        key_ns = None
        if start_ns is not None and start_ns > table.times_ns[0] and self._codec == "h264":
            before = table.keyframes_ns[table.keyframes_ns <= start_ns]
            key_ns = int(before[-1]) if len(before) else None
        last_ns: int | None = None
        index = 0 if key_ns is None else int(np.searchsorted(table.times_ns, key_ns))
        late = 0
        waiting: list[VideoPacket] = []
        self._undecodable = 0
        for picture, packets in self._pictures(key_ns):
            own = packets[-1]
            waiting += packets
            if not own.shown:
                continue
            if last_ns is not None and own.time_ns <= last_ns:
                late += 1
                continue
            if ImageSize(picture.width, picture.height) != self._coded_size:
                self._notes = (
                    f"{self._label}: the picture size changes from {self._coded_size} to "
                    f"{picture.width}x{picture.height}; the rest is left out",
                )
                return
            last_ns = own.time_ns
            if start_ns is None or own.time_ns >= start_ns:
                carried = (*(_hidden(packet, own.time_ns) for packet in waiting[:-1]), own)
                image = bgr(picture)[: self.image_size.height, : self.image_size.width]
                yield Frame(index, own.time_ns, np.ascontiguousarray(image), carried if relays else ())
                waiting = []
            index += 1
        self._notes = tuple(self._lost(late))

    def _pictures(self, key_ns: int | None) -> Iterator[tuple[VideoFrame, tuple[VideoPacket, ...]]]:
        """Every picture that decodes, with the packets since the previous one; its own packet is the last."""
        codec = _decoder(self._codec)
        fed: dict[int, VideoPacket] = {}
        handed = -1
        expected, given, refused = 0, 0, self._undecodable

        def taken(picture: VideoFrame) -> tuple[VideoFrame, tuple[VideoPacket, ...]]:
            nonlocal handed
            own = picture.pts if picture.pts in fed else max(fed)
            packets = tuple(fed[number] for number in sorted(fed) if handed < number < own)
            handed = max(handed, own)
            for number in [number for number in fed if number < own - REORDERING_PACKETS]:
                del fed[number]
            return picture, (*packets, fed[own])

        for number, packet in enumerate(self._packets(key_ns)):
            encoded = Packet(packet.data)
            encoded.pts = encoded.dts = number
            fed[number] = packet
            expected += h264.holds_picture(packet.data, self._codec)
            try:
                pictures = codec.decode(encoded)
            except FFmpegError:
                self._undecodable += 1
                pictures = []
            self._reorders |= bool(codec.has_b_frames)
            given += len(pictures)
            for picture in pictures:
                yield taken(picture)
        try:
            for picture in codec.decode(None):
                given += 1
                yield taken(picture)
        except FFmpegError:
            self._undecodable += 1
        # FFmpeg does not report pictures that it leaves out because a reference is missing.
        self._swallowed = max(expected - given - (self._undecodable - refused), 0)

    def _lost(self, late: int) -> Iterator[str]:
        if self._undecodable:
            yield f"{self._label}: {counted(self._undecodable)} damaged beyond decoding, left out"
        if self._swallowed:
            yield (
                f"{self._label}: {counted(self._swallowed)} left out by the decoder: what they refer to is "
                "missing, or stands after them"
            )
        if self._table.disordered:
            yield (
                f"{self._label}: pictures refer to later ones (B frames), but stand in the order in which "
                "they are shown, so they come out damaged: write the packets in decoding order, or encode "
                "without B frames"
            )
        if late:
            yield f"{self._label}: {counted(late)} with a time not after the one before, left out"

    @cached_property
    def _table(self) -> _Table:
        times_ns: list[int] = []
        keyframes_ns: list[int] = []
        plain, bidirectional = True, False
        for number, packet in enumerate(self._packets(None)):
            unit = h264.inspect(packet.data) if self._codec == "h264" else None
            bidirectional |= unit is not None and unit.bidirectional
            startable = unit is not None and unit.idr and unit.parameter_sets
            plain &= unit is not None and not unit.bidirectional and startable == unit.idr
            plain &= startable or number > 0
            if startable:
                keyframes_ns.append(packet.time_ns)
            if packet.shown:
                times_ns.append(packet.time_ns)
        times = np.array(times_ns, np.int64)
        reordered = bidirectional or self._reorders
        rising = times if reordered or not len(times) else np.maximum.accumulate(times)
        disordered = bidirectional and self._reorders and bool(np.all(np.diff(times) > 0))
        return _Table(np.unique(rising), np.unique(np.array(keyframes_ns, np.int64)), plain, disordered)


def reorders(packets: Iterable[bytes], codec_name: str) -> bool:
    """Whether the first packets show that the order of decoding differs from that of presentation."""
    codec = _decoder(codec_name)
    for packet in packets:
        with suppress(FFmpegError):  # one before the first keyframe
            codec.decode(Packet(packet))
        if codec.has_b_frames:
            return True
    return False


def _decoder(codec_name: str) -> VideoCodecContext:
    codec = CodecContext.create(codec_name, "r")
    assert isinstance(codec, VideoCodecContext)
    codec.thread_type = "SLICE"
    codec.options = DECODER_OPTIONS
    return codec


def frame_rate_hz(times_ns: NDArray[np.int64]) -> float:
    """Pictures per second from the median step of the times."""
    steps_ns = np.diff(times_ns)
    return NS_PER_S / float(np.median(steps_ns)) if len(steps_ns) else FALLBACK_RATE_HZ


def _even(size: ImageSize) -> ImageSize:
    return ImageSize(size.width + size.width % 2, size.height + size.height % 2)


def counted(pictures: int) -> str:
    """A number of pictures in words."""
    return "1 picture" if pictures == 1 else f"{pictures} pictures"


def _hidden(packet: VideoPacket, limit_ns: int) -> VideoPacket:
    """The packet marked as not shown, with a time not later than the frame that it precedes."""
    return replace(packet, time_ns=min(packet.time_ns, limit_ns), shown=False)
