"""A simulated drive as files: the video, its calibration, the own speed, and the truth as CSV and MCAP."""

import csv
import io
import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
from fcw.camera.file import write_calibration
from fcw.camera.prior_sigmas import PRINCIPAL_ROW_SIGMA_HEIGHTS, USUAL_FIELD_OF_VIEW_SIGMA_DEG
from fcw.camera.solve import calibrate
from fcw.errors import UserError
from fcw.files import is_same_file, whole_file, write_whole
from fcw.frame import Frame
from fcw.logs.names import TRUTH_LOG_NAME
from fcw.simulation.picture.renderer import Renderer
from fcw.simulation.truth.file import read_truth, write_truth
from fcw.simulation.truth.log import write_truth_log
from fcw.simulation.truth.truth import FrameTruth, frame_truth
from fcw.simulation.world.scenario import FRAMES_PER_SECOND, IMAGE_SIZE, Scenario
from fcw.simulation.world.world import World

VIDEO_NAME = "drive.mp4"
CALIBRATION_NAME = "drive.calibration.yaml"
SPEED_NAME = "drive.speed.csv"
TRUTH_NAME = "truth.csv"
NAMES = (VIDEO_NAME, CALIBRATION_NAME, SPEED_NAME, TRUTH_NAME, TRUTH_LOG_NAME)
VIDEO_OPTIONS = {"preset": "medium", "crf": "28", "bf": "0", "g": str(FRAMES_PER_SECOND), "threads": "1"}
"""No B frames and a keyframe a second, so that a log can relay the packets; one thread, so that the same
pictures always give the same file. The quality is that of a dash camera, a good 1 Mbit/s."""
MARK_ROW_SIGMA_PX = 0.5
"""The marks are known exactly; the file says what a careful click on one is worth."""


def true_calibration(scenario: Scenario) -> Calibration:
    """The camera of a scenario, calibrated by the marks on its road as if clicked without any error.

    The lens is believed no better than any other, but in the right place. The pitch is believed as any dash
    camera's is, which moves it by up to 0.04 degrees from the true one.
    """
    camera = scenario.camera.camera()
    offset_m = scenario.camera.reference_offset_m
    points = tuple(
        GroundPoint(d, camera.row_at(d + offset_m), camera.principal_column_px) for d in scenario.road.marks_m
    )
    axis = Gaussian(camera.principal_row_px, PRINCIPAL_ROW_SIGMA_HEIGHTS * IMAGE_SIZE.height)
    width_rad = 2 * math.atan(IMAGE_SIZE.width / 2 / camera.focal_y_px)
    lens = Gaussian(width_rad, math.radians(USUAL_FIELD_OF_VIEW_SIGMA_DEG))
    return calibrate(
        points,
        IMAGE_SIZE,
        camera.height_m,
        offset_m,
        MARK_ROW_SIGMA_PX,
        lens,
        axis,
        tape_error=0.0,
    )


def render_drive(scenario: Scenario, seed: int = 0) -> Iterator[tuple[Frame, FrameTruth]]:
    """The frames of a drive, each with its truth; the same for the same seed, bit for bit."""
    camera = scenario.camera.camera()
    renderer = Renderer(camera, IMAGE_SIZE, seed, scenario.on_glass)
    for index, state in enumerate(World(scenario, seed).states()):
        truth = frame_truth(state, camera, IMAGE_SIZE, scenario.camera.reference_offset_m)
        yield Frame(index, state.time_ns, renderer.render(state)), truth


def write_drive(
    scenario: Scenario,
    directory: Path,
    seed: int = 0,
    on_frame: Callable[[], None] | None = None,
    read: Path | None = None,
) -> None:
    """Render a drive and write all its files, each whole or not at all.

    Args:
        scenario: what happens.
        directory: where the files go; made where it is not there. An earlier simulated drive is replaced.
        seed: of everything that varies.
        on_frame: called after every frame.
        read: the file that the scenario is from.

    Raises:
        UserError: the folder cannot be made or written, or a file in it is no simulated drive's.
    """
    video = directory / VIDEO_NAME
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"{directory}: cannot write there ({error.strerror}); name a folder that can be written"
        ) from error
    _check_names(directory, read)
    with whole_file(video) as partial:
        truth = _write_video(partial, render_drive(scenario, seed), on_frame)
        write_truth(directory / TRUTH_NAME, truth)  # before the others: by it they are known again
    calibration = true_calibration(scenario)
    write_calibration(calibration, directory / CALIBRATION_NAME)
    _write_speed(directory / SPEED_NAME, truth)
    write_truth_log(directory / TRUTH_LOG_NAME, video, calibration, truth)


def _check_names(directory: Path, read: Path | None) -> None:
    """See that what stands under the files' names may be replaced: it lies beside the truth of a drive."""
    standing = [path for path in (directory / name for name in NAMES) if path.exists()]
    for path in standing:
        if read is not None and is_same_file(path, read):
            raise UserError(f"{path}: this is the scenario, and would be overwritten; name another folder")
    try:
        if standing:
            read_truth(directory / TRUTH_NAME)
    except UserError:
        raise UserError(
            f"{standing[0]}: would be replaced, and is of no drive that `fcw simulate` wrote (there is no "
            f"{TRUTH_NAME} of one beside it); name another folder"
        ) from None


def _write_video(
    path: Path, frames: Iterator[tuple[Frame, FrameTruth]], on_frame: Callable[[], None] | None
) -> list[FrameTruth]:
    truths = []
    with av.open(f"file:{path}", "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=FRAMES_PER_SECOND, options=VIDEO_OPTIONS)
        stream.width, stream.height, stream.pix_fmt = IMAGE_SIZE.width, IMAGE_SIZE.height, "yuv420p"
        stream.time_base = Fraction(1, FRAMES_PER_SECOND)
        for frame, truth in frames:
            planes = np.asarray(cv2.cvtColor(frame.image, cv2.COLOR_BGR2YUV_I420), np.uint8)
            picture = av.VideoFrame.from_ndarray(planes, format="yuv420p")
            picture.pts = frame.index
            container.mux(stream.encode(picture))
            truths.append(truth)
            if on_frame is not None:
                on_frame()
        container.mux(stream.encode(None))
    return truths


def _write_speed(path: Path, frames: Sequence[FrameTruth]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("time_s", "speed_mps"))
    writer.writerows((f"{frame.time_ns / 1e9:.6f}", f"{frame.ego_speed_mps:.4f}") for frame in frames)
    write_whole(path, text.getvalue())
