"""Pictures as drives: a folder of them, or a single one."""

import re
import statistics
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.files import MalformedError, read_text
from fcw.bounded.pictures import read_picture
from fcw.errors import UserError
from fcw.frame import Frame, ImageSize
from fcw.sources.folders.listing import PICTURE_SUFFIXES, files_in
from fcw.units import NS_PER_S

TIMES_NAME = "timestamps.txt"
KITTI_FOLDER_NAME = "data"
DEFAULT_FRAME_RATE_HZ = 10.0
"""The rate of KITTI, the most used pictures of drives."""
SLOWEST_HZ, FASTEST_HZ = 0.001, 10_000.0


class ImageFolderSource:
    """Pictures of one folder in the natural order of their names (`2.png` before `10.png`), or one picture.

    Times come from `timestamps.txt` in the folder, or beside it where the folder is called `data`, as in
    KITTI raw. It has a line for each picture: seconds (`0.1034`), or a date and time
    (`2011-09-26 13:02:25.594360375`), which count from the first line. Without it, and where a frame rate is
    given, times come from the rate.

    Attributes:
        path: of the folder, or of the one picture.
        image_size: of every picture.
        frame_rate_hz: the rate given or assumed; with a file of times, from their median step.
        relays_video: False, as there are no packets.
    """

    relays_video = False

    def __init__(self, path: Path, frame_rate_hz: float | None = None) -> None:
        """List the folder, or take the picture file itself, and read the first picture.

        Raises:
            UserError: no pictures, none that can be read, or times that do not fit them.
        """
        self.path = path
        self._pictures = [path] if path.is_file() else files_in(path, PICTURE_SUFFIXES)
        if not self._pictures:
            raise UserError(
                f"{path}: no pictures in this folder; expected {', '.join(PICTURE_SUFFIXES)} files, or the "
                "videos of one drive"
            )
        if frame_rate_hz is not None and not SLOWEST_HZ <= frame_rate_hz <= FASTEST_HZ:
            raise UserError(
                f"frame rate {frame_rate_hz}: expected a number of pictures a second above 0, "
                f"from {SLOWEST_HZ:g} to {FASTEST_HZ:g}"
            )
        first = next((image for image in map(read_picture, self._pictures) if image is not None), None)
        if first is None:
            what = "this picture" if path.is_file() else f"none of its {len(self._pictures)} pictures"
            can = "cannot" if path.is_file() else "can"
            raise UserError(f"{path}: {what} {can} be read; expected whole files")
        self.image_size = ImageSize(first.shape[1], first.shape[0])
        self._opening_notes: tuple[str, ...] = ()
        self._notes: tuple[str, ...] = ()
        times_file = _times_file(path)
        if frame_rate_hz is None and times_file is not None:
            self._times_ns = _read_times(times_file, len(self._pictures))
            steps_ns = np.diff(self._times_ns)
            self.frame_rate_hz = (
                NS_PER_S / float(np.median(steps_ns)) if len(steps_ns) else DEFAULT_FRAME_RATE_HZ
            )
        else:
            self.frame_rate_hz = frame_rate_hz or DEFAULT_FRAME_RATE_HZ
            self._times_ns = [round(i * NS_PER_S / self.frame_rate_hz) for i in range(len(self._pictures))]
            self._opening_notes = tuple(_missing(self.name, self._pictures))
            if frame_rate_hz is None and len(self._pictures) > 1:
                self._opening_notes += (
                    f"{self.name}: no {TIMES_NAME}, so {DEFAULT_FRAME_RATE_HZ:g} pictures a second are "
                    "assumed; speeds and times to collision depend on that",
                )

    @property
    def name(self) -> str:
        """The folder's name, or the picture file's."""
        return self.path.resolve().name

    @property
    def frame_count(self) -> int:
        """Number of picture files."""
        return len(self._pictures)

    @property
    def times_ns(self) -> NDArray[np.int64]:
        """Times of all picture files, ascending."""
        return np.array(self._times_ns, np.int64)

    @property
    def notes(self) -> tuple[str, ...]:
        """An assumed frame rate, and after iteration the pictures that could not be read."""
        return self._opening_notes + self._notes

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """Frames from the first one at or after `start_ns`; one that cannot be read is left out and noted.

        Raises:
            UserError: a picture has another size than the first one.
        """
        self._notes = ()
        index = 0
        for file, time_ns in zip(self._pictures, self._times_ns, strict=True):
            if start_ns is not None and time_ns < start_ns:
                index += 1
                continue
            image = read_picture(file)
            if image is None:
                self._notes += (f"{file}: this picture cannot be read and is left out",)
                continue
            if image.shape[:2] != (self.image_size.height, self.image_size.width):
                raise UserError(
                    f"{file}: {image.shape[1]}x{image.shape[0]} pixels, expected {self.image_size} "
                    "as the first picture has; keep pictures of one camera in a folder"
                )
            yield Frame(index, time_ns, image)
            index += 1


def _missing(name: str, pictures: Sequence[Path]) -> Iterator[str]:
    """Says where the running numbers in the names of pictures leave some out."""
    numbers = [int(found[1]) for file in pictures if (found := re.search(r"([0-9]+)$", file.stem))]
    steps = np.diff(np.array(numbers, object)).tolist()
    if len(numbers) < len(pictures) or len(steps) < 2:
        return
    usual = statistics.median_low(steps)
    holes = [at for at, step in enumerate(steps) if step > usual]
    # Numbers with no usual step do not count pictures: they are times, say.
    if holes and usual > 0 and 2 * steps.count(usual) > len(steps):
        count = sum(steps[at] // usual - 1 for at in holes)
        pictures_missing = "1 picture is" if count == 1 else f"{count} pictures are"
        yield (
            f"{name}: {pictures_missing} missing by the numbers in the names, the first after "
            f"{pictures[holes[0]].name}; times go on as if none were missing: a {TIMES_NAME} says when each "
            "was taken"
        )


def _times_file(path: Path) -> Path | None:
    """The file with the times of a folder's pictures, where there is one."""
    if path.is_file():
        return None
    path = path.absolute()  # `.` has no name
    places = (path, path.parent) if path.name == KITTI_FOLDER_NAME else (path,)
    return next((place / TIMES_NAME for place in places if (place / TIMES_NAME).is_file()), None)


def _read_times(file: Path, count: int) -> list[int]:
    """Times in nanoseconds, ascending, one for each of `count` pictures."""
    try:
        lines = [line.strip() for line in read_text(file).splitlines() if line.strip()]
    except (OSError, MalformedError) as error:
        raise UserError(
            f"{file}: cannot read the times ({error}); expected a line for each picture"
        ) from error
    if len(lines) != count:
        raise UserError(
            f"{file}: {len(lines)} times for {count} pictures; expected one line for each picture"
        )
    times_ns: list[int] = []
    for number, line in enumerate(lines, 1):
        time_ns = _parse_time(line)
        if time_ns is None:
            raise UserError(
                f"{file}, line {number}: {line[:60]!r}; expected seconds such as 0.1034 or a time such as "
                "2011-09-26 13:02:25.594360375"
            )
        if times_ns and time_ns <= times_ns[-1]:
            raise UserError(
                f"{file}, line {number}: {line!r} is not after the time before it; expected rising times"
            )
        times_ns.append(time_ns)
    if "-" in lines[0].lstrip("-"):
        return [time_ns - times_ns[0] for time_ns in times_ns]
    return times_ns


def _parse_time(line: str) -> int | None:
    """A line of a file of times in nanoseconds, with no rounding through a float."""
    seconds = re.fullmatch(r"([0-9]{1,10})(?:\.([0-9]{1,9})[0-9]*)?", line)
    if seconds:
        time_ns = int(seconds[1]) * NS_PER_S + int((seconds[2] or "").ljust(9, "0"))
        return time_ns if time_ns < 2**63 else None
    clock = re.fullmatch(
        r"([0-9]{4}-[0-9]{2}-[0-9]{2}[ T][0-9]{2}:[0-9]{2}:[0-9]{2})(?:\.([0-9]{1,9}))?", line
    )
    if clock is None:
        return None
    try:
        whole = datetime.fromisoformat(clock[1]).replace(tzinfo=UTC)
    except ValueError:
        return None
    return int(whole.timestamp()) * NS_PER_S + int((clock[2] or "").ljust(9, "0"))
