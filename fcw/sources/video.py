"""Reads video files: pictures with their times, and their packets if a log can hold them as they are."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path

import numpy as np
from av.container import InputContainer
from av.video.frame import VideoFrame
from av.video.stream import VideoStream
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.frame import FALLBACK_RATE_HZ, Frame, ImageSize
from fcw.logs.decoded import bgr
from fcw.sources.decoding import (
    Decoding,
    annex_b_filter,
    announced_packets,
    is_plain_picture,
    moving_pictures,
    opened,
    seek_before,
    to_ns,
)
from fcw.sources.orientation import orientation, squaring
from fcw.units import NS_PER_S

MAXIMUM_FRAME_RATE_HZ = 1000.0
FIRST_YEAR = 2000
"""Earlier years come from clocks that were never set: these begin in 1904, 1970 or 1980."""
SHORTFALL_S = 1.0
"""A file that ends this much before its stated length counts as cut short; sound may outlast pictures."""
PICTURES_SHORTFALL_S, PICTURES_SHORTFALL_PERIODS = 0.2, 4
"""The same if the file states the length of the pictures alone; whole files lack up to three pictures."""

REORDERING_NS = NS_PER_S
"""B frames are a few pictures out of order in a file; a clock that steps back further was started anew."""


@dataclass(frozen=True, slots=True)
class _PacketTable:
    """What one pass over the packets shows, without decoding.

    Attributes:
        times_ns: times of the packets that are meant to be shown, ascending.
        relayable: every packet is one H.264 picture without B slices, the packets are in the order of their
            times, and every packet at which decoding can start contains its parameter sets.
        seekable: the clock never steps back, so that seeking finds a time.
        complete: every packet that is meant to be shown has a time of its own.
    """

    times_ns: NDArray[np.int64]
    relayable: bool
    seekable: bool
    complete: bool


@dataclass(frozen=True, slots=True)
class _StatedEnd:
    """The end of a file as the file states it.

    Attributes:
        time_ns: the stated end.
        shortfall_ns: how long before it the last picture of a whole file may be.
    """

    time_ns: int
    shortfall_ns: int


class _Clock:
    """Gives the times of pictures, always rising.

    Attributes:
        last_ns: time of the latest picture.
        estimated: how many pictures had no time, or one that was not after the picture before.
    """

    def __init__(self, stream: VideoStream, period_ns: int, by_decoding: bool) -> None:
        """`by_decoding`: the container states when to decode a picture, but not when to show it."""
        self.last_ns: int | None = None
        self.estimated = 0
        self._stream, self._period_ns, self._by_decoding = stream, period_ns, by_decoding
        self._stepped_ns = 0

    def time_ns(self, picture: VideoFrame) -> int:
        """The picture's own time; if it has none, one period after the picture before.

        After the stream's clock has stepped back, all later times are shifted so that they continue.
        """
        ticks = picture.dts if self._by_decoding else picture.pts
        own_ns = None if ticks is None else to_ns(ticks, self._stream) + self._stepped_ns
        time_ns = own_ns
        if time_ns is None or (self.last_ns is not None and time_ns <= self.last_ns):
            time_ns = 0 if self.last_ns is None else self.last_ns + self._period_ns
            self._stepped_ns += 0 if own_ns is None else time_ns - own_ns
            self.estimated += 0 if own_ns is None and self._by_decoding else 1
        self.last_ns = time_ns
        return time_ns


class VideoSource:
    """Reads the pictures of a video file.

    Attributes:
        path: path of the file.
        image_size: size of every picture after rotation, with square pixels.
        frame_rate_hz: average rate as the file states it.
        zero_utc_ns: when the file was created, as it states: nanoseconds since 1970, in UTC if the camera
            knew the zone; None if it states nothing.
    """

    def __init__(self, path: Path) -> None:
        """Open the file and read its first picture.

        Raises:
            UserError: the file is not a video, its codec is unknown here, or none of its pictures decodes.
        """
        self.path = path
        self._notes: tuple[str, ...] = ()
        with opened(path) as (container, stream):
            first = next(Decoding(container, stream).pictures(), None)
            if first is None:
                raise UserError(
                    f"{path}: the video stream holds no picture that can be decoded; "
                    "expected at least one: copy or record the file again"
                )
            self._coded_size = ImageSize(first.width, first.height)
            self._square, self._squared = squaring(stream, first)
            self._orient, self._turn = orientation(first)
            blank = np.empty((first.height, first.width, 1), np.uint8)
            height, width = self._orient(self._square(blank)).shape[:2]
            self.image_size = ImageSize(width, height)
            rate_hz = float(stream.average_rate or stream.guessed_rate or 0)
            self.frame_rate_hz = rate_hz if 0 < rate_hz <= MAXIMUM_FRAME_RATE_HZ else FALLBACK_RATE_HZ
            codec = stream.codec_context
            self._other_form = ""
            if self._turn or self._squared:
                self._other_form = f"they are {self._turn or self._squared}"
            elif codec.name != "h264":
                self._other_form = f"the video is {codec.name} and not H.264"
            elif codec.pix_fmt not in ("yuv420p", "yuvj420p"):
                self._other_form = f"their pixels are {codec.pix_fmt}, which most viewers do not show"
            self._avi = container.format.name == "avi"
            self._others = tuple(_other_videos(container, stream))
            self.zero_utc_ns = _created_ns(container.metadata.get("creation_time"))

    @property
    def name(self) -> str:
        """The file's name."""
        return self.path.name

    @property
    def frame_count(self) -> int | None:
        """Number of packets to be shown, from one pass over the file; None if they have no times."""
        return len(self._packet_table.times_ns) or None

    @property
    def times_ns(self) -> NDArray[np.int64] | None:
        """Times of all frames, ascending, from one pass over the file without decoding.

        None if only decoding can tell: pictures have no time of their own, or the clock steps back. In a
        damaged file, some of these frames may not decode.
        """
        table = self._packet_table
        return table.times_ns if table.seekable and table.complete else None

    @property
    def relays_video(self) -> bool:
        """Whether frames carry packets: upright 8-bit 4:2:0 H.264 with square pixels and no B frames.

        The first call reads every packet of the file once, without decoding.
        """
        return not self._other_form and self._packet_table.relayable

    @property
    def coded_anew(self) -> str:
        """Why frames carry no packets, so that a log encodes the pictures again; empty if they carry them."""
        if self.relays_video:
            return ""
        return self._other_form or "the video has B frames, or others that a log cannot hold as they are"

    @property
    def notes(self) -> tuple[str, ...]:
        """How pictures are turned, which of several videos is used, and, after reading, what is missing."""
        changes = [f"{self._squared}, because their pixels are not square"] if self._squared else []
        changes += [f"{self._turn}, as the file asks"] if self._turn else []
        notes = [f"{self.name}: pictures are {change}" for change in changes]
        if self._others:
            notes.append(
                f"{self.name}: holds {len(self._others) + 1} videos, as of cameras ahead and behind; the "
                f"first ({self._coded_size}) is used and not {', '.join(self._others)}: if another one looks "
                "ahead, put it into a file of its own (`ffmpeg -i IN -map 0:v:1 -c copy OUT.mp4`)"
            )
        return (*notes, *self._notes)

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """Frames from the first one at or after `start_ns`.

        If the source relays video, the first frame also carries the earlier packets that its decoding needs,
        marked as not shown. Packets after the last frame are dropped.
        """
        if start_ns is None:
            return self._frames(None, seek=False)
        table = self._packet_table
        return self._frames(start_ns, seek=table.seekable and start_ns > table.times_ns[0])

    def _frames(self, start_ns: int | None, seek: bool) -> Iterator[Frame]:
        self._notes = ()
        relays = self.relays_video
        with opened(self.path) as (container, stream):
            if seek and start_ns is not None and not seek_before(container, stream, start_ns):
                yield from self._frames(start_ns, seek=False)
                return
            decoding = Decoding(container, stream, relay=relays, sought=seek)
            # AVI has no presentation times; those that FFmpeg invents are right only without reordering.
            period_ns = round(NS_PER_S / self.frame_rate_hz)
            clock = _Clock(stream, period_ns, by_decoding=self._avi and not relays)
            index: int | None = None if seek else 0
            for picture in decoding.pictures():
                if ImageSize(picture.width, picture.height) != self._coded_size:
                    self._notes = (
                        f"{self.name}: the picture size changes from {self._coded_size} to "
                        f"{picture.width}x{picture.height} after {_seconds(clock.last_ns)}; the rest is left "
                        "out: cut the file there and run its parts",
                    )
                    return
                time_ns = clock.time_ns(picture)
                if index is None:
                    index = int(np.searchsorted(self._packet_table.times_ns, time_ns))
                if start_ns is None or time_ns >= start_ns:
                    packets = decoding.take_packets(time_ns) if relays else ()
                    if relays and not packets:
                        decoding.undecodable += 1  # its packet was too damaged to relay
                        continue
                    image = bgr(picture)
                    yield Frame(index, time_ns, self._orient(self._square(image)), packets)
                index += 1
            announced = None if seek else announced_packets(container, stream)
            counted = bool(announced and stream.frames)  # a fragmented MP4 announces only what was read
            end = None if counted else _stated_end(container, stream, period_ns)
        self._notes = tuple(self._damage(decoding, announced, end, clock))

    def _damage(
        self, decoding: Decoding, announced: int | None, end: _StatedEnd | None, clock: _Clock
    ) -> Iterator[str]:
        """Sentences about what a reading that came to the end could not read."""
        last_ns = clock.last_ns
        last = f"the last picture read is at {_seconds(last_ns)}"
        if announced and decoding.packets_read < announced:
            missing = announced - decoding.packets_read
            yield f"{self.name}: the file is cut short: {missing} of {announced} pictures missing, {last}"
        elif end is not None and last_ns is not None and end.time_ns - last_ns > end.shortfall_ns:
            yield (
                f"{self.name}: the file is cut short: {last}, but it should last until "
                f"{_seconds(end.time_ns)}"
            )
        elif decoding.error:
            yield f"{self.name}: the file cannot be read further ({decoding.error}), {last}"
        if decoding.undecodable:
            yield f"{self.name}: {_pictures(decoding.undecodable)} damaged beyond decoding, left out"
        if clock.estimated:
            yield f"{self.name}: {_pictures(clock.estimated)} without a time after the one before, estimated"

    @cached_property
    def _packet_table(self) -> _PacketTable:
        times_ns: list[int] = []
        relayable, last_ns, stepped_back = not self._other_form, None, False
        complete = intra = True
        with opened(self.path) as (container, stream):
            annex_b = annex_b_filter(stream) if relayable else None
            relayable = annex_b is not None
            for packet in Decoding(container, stream).packets():
                time_ns = None if packet.pts is None else to_ns(packet.pts, stream)
                complete &= time_ns is not None or packet.is_discard
                intra &= packet.is_keyframe and packet.pts == packet.dts
                if time_ns is not None and not packet.is_discard:
                    times_ns.append(time_ns)
                rises = time_ns is not None and (last_ns is None or time_ns > last_ns)
                if relayable and annex_b is not None:
                    startable = packet.is_keyframe or last_ns is not None
                    relayable = rises and startable and is_plain_picture(annex_b, packet)
                if time_ns is not None and last_ns is not None:
                    stepped_back |= time_ns < last_ns - REORDERING_NS
                last_ns = time_ns
        # In AVI, times are certain only if no picture can be out of order.
        seekable = bool(times_ns) and not stepped_back and (relayable or intra or not self._avi)
        table_ns = np.sort(np.array(times_ns, np.int64))
        complete &= bool(np.all(np.diff(table_ns) > 0))
        return _PacketTable(table_ns, relayable, seekable, complete)


def _other_videos(container: InputContainer, used: VideoStream) -> Iterator[str]:
    """The sizes of the other videos in a file, if it states them. Still pictures do not count."""
    for stream in moving_pictures(container):
        if stream.index != used.index:
            codec = stream.codec_context
            yield "one" if codec is None else f"{codec.width}x{codec.height}"


def _stated_end(container: InputContainer, stream: VideoStream, period_ns: int) -> _StatedEnd | None:
    """The stated end of the pictures or, if the file states none for them, of all that is in it."""
    own_ns = _clock_ns(stream.metadata.get("DURATION"))
    if own_ns is not None:
        shortfall_ns = max(round(PICTURES_SHORTFALL_S * NS_PER_S), PICTURES_SHORTFALL_PERIODS * period_ns)
        return _StatedEnd(own_ns, shortfall_ns)
    shortfall_ns = round(SHORTFALL_S * NS_PER_S)
    if stream.duration is not None:
        return _StatedEnd(to_ns(stream.duration + (stream.start_time or 0), stream), shortfall_ns)
    if container.duration is None:
        return None
    microseconds = container.duration + (container.start_time or 0)
    return _StatedEnd(microseconds * 1000, shortfall_ns)


def _clock_ns(text: str | None) -> int | None:
    """The time in a tag of a Matroska file, such as 00:00:03.033000000; None if there is none."""
    parts = re.fullmatch(r"(\d{1,4}):(\d\d):(\d\d)\.(\d{9})", text or "", re.ASCII)
    if parts is None:
        return None
    hours, minutes, seconds, nanoseconds = map(int, parts.groups())
    return ((hours * 60 + minutes) * 60 + seconds) * NS_PER_S + nanoseconds


def _pictures(count: int) -> str:
    return "1 picture" if count == 1 else f"{count} pictures"


def _seconds(time_ns: int | None) -> str:
    return "the start" if time_ns is None else f"{time_ns / NS_PER_S:.3f} s"


def _created_ns(text: str | None) -> int | None:
    """When a container was created; None if it states nothing, or its clock was never set."""
    try:
        created = datetime.fromisoformat(text or "")
    except ValueError:
        return None
    created = created if created.tzinfo else created.replace(tzinfo=UTC)
    return None if created.year < FIRST_YEAR else round(created.timestamp()) * NS_PER_S
