"""Black bars around a picture are cut off, and nothing else is."""

from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from video_making import write_short_drive

import fcw
from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
from fcw.camera.file import read_calibration
from fcw.camera.lens.model import Lens
from fcw.camera.lens.pixel_map import PixelMap
from fcw.camera.solve import calibrate
from fcw.frame import Frame, ImageSize
from fcw.job import prepare_drive
from fcw.sources import open_source
from fcw.sources.bars import without_bars

INNER = ImageSize(160, 120)
RNG = np.random.default_rng(0)
CALIBRATION = calibrate(
    [GroundPoint(5.0, 600.0, 700.0), GroundPoint(10.0, 480.0), GroundPoint(20.0, 424.0, 610.0)],
    ImageSize(1280, 720),
    1.3,
    field_of_view=Gaussian(1.1, 0.05),
    principal_row=Gaussian(360.0, 20.0),
    horizon_row=Gaussian(370.0, 4.0),
)


def picture(low: int = 20, high: int = 230) -> np.ndarray:
    return RNG.integers(low, high, (INNER.height, INNER.width, 3), dtype=np.uint8)


def padded(image: np.ndarray, left: int = 0, right: int = 0, top: int = 0, bottom: int = 0) -> np.ndarray:
    return np.pad(image, ((top, bottom), (left, right), (0, 0)))


class Pictures:
    """A source of a picture a second."""

    name, frame_rate_hz, relays_video, notes = "pictures", 1.0, True, ()

    def __init__(self, *images: np.ndarray, count: int | None = 0) -> None:
        self.images, self.frame_count = images, len(images) if count == 0 else count
        self.image_size = ImageSize(images[0].shape[1], images[0].shape[0])

    def frames(self, start_ns: int | None = None):
        for index, image in enumerate(self.images):
            if index * 10**9 >= (start_ns or 0):
                yield Frame(index, index * 10**9, image)


@pytest.mark.parametrize(
    ("bars", "words"),
    [
        ({"left": 60, "right": 60}, "beside the picture"),
        ({"top": 20, "bottom": 20}, "above and below the picture"),
        ({"left": 30, "right": 32, "top": 8, "bottom": 8}, "beside and above and below the picture"),
    ],
)
def test_what_is_left_is_the_picture_itself(bars, words):
    images = [picture() for _ in range(4)]
    source, part = without_bars(Pictures(*(padded(image, **bars) for image in images)))
    assert part is not None
    assert (source.image_size, part.left_px, part.top_px) == (INNER, bars.get("left", 0), bars.get("top", 0))
    assert all((frame.image == image).all() for frame, image in zip(source.frames(), images, strict=True))
    assert not source.relays_video
    assert words in source.notes[-1]
    assert f"leaves 160x120 of {padded(images[0], **bars).shape[1]}x" in source.notes[-1]


@pytest.mark.parametrize(
    "images",
    [
        [picture()],
        [padded(picture(), left=60)],  # a dark building
        [padded(picture(), top=20, bottom=40)],  # a black sky, and a black bonnet
        [padded(picture(), left=1, right=1)],  # an encoder's margin
        [padded(picture(), left=60, right=60) + RNG.integers(0, 20, (120, 280, 3), dtype=np.uint8)],
        [padded(picture(), left=40, right=40), padded(picture())[:, :1].repeat(240, axis=1)],
        [np.zeros((120, 280, 3), np.uint8)],
    ],
    ids=["none", "one side", "uneven", "margin", "noise", "not always", "nothing seen"],
)
def test_all_else_is_left_as_it_is(images):
    source = Pictures(*images)
    assert without_bars(source) == (source, None)


def test_a_drive_that_fades_in_is_looked_at_later():
    black = np.zeros((120, 280, 3), np.uint8)
    shown = padded(picture(), left=60, right=60)
    _, part = without_bars(Pictures(black, *(shown for _ in range(11))))
    assert part == PixelMap(INNER, left_px=60)


def test_a_camera_is_not_read_before_its_time():
    source = Pictures(padded(picture(), left=60, right=60), count=None)
    assert without_bars(source) == (source, None)


def test_sizes_stay_even_as_video_is_encoded():
    _, part = without_bars(Pictures(padded(picture()[:, :-1], left=60, right=61)))
    assert part is not None
    assert part.size == ImageSize(158, 120)


@given(st.integers(0, 300), st.integers(0, 200), st.sampled_from([1.0, 4.0, 30.0]))
def test_the_road_of_a_part_is_as_far_away(left_px, top_px, distance_m):
    part = PixelMap(ImageSize(900, 500), left_px=left_px, top_px=top_px)
    inner = CALIBRATION.through(part)
    assert inner.row_at(distance_m) == pytest.approx(CALIBRATION.row_at(distance_m) - top_px)
    assert inner.column_at(1.5, distance_m) == pytest.approx(CALIBRATION.column_at(1.5, distance_m) - left_px)
    row_px = CALIBRATION.row_at(distance_m)
    assert inner.distance_interval(row_px - top_px, 1.0) == pytest.approx(
        CALIBRATION.distance_interval(row_px, 1.0)
    )


def test_there_and_back_is_the_same_calibration():
    lens = Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (-0.25, 0.06, 0.001, -0.001), CALIBRATION.image_size)
    part = PixelMap(ImageSize(400, 600), left_px=440, top_px=60)
    for whole in (CALIBRATION, replace(CALIBRATION, lens=lens).with_residuals()):
        back = whole.through(part).through(part.back(whole.image_size))
        assert back.camera == whole.camera
        assert (back.points, back.lens, back.image_size) == (whole.points, whole.lens, whole.image_size)
        assert back.priors.field_of_view_rad is not None
        assert whole.priors.field_of_view_rad is not None
        assert back.priors.field_of_view_rad.value == pytest.approx(whole.priors.field_of_view_rad.value)
        assert back.priors.field_of_view_rad.sigma == pytest.approx(whole.priors.field_of_view_rad.sigma)


def test_half_of_the_picture_has_half_the_tangent_of_the_view():
    half = CALIBRATION.through(PixelMap(ImageSize(640, 720), left_px=320))
    assert np.tan(half.field_of_view_rad / 2) == pytest.approx(np.tan(CALIBRATION.field_of_view_rad / 2) / 2)
    prior = half.priors.field_of_view_rad
    assert prior is not None
    assert np.tan(prior.value / 2) == pytest.approx(np.tan(1.1 / 2) / 2)


def drive_in_bars(path: Path, drive: Path, bars: int) -> Path:
    """A drive put into a wider picture."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = 640 + 2 * bars, 360, "yuv420p"
        stream.options = {"preset": "ultrafast", "qp": "4"}
        for frame in open_source(drive).frames():
            image = padded(frame.image, left=bars, right=bars)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="bgr24")))
        container.mux(stream.encode())
    return path


def outcome(drive: Path, calibration: Calibration, out: Path) -> list[fcw.FrameResult]:
    fcw.run_drive(fcw.DriveJob(source=drive, out=out, calibration=calibration))
    return list(fcw.read_drive(out).results())


@pytest.mark.slow
def test_a_drive_in_bars_has_the_lead_of_the_drive_without(tmp_path):
    drive = write_short_drive(tmp_path / "drive.mp4")
    calibration = read_calibration(tmp_path / "drive.calibration.yaml").for_image_size(ImageSize(640, 360))
    in_bars = drive_in_bars(tmp_path / "bars.mp4", drive, 160)
    whole = PixelMap(ImageSize(960, 360), left_px=-160)
    there = outcome(drive, calibration, tmp_path / "plain")
    here = outcome(in_bars, calibration.through(whole), tmp_path / "in bars")
    leads = [(result.lead, other.lead) for result, other in zip(there, here, strict=True)]
    distances_m = np.array([(lead.distance_m, other.distance_m) for lead, other in leads if lead and other])
    assert len(distances_m) > 30
    assert sum((lead is None) != (other is None) for lead, other in leads) <= 2
    assert distances_m[:, 1] == pytest.approx(distances_m[:, 0], rel=0.03)
    assert fcw.read_drive(tmp_path / "in bars").header.image_size == ImageSize(640, 360)
    prepared = prepare_drive(fcw.DriveJob(source=in_bars, out=tmp_path, calibration=calibration))
    assert prepared.header.calibration.camera == calibration.camera  # that of the log fits the clip, too
