"""The whole job on clips that were given another rate, as converters and recorders do, against the clips.

    FCW_DATA=DIR PYTHONPATH=benchmarks python benchmarks/motion/retimed.py

Each clip is encoded anew, as it is and in each other way, up to `LONGEST_S` of it. Of each way: median of the
own speed over that of the clip at the same time, the part of the pictures in which it is known, and of the
vehicles within `FARTHEST_M` by how much distance and closing speed differ from those of the clip.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from av.video.stream import VideoStream
from numpy.typing import NDArray
from real_drives import data_folder

from fcw.detection.training.own_data import read_calibration_table
from fcw.job import DriveJob, run_drive
from fcw.logs.records import FrameResult
from fcw.sources import open_source
from fcw.tracking.types import Track

CLIPS = ("kb_dashcam1", "kb_dashcam2", "muchlisin_driving", "solidWhiteRight", "tmo_seattlestreet2")
"""Those of 24 to 30 pictures a second that last longer than 5 s and in which vehicles are near."""
LONGEST_S, FARTHEST_M = 14.0, 60.0
Pictures = Sequence[NDArray[np.uint8]]


def every(count: int) -> Callable[[Pictures], Iterator[NDArray[np.uint8]]]:
    """Each picture that many times, and as many fewer of them."""
    return lambda pictures: (pictures[index - index % count] for index in range(len(pictures)))


def lost(one_of: int) -> Callable[[Pictures], Iterator[NDArray[np.uint8]]]:
    """The one before instead of one of so many."""
    return lambda pictures: (
        pictures[index - (index % one_of == one_of - 1)] for index in range(len(pictures))
    )


def stalled(pictures: Pictures) -> Iterator[NDArray[np.uint8]]:
    """A recorder that stalls for 15 pictures, every 60."""
    return (pictures[index - max(index % 60 - 45, 0)] for index in range(len(pictures)))


def doubled(pictures: Pictures) -> Iterator[NDArray[np.uint8]]:
    """Twice as many a second: between two of them their mean."""
    for index, picture in enumerate(pictures):
        yield picture
        after = pictures[min(index + 1, len(pictures) - 1)]
        yield ((picture.astype(np.uint16) + after + 1) // 2).astype(np.uint8)


def woven(pictures: Pictures) -> Iterator[NDArray[np.uint8]]:
    """Interlaced: half as many a second, of the even rows of one picture and the odd rows of the next."""
    for first, second in zip(pictures[::2], pictures[1::2], strict=False):
        picture = first.copy()
        picture[1::2] = second[1::2]
        yield picture


WAYS: dict[str, tuple[Callable[[Pictures], Iterator[NDArray[np.uint8]]], int | Fraction]] = {
    "as it is": (iter, 1),
    "each picture twice": (every(2), 1),
    "each picture four times": (every(4), 1),
    "one of five lost": (lost(5), 1),
    "one of ten lost": (lost(10), 1),
    "half a second in two stalled": (stalled, 1),
    "twice as many by blending": (doubled, 2),
    "interlaced": (woven, Fraction(1, 2)),
}


def main() -> None:
    """Print a line for each way and clip."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    data = data_folder()
    table = read_calibration_table(data / "calibrations.txt")
    sys.stdout.write("way, clip: own speed; known; distance off; closing speed off in m/s; warnings\n")
    for name in CLIPS:
        source = open_source(data / "clips" / f"{name}.mp4")
        pictures = [frame.image for frame in source.frames() if frame.time_ns < LONGEST_S * 1e9]
        as_it_is: list[FrameResult] = []
        for way, (change, times) in WAYS.items():
            with tempfile.TemporaryDirectory() as folder:
                video = Path(folder) / f"{name}.mp4"
                write_video(
                    video, change(pictures), times * Fraction(source.frame_rate_hz).limit_denominator(1001)
                )
                results: list[FrameResult] = []
                job = DriveJob(video, Path(folder) / "out", table[name])
                summary = run_drive(job, on_result=results.append).summary
            as_it_is = as_it_is or results
            levels = " ".join(str(warning["level"]) for warning in summary["warnings"])
            known = summary["own_motion"]["speed_known_part"]
            distance_off, closing_off_mps = differences(as_it_is, results)
            sys.stdout.write(
                f"{way}, {name}: {speed_ratio(as_it_is, results):.2f}; {100 * known:.0f} %; "
                f"{100 * distance_off:.1f} %; {closing_off_mps:.2f}; {levels or 'none'}\n"
            )
            sys.stdout.flush()


def write_video(path: Path, pictures: Iterator[NDArray[np.uint8]], rate_hz: Fraction) -> None:
    """An H.264 video of even size."""
    with av.open(path, "w") as container:
        stream = container.add_stream("libx264", rate=rate_hz, options={"crf": "23", "preset": "veryfast"})
        assert isinstance(stream, VideoStream)
        for number, picture in enumerate(pictures):
            height, width = (side - side % 2 for side in picture.shape[:2])
            if number == 0:
                stream.height, stream.width, stream.pix_fmt = height, width, "yuv420p"
            even = np.ascontiguousarray(picture[:height, :width])
            container.mux(stream.encode(av.VideoFrame.from_ndarray(even, format="bgr24")))
        container.mux(stream.encode())


def speed_ratio(of_clip: Sequence[FrameResult], others: Sequence[FrameResult]) -> float:
    """Median over the pictures of both in which both are known."""
    at = {result.time_ns: result.ego_speed_mps for result in others}
    ratios = [
        other_mps / result.ego_speed_mps
        for result in of_clip
        if (other_mps := at.get(result.time_ns)) is not None and result.ego_speed_mps
    ]
    return float(np.median(ratios)) if ratios else float("nan")


def differences(of_clip: Sequence[FrameResult], others: Sequence[FrameResult]) -> tuple[float, float]:
    """Of the same vehicles: median of the distances' as a part, and mean of the closing speeds'."""
    at, off = {result.time_ns: result for result in others}, list[tuple[float, float]]()
    for result in of_clip:
        for track in result.tracks:
            other = same(track, at[result.time_ns].tracks) if result.time_ns in at else None
            if other is not None and track.distance_m < FARTHEST_M and track.age_s > 1:
                closing_off_mps = abs(other.closing_speed_mps - track.closing_speed_mps)
                off.append((abs(other.distance_m / track.distance_m - 1), closing_off_mps))
    distances, closing_mps = np.array(off).reshape(-1, 2).T
    return float(np.median(distances)), float(closing_mps.mean())


def same(track: Track, others: Sequence[Track]) -> Track | None:
    """The track of the same place and size, if there is one."""
    alike = [
        other
        for other in others
        if abs(other.box.x + other.box.w / 2 - track.box.x - track.box.w / 2) < track.box.w / 2
        and 0.6 < other.box.w / track.box.w < 1 / 0.6
    ]
    return min(alike, key=lambda other: abs(other.box.w - track.box.w), default=None)


if __name__ == "__main__":
    main()
