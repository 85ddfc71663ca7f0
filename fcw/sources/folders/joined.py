"""The videos of one drive as one source: dash cameras begin a new file every few minutes."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.frame import Frame
from fcw.sources.video import VideoSource
from fcw.units import NS_PER_S


class JoinedSource:
    """Videos of one camera, end to end.

    Each begins one picture after the end of the one before: what a camera loses between two files, no file
    tells.

    Attributes:
        path: of the folder that holds them.
        image_size: of every picture.
        frame_rate_hz: that of the first video.
        zero_utc_ns: when the first video was created: UTC in nanoseconds since 1970; None where it does not
            say.
    """

    def __init__(self, path: Path, files: Sequence[Path]) -> None:
        """Look into each video up to its first picture; one that cannot be read is left out and noted.

        The last file of a camera that lost its power often is such a one.

        Args:
            path: of the folder.
            files: the videos in the order of the drive, at least one.

        Raises:
            UserError: no file can be read, the pictures of one have another size than those of the first, or
                the names are those of two cameras.
        """
        _check_one_camera(files)
        self.path = path
        self._videos: list[VideoSource] = []
        faults: list[UserError] = []
        for file in files:
            try:
                self._videos.append(VideoSource(file))
            except UserError as error:
                faults.append(error)
        if not self._videos:
            raise faults[0]
        self._left_out = tuple(f"left out: {error}" for error in faults)
        first = self._videos[0]
        self.image_size = size = first.image_size
        self.frame_rate_hz, self.zero_utc_ns = first.frame_rate_hz, first.zero_utc_ns
        for video in self._videos:
            if video.image_size != size:
                raise UserError(
                    f"{video.path}: {video.image_size} pixels, expected {size} as in {first.name}; "
                    "keep one drive of one camera in a folder, or run each video for itself with `fcw batch`"
                )
        self._opening_notes = [video.notes for video in self._videos]

    @property
    def name(self) -> str:
        """The folder's name."""
        return self.path.resolve().name

    @property
    def frame_count(self) -> int:
        """Number of pictures to be shown."""
        return len(self.times_ns)

    @cached_property
    def times_ns(self) -> NDArray[np.int64]:
        """Times of all frames, ascending."""
        parts = zip(self._video_times_ns, self._shifts_ns, strict=True)
        return np.concatenate([times_ns + shift_ns for times_ns, shift_ns in parts])

    @property
    def relays_video(self) -> bool:
        """Whether frames carry packets, as those of all videos do."""
        return not self.coded_anew

    @cached_property
    def coded_anew(self) -> str:
        """Why frames carry no packets; empty where they do."""
        for video in self._videos:
            if video.coded_anew:
                return video.coded_anew
            # Such packets have times within the video before.
            if video is not self._videos[0] and len(next(video.frames()).packets) > 1:
                return f"{video.name} begins with pictures that are not to be shown"
        return ""

    @property
    def notes(self) -> tuple[str, ...]:
        """That these are taken as one drive, how pictures were set right, and what could not be read."""
        names, notes = [video.name for video in self._videos], list[str]()
        if len(names) > 1:
            those = f"its {len(names)} videos, {names[0]} to {names[-1]}"
            notes.append(f"{self.name}: {those}, are taken as one drive, by their names")
        notes += (*self._left_out, *self._opening_notes[0])
        for video, known in zip(self._videos, self._opening_notes, strict=True):
            notes += video.notes[len(known) :]
        return tuple(notes)

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """Frames from the first one at or after `start_ns`; see `VideoSource.frames`."""
        first_index = 0
        relays = self.relays_video
        for video, times_ns, shift_ns in zip(
            self._videos, self._video_times_ns, self._shifts_ns, strict=True
        ):
            own_start_ns = None if start_ns is None else start_ns - shift_ns
            if own_start_ns is not None and own_start_ns > times_ns[-1]:
                first_index += len(times_ns)
                continue
            index = -1
            for frame in video.frames(own_start_ns):
                index = frame.index
                yield replace(
                    frame,
                    index=first_index + index,
                    time_ns=frame.time_ns + shift_ns,
                    packets=tuple(
                        replace(packet, time_ns=packet.time_ns + shift_ns)
                        for packet in (frame.packets if relays else ())
                    ),
                )
            first_index += index + 1

    @cached_property
    def _video_times_ns(self) -> list[NDArray[np.int64]]:
        """Times of each video's frames by its own clock."""
        found: list[NDArray[np.int64]] = []
        for video in self._videos:
            times_ns = video.times_ns
            if times_ns is None:
                raise UserError(
                    f"{video.path}: it does not state the times of all its pictures, so it cannot be joined "
                    "with others; convert it first, for instance with `ffmpeg -i IN -c:v libx264 OUT.mp4`"
                )
            found.append(times_ns)
        return found

    @cached_property
    def _shifts_ns(self) -> list[int]:
        """By how much the clock of the drive is ahead of each video's own."""
        shifts_ns = [0]
        period_ns = round(NS_PER_S / self.frame_rate_hz)
        for before_ns, times_ns in pairwise(self._video_times_ns):
            shifts_ns.append(shifts_ns[-1] + int(before_ns[-1]) + period_ns - int(times_ns[0]))
        return shifts_ns


def _check_one_camera(files: Sequence[Path]) -> None:
    """See that the names do not end as those of cameras ahead and behind do: `0001F.MP4` and `0001R.MP4`."""
    names = {file.stem.upper(): file for file in files}
    for name, ahead in names.items():
        behind = names.get(f"{name[:-1]}R")
        if name.endswith("F") and behind:
            raise UserError(
                f"{ahead.parent}: holds files of two cameras by their names, such as {ahead.name} and "
                f"{behind.name}; move those of the camera behind into a folder of their own"
            )
