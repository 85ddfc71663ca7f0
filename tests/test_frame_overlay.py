"""What is drawn over a frame: where its vehicle is, in words that are right, none over another."""

import math
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.logs.overlay import LEVEL_COLORS, OTHER_TRACK_COLOR, ROW_COLOR, OverlayRow, overlay_rows
from fcw.logs.records import DriveHeader, FrameResult
from fcw.motion.state import Mount, OwnMotion, OwnPath
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState
from fcw_viz.overlay import OverlayPainter, Words, paint, vehicle_facts, vehicle_words

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.03, 1000.0, 350.0, 1.4, 640.0)
HEADER = DriveHeader(
    source="drive.mp4",
    image_size=SIZE,
    frame_rate_hz=30.0,
    calibration=Calibration.from_camera(CAMERA, SIZE, reference_offset_m=1.7),
    relays_video=True,
    detector="acf",
    model_sha256="",
    versions={},
)
LEAD = Track(
    7, Box(600.25, 380.5, 80, 60), 9.5, 20.2, 19.0, 21.4, 0.25, 8.0, 0.4, 2.5, 3.0, SeenBy.DETECTOR, True
)
OTHER = Track(
    1, Box(100, 390, 50, 40), 4.0, 30.4, 28.4, 33.1, 5.0, -1.0, 0.5, None, 2.0, SeenBy.DETECTOR, False
)
NOTE = "the camera looks 1.2 degrees farther down than calibrated: distances may be wrong, check its mount"
WARNING = WarningState(WarningLevel.WARNING, 7, "ttc", 2.5, 3.2, None)


def result(*tracks: Track, warning: WarningState | None = None, notes: tuple[str, ...] = ()) -> FrameResult:
    lead_id = LEAD.track_id if LEAD in tracks else None
    warning = warning or WarningState(WarningLevel.NONE)
    return FrameResult(90, 3_000_000_000, (), tracks, lead_id, warning, 25.0, notes)


def painted(frame: FrameResult, header: DriveHeader = HEADER, background: int = 90) -> NDArray[np.uint8]:
    size = header.image_size
    image = np.full((size.height, size.width, 3), background, np.uint8)
    OverlayPainter(header).paint(image, frame)
    return image


def texts(frame: FrameResult, header: DriveHeader = HEADER) -> list[str]:
    return [words.text for words in OverlayPainter(header).overlay(frame).words]


def middle_of_line(profile: NDArray[np.float64]) -> float:
    """Where a line crosses a row or a column of pixels: the mean place of what differs from the rest."""
    strength = np.abs(profile - np.median(profile))
    return float((strength * np.arange(len(profile))).sum() / strength.sum())


@given(x=st.floats(200, 900), y=st.floats(200, 500), w=st.floats(30, 200), h=st.floats(30, 150))
def test_a_boxs_lines_are_drawn_where_its_edges_are(x: float, y: float, w: float, h: float) -> None:
    box = Box(x, y, w, h)
    image = np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
    overlay = OverlayPainter(HEADER).overlay(result(replace(LEAD, box=box)))
    (outline,) = (stroke for stroke in overlay.strokes if stroke.closed)
    paint(image, replace(overlay, strokes=(outline,), words=()))
    grey = image.astype(float).sum(axis=2)
    row, column = round(y + h / 2), round(x + w / 2)
    for edge in (x, box.right):
        start = round(edge) - 8
        assert start + middle_of_line(grey[row, start : start + 17]) == pytest.approx(edge, abs=0.3)
    for edge in (y, box.bottom):
        start = round(edge) - 8
        assert start + middle_of_line(grey[start : start + 17, column]) == pytest.approx(edge, abs=0.3)


def test_distance_rows_are_drawn_where_the_calibration_has_them() -> None:
    image, bare = painted(result()), np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
    changed = (image != bare).any(axis=2)[:, 1000]
    for row in overlay_rows(HEADER.calibration):
        assert row.row_px == pytest.approx(HEADER.calibration.row_at(row.distance_m))
        start = round(row.row_px) - 2
        strength = np.abs(image[start : start + 5, 1000].astype(float) - 90).sum(axis=1)
        assert start + (strength * np.arange(5)).sum() / strength.sum() == pytest.approx(row.row_px, abs=0.2)
        assert changed[round(row.row_px)]


def test_distance_rows_go_with_the_camera_that_looks_elsewhere() -> None:
    # A wrong row says another distance than the vehicle that stands on it: one painter, frame after frame.
    painter = OverlayPainter(HEADER)
    for turned_rad in (0.0, 0.02, -0.01, 0.0):
        mount = Mount(pitch_rad=CAMERA.pitch_rad + turned_rad)
        overlay = painter.overlay(replace(result(), own_motion=OwnMotion(mount=mount)))
        drawn = [stroke.points[0][1] for stroke in overlay.strokes if stroke.color == ROW_COLOR]
        looking = replace(CAMERA, pitch_rad=mount.pitch_rad)
        assert drawn == pytest.approx([looking.row_at(row.distance_m + 1.7) for row in told_rows(looking)])


@pytest.mark.parametrize("pitch_rad", [math.nan, math.inf, 1e308, -2.0, 1.5, -1.5])
def test_a_pitch_that_is_no_cameras_changes_nothing_and_a_steep_one_breaks_nothing(pitch_rad: float) -> None:
    moved = replace(result(LEAD), own_motion=OwnMotion(mount=Mount(pitch_rad=pitch_rad)))
    strokes = OverlayPainter(HEADER).overlay(moved).strokes
    if not abs(pitch_rad) < math.pi / 2:
        assert strokes == OverlayPainter(HEADER).overlay(result(LEAD)).strokes


def told_rows(camera: GroundPlaneCamera) -> tuple[OverlayRow, ...]:
    return overlay_rows(Calibration.from_camera(camera, SIZE, reference_offset_m=1.7))


@pytest.mark.parametrize("size", [ImageSize(320, 180), ImageSize(640, 360), SIZE])
@given(pitch_rad=st.floats(0.0, 0.2), focal_part=st.floats(0.4, 1.5), height_m=st.floats(0.8, 3.0))
def test_no_rows_distance_is_over_anothers(
    size: ImageSize, pitch_rad: float, focal_part: float, height_m: float
) -> None:
    camera = GroundPlaneCamera(pitch_rad, focal_part * size.width, size.height / 2, height_m, size.width / 2)
    header = replace(HEADER, image_size=size, calibration=Calibration.from_camera(camera, size))
    rows = overlay_rows(header.calibration)
    labels = {row.label for row in rows}
    words = [one for one in OverlayPainter(header).overlay(result()).words if one.text in labels]
    assert not any(overlaps(a, b) for a, b in combinations(words, 2))
    assert [one.text for one in words[:1]] == [row.label for row in rows[:1]]
    apart = all(a.row_px - b.row_px > words[0].ground.h for a, b in pairwise(rows))
    assert len(words) == len(rows) or not apart


def test_words_say_number_distance_interval_and_time_to_collision() -> None:
    assert vehicle_words(LEAD) == "#7 20 m (19-21) TTC 2.5 s"
    assert vehicle_words(replace(LEAD, distance_m=12.34, distance_low_m=11.96, distance_high_m=12.8)) == (
        "#7 12.3 m (12.0-12.8) TTC 2.5 s"
    )
    assert vehicle_words(OTHER) == "#1 30 m (28-33)"
    assert vehicle_words(replace(OTHER, distance_high_m=math.inf)) == "#1 30 m (over 28)"
    assert vehicle_words(replace(OTHER, ttc_s=12.0)) == "#1 30 m (28-33)"
    assert vehicle_words(LEAD, imperial=True) == "#7 66 ft (62-70) TTC 2.5 s"


def test_the_banner_names_the_level_and_the_reason() -> None:
    frame = result(LEAD, OTHER, warning=WARNING)
    banner = OverlayPainter(HEADER).overlay(frame).words[-1]
    assert banner.text.startswith("WARNING: short time to collision; vehicle 7 at 20 m (19.0 m to 21 m)")
    assert banner.ground_color == LEVEL_COLORS[WarningLevel.WARNING]
    image = painted(frame)
    assert image[3, 1270].tolist() == list(LEVEL_COLORS[WarningLevel.WARNING])[::-1]  # across the whole width
    assert "no warning" in texts(result(LEAD, OTHER))


def test_without_a_banner_nothing_of_the_level_is_in_words() -> None:
    frame = result(LEAD, OTHER, warning=WARNING)
    bare = OverlayPainter(HEADER, banner=False).overlay(frame).words
    assert {words.text for words in bare} == {words for words in texts(frame) if "WARNING" not in words}
    assert "no warning" not in [
        words.text for words in OverlayPainter(HEADER, banner=False).overlay(result()).words
    ]


def test_the_lead_has_the_levels_colour_and_others_their_own() -> None:
    overlay = OverlayPainter(HEADER).overlay(result(LEAD, OTHER, warning=WARNING))
    lead, other = (stroke for stroke in overlay.strokes if stroke.closed)
    assert lead.color == LEVEL_COLORS[WarningLevel.WARNING]
    assert other.color == OTHER_TRACK_COLOR
    assert lead.width_px > other.width_px
    assert {stroke.color for stroke in overlay.strokes if not stroke.closed} == {ROW_COLOR}


def test_a_vehicle_that_this_frame_did_not_see_is_drawn_thin() -> None:
    overlay = OverlayPainter(HEADER).overlay(result(replace(LEAD, seen_by=SeenBy.COASTING)))
    (outline,) = (stroke for stroke in overlay.strokes if stroke.closed)
    assert outline.width_px == 1


def test_of_eight_vehicles_only_the_lead_and_its_rival_have_words_the_others_a_thin_box() -> None:
    far = [
        replace(
            OTHER, track_id=20 + i, distance_m=40.0 + i, lateral_m=3.6, box=Box(200 + 60 * i, 380, 30, 25)
        )
        for i in range(6)
    ]
    cuts_in = replace(OTHER, distance_m=15.0, lateral_m=3.0, lateral_speed_mps=-1.0)
    overlay = OverlayPainter(HEADER).overlay(result(LEAD, cuts_in, *far))
    assert {words.text.split()[0] for words in overlay.words if words.text.startswith("#")} == {"#7", "#1"}
    outlines = [stroke.width_px for stroke in overlay.strokes if stroke.closed]
    assert outlines == [3, 2, *[1] * 6]


def test_what_a_mouse_over_a_box_tells() -> None:
    assert vehicle_facts(LEAD) == "#7 20 m (19-21) TTC 2.5 s, 0.2 m left, closing at 29 km/h"
    unseen = replace(OTHER, lateral_m=-5.0, seen_by=SeenBy.COASTING)
    assert vehicle_facts(unseen) == "#1 30 m (28-33), 5.0 m right, leaving at 4 km/h, not seen"
    assert "carried, 0.2 m left" in vehicle_facts(replace(LEAD, seen_by=SeenBy.PICTURE))


def test_time_own_speed_and_notes_are_told() -> None:
    painter = OverlayPainter(HEADER, first_ns=1_000_000_000)
    said = [words.text for words in painter.overlay(result(notes=("the mount has moved",))).words]
    assert "2.00 s   own speed 90 km/h" in said
    assert "the mount has moved" in said
    assert "3.00 s" in texts(replace(result(), ego_speed_mps=None))


def test_of_a_note_one_small_line_is_over_the_picture() -> None:
    bare, noted = (OverlayPainter(HEADER).overlay(result(notes=notes)).words for notes in ((), (NOTE,)))
    (line,) = set(noted) - set(bare)
    assert line.text == "the camera looks 1.2 degrees farther down than calibrated"
    (time,) = (words for words in bare if words.text.startswith("3.00 s"))
    assert line.letter_px < time.letter_px
    assert line.ground.w < SIZE.width / 2
    assert not overlaps(line, time)


vehicles = st.lists(
    st.tuples(st.floats(-40, 1250), st.floats(250, 600), st.floats(15, 200)), min_size=1, max_size=9
)


def overlaps(a: Words, b: Words) -> bool:
    a_box, b_box = a.ground, b.ground
    return (
        a_box.x < b_box.right and b_box.x < a_box.right and a_box.y < b_box.bottom and b_box.y < a_box.bottom
    )


@given(vehicles)
def test_no_vehicles_words_are_over_anothers_and_the_lead_always_has_some(drawn) -> None:
    tracks = tuple(
        replace(OTHER, track_id=100 + i, box=Box(x, y, w, w), distance_m=5.0 + i)
        for i, (x, y, w) in enumerate(drawn)
    )
    overlay = OverlayPainter(HEADER).overlay(result(LEAD, *tracks))
    labels = [words for words in overlay.words if words.text.startswith("#")]
    assert not any(overlaps(a, b) for a, b in combinations(labels, 2))
    assert sum(words.text.startswith("#7 ") for words in labels) == 1
    for words in labels:
        assert words.ground.x >= 0
        assert words.ground.right <= SIZE.width
        assert words.ground.y >= 0
        assert words.ground.bottom <= SIZE.height


@pytest.mark.parametrize(
    ("width", "height"), [(320, 180), (640, 360), (1242, 375), (1920, 1080), (720, 1280)]
)
def test_pictures_of_any_size_have_words_that_can_be_read(width: int, height: int) -> None:
    size = ImageSize(width, height)
    header = replace(HEADER, image_size=size, calibration=Calibration.from_camera(CAMERA, size))
    track = replace(LEAD, box=Box(size.width / 2, size.height / 2, 40, 30))
    frame = replace(result(track, warning=WARNING, notes=(NOTE,)), lead_id=7)
    overlay = OverlayPainter(header).overlay(frame)
    for words in overlay.words:
        assert words.letter_px >= 7
        assert words.ground.right <= size.width + 1
    (said,) = (words.text for words in overlay.words if words.text.startswith("the camera"))
    assert "the camera looks 1.2 degrees farther down than calibrated".startswith(said.removesuffix(" ..."))
    assert "1.2 degrees" in said
    assert painted(frame, header).shape == (size.height, size.width, 3)


@given(x=st.floats(-3000, 3000), y=st.floats(-3000, 3000), w=st.floats(0, 5000), h=st.floats(0, 5000))
def test_boxes_outside_the_picture_or_larger_than_it_do_no_harm(
    x: float, y: float, w: float, h: float
) -> None:
    assert painted(result(replace(LEAD, box=Box(x, y, w, h)))).shape == (SIZE.height, SIZE.width, 3)


def test_the_own_path_is_drawn_from_near_to_far() -> None:
    path = OwnPath(offset_m=0.2, curvature_per_m=1 / 300)
    plain, drawn = (OverlayPainter(HEADER).overlay(replace(result(), own_path=each)) for each in (None, path))
    added = [stroke for stroke in drawn.strokes if stroke not in plain.strokes]
    assert len(added) == 2
    for stroke in added:
        rows = [row for _, row in stroke.points]
        assert rows == sorted(rows, reverse=True)
    left, right = added
    assert left.points[0][0] < right.points[0][0]
