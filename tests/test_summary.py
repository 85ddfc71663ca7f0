"""The summary turns a sequence of warning states into spans of time."""

import json
from dataclasses import replace

import pytest

from fcw.box import Box
from fcw.logs.records import CUT, NOTHING_SEEN, FrameResult
from fcw.motion.state import OwnMotion, SpeedSource
from fcw.summary import DriveSummary
from fcw.tracking.types import SeenBy, Track
from fcw.warning.ego_speed import EgoSpeed
from fcw.warning.types import WarningLevel, WarningState

START_NS = 7_000_000_000  # spans are told from the first frame, wherever the source's clock starts


def track(track_id: int, distance_m: float) -> Track:
    return Track(
        track_id=track_id,
        box=Box(0, 0, 10, 10),
        score=1.0,
        distance_m=distance_m,
        distance_low_m=distance_m,
        distance_high_m=distance_m,
        lateral_m=0.0,
        closing_speed_mps=5.0,
        closing_speed_sigma_mps=1.0,
        ttc_s=distance_m / 5.0,
        age_s=1.0,
        seen_by=SeenBy.DETECTOR,
        in_path=True,
    )


def result(index: int, level: WarningLevel, track_id: int | None, distance_m: float = 20.0) -> FrameResult:
    tracks = () if track_id is None else (track(track_id, distance_m),)
    state = WarningState(level, track_id if level else None, "ttc" if level else "", distance_m / 5.0)
    return FrameResult(index, START_NS + index * 100_000_000, (), tracks, track_id, state, None)


def summed(*results: FrameResult) -> DriveSummary:
    summary = DriveSummary("drive.mp4", {"fcw": "1"})
    for each in results:
        summary.add(each)
    return summary


def test_a_level_held_by_one_vehicle_is_one_span_with_its_smallest_values() -> None:
    summary = summed(
        result(0, WarningLevel.NONE, None),
        result(1, WarningLevel.CAUTION, 4, 20.0),
        result(2, WarningLevel.CAUTION, 4, 10.0),
        result(3, WarningLevel.CAUTION, 4, 15.0),
        result(4, WarningLevel.NONE, 4),
    )
    (span,) = summary.warnings
    assert (span.level, span.start_s, span.end_s, span.track_id) == ("caution", 0.1, 0.3, 4)
    assert (span.min_ttc_s, span.min_distance_m) == (2.0, 10.0)


def test_caution_that_becomes_warning_is_one_span_another_vehicle_and_a_pause_each_begin_a_new_one() -> None:
    summary = summed(
        result(0, WarningLevel.CAUTION, 1),
        result(1, WarningLevel.WARNING, 1),
        result(2, WarningLevel.WARNING, 2),
        result(3, WarningLevel.NONE, 2),
        result(4, WarningLevel.WARNING, 2),
    )
    assert [(span.level, span.track_id, span.start_s) for span in summary.warnings] == [
        ("warning", 1, 0.0),
        ("warning", 2, 0.2),
        ("warning", 2, 0.4),
    ]


def test_a_note_is_told_once_for_as_long_as_it_stands_as_it_is_in_the_end_and_again_when_it_comes_back() -> (
    None
):
    noted = [
        replace(result(index, WarningLevel.NONE, None), notes=notes)
        for index, notes in enumerate([(), ("moved 0.3",), ("moved 0.4",), (), ("moved 0.3",)])
    ]
    assert summed(*noted).notes == ("from 0 s: moved 0.4", "from 0 s: moved 0.3")


def test_time_without_pictures_is_told_as_what_nobody_could_be_warned_of() -> None:
    quiet = [result(index, WarningLevel.NONE, None) for index in (0, 1, 11, 26, 27, 50)]
    summary = summed(*quiet)  # 1.0 s between two pictures are not told, 1.5 s and 2.3 s are
    assert summary.blind_s == pytest.approx(3.8)
    said = "blind for 3.8 s of 5.0 s: no picture was examined then, so no warning was possible"
    assert summary.all_notes == (said,)
    assert summary.as_json(1.0)["notes"] == [said]
    assert summed(*quiet[:3]).all_notes == ()


def blank(index: int, *notes: str) -> FrameResult:
    return replace(result(index, WarningLevel.NONE, None), notes=(*notes, NOTHING_SEEN))


def test_too_few_pictures_a_second_are_told() -> None:
    def at_hz(rate_hz: float, count: int = 30) -> DriveSummary:
        results = (result(index, WarningLevel.NONE, None) for index in range(count))
        return summed(
            *(replace(r, time_ns=START_NS + round(i * 1e9 / rate_hz)) for i, r in enumerate(results))
        )

    for rate_hz in (5.0, 7.5, 9.0):
        (note,) = at_hz(rate_hz).all_notes
        assert f"{rate_hz:.1f} pictures a second" in note
        assert "early, late, false or missing" in note
    assert at_hz(10).all_notes == ()
    assert at_hz(5, count=8).all_notes == ()  # too short to tell
    assert ["blind" in note for note in at_hz(0.5).all_notes] == [True]  # none was looked at for seconds


def test_that_too_few_of_the_pictures_differ_is_told_of_a_drive_that_moves() -> None:
    def shown_at_30_hz(times: int, own_mps: float) -> DriveSummary:
        return summed(
            *(
                replace(
                    result(index, WarningLevel.NONE, None),
                    time_ns=START_NS + round(index * 1e9 / 30),
                    ego_speed_mps=own_mps,
                    repeated=index % times > 0,
                )
                for index in range(120)
            )
        )

    (note,) = shown_at_30_hz(4, own_mps=10.0).all_notes
    assert "7.5 pictures a second, shown as 30.0 by repeating them" in note
    assert shown_at_30_hz(2, own_mps=10.0).all_notes == ()
    assert shown_at_30_hz(4, own_mps=0.0).all_notes == ()  # where nothing moves, new pictures look the same


def test_pictures_in_which_nothing_can_be_seen_are_told_and_counted_as_blind() -> None:
    seen = [result(index, WarningLevel.NONE, None) for index in range(10, 30)]
    summary = summed(
        *(blank(index) for index in range(10)), *seen, *(blank(index) for index in range(30, 33))
    )
    assert summary.blind_s == pytest.approx(1.0 + 0.2)  # to the next picture, whatever that shows
    said = (
        "pictures are black or blank from 0.0 s to 0.9 s, from 3.0 s to 3.2 s, as with a covered lens: "
        "nothing can be seen there, so no warning was possible"
    )
    assert summary.all_notes == (said,)
    assert summary.as_json(1.0)["blind_s"] == pytest.approx(1.2)


def test_times_in_which_too_little_can_be_seen_are_told_once_each_cause_has_lasted() -> None:
    def noted(index: int, *notes: str) -> FrameResult:
        return replace(result(index, WarningLevel.NONE, None), notes=notes)

    soft, dark = (
        "soft picture, far vehicles are missed: it is blurred",
        "dark picture, many are missed: night",
    )
    times = [noted(i, *(soft,) * (i < 15 or i >= 40), *(dark,) * (20 <= i < 30)) for i in range(60)]
    summary = summed(*times)  # soft for 1.4 and 1.9 s, dark for 0.9 s
    said = f"from 0.0 s to 1.4 s, from 4.0 s to 5.9 s: {soft}"
    assert summary.all_notes == (said,)
    assert summary.as_json(1.0)["notes"] == [said]
    assert summary.blind_s == 0
    assert summed(*times[:30]).all_notes == ()


def test_one_black_picture_hides_nothing() -> None:
    faded_in = blank(0), *(result(index, WarningLevel.NONE, None) for index in (1, 2))
    at_30_hz = (replace(one, time_ns=START_NS + one.index * 33_333_333) for one in faded_in)
    assert summed(*at_30_hz).all_notes == ()


def test_of_many_cuts_the_first_ones_are_told() -> None:
    cut = [replace(result(index, WarningLevel.NONE, None), notes=(CUT,) * (index % 2)) for index in range(11)]
    (note,) = summed(*cut).all_notes
    assert note.startswith("the clip is cut at 0.1 s, at 0.3 s, at 0.5 s and 2 more times, as by editing: ")
    assert summed(*cut).blind_s == 0


def test_nobody_has_edited_what_comes_from_a_camera() -> None:
    summary = DriveSummary("camera-0", {}, recorded=False)
    for index in range(4):
        summary.add(replace(result(index, WarningLevel.NONE, None), notes=(CUT,) * (index == 2)))
    (note,) = summary.all_notes
    assert note.startswith("the picture jumps at 0.2 s, as where it is damaged")
    assert "edit" not in note
    assert "file" not in note


def test_a_note_that_stands_while_the_lens_is_covered_is_told_once() -> None:
    moved = replace(result(0, WarningLevel.NONE, None), notes=("moved",))
    summary = summed(moved, blank(1, "moved"), replace(moved, index=2, time_ns=START_NS + 200_000_000))
    first, _ = summary.all_notes
    assert first == "from 0 s: moved"


def test_of_many_times_in_which_nothing_can_be_seen_the_first_ones_are_told() -> None:
    flickering = (
        f(i) for i in range(0, 12, 2) for f in (blank, lambda i: result(i + 1, WarningLevel.NONE, None))
    )
    (said,) = summed(*flickering).all_notes
    assert "from 0.4 s to 0.4 s and 3 more times, as with a covered lens" in said


def test_json_has_the_keys_that_scripts_rely_on() -> None:
    as_json = summed(result(0, WarningLevel.WARNING, 1), result(5, WarningLevel.NONE, None)).as_json(
        elapsed_s=4.0
    )
    assert json.loads(json.dumps(as_json)) == {
        "source": "drive.mp4",
        "frames": 2,
        "duration_s": 0.5,
        "frames_per_second": 0.5,
        "frames_with_lead": 1,
        "blind_s": 0.0,
        "warnings": [
            {
                "level": "warning",
                "start_s": 0.0,
                "end_s": 0.0,
                "min_ttc_s": 4.0,
                "min_distance_m": 20.0,
                "track_id": 1,
            }
        ],
        "notes": [],
        "own_motion": {"distance_m": None, "speed_known_part": 0.0, "mount": None, "scale_ratio": None},
        "versions": {"fcw": "1"},
    }


def test_a_drive_without_frames_is_summed_up_as_nothing() -> None:
    as_json = summed().as_json(elapsed_s=0.0)
    assert (as_json["frames"], as_json["duration_s"], as_json["frames_per_second"]) == (0, 0.0, 0.0)


def moved(index: int, given_mps: float | None, by_picture_mps: float | None) -> FrameResult:
    used_mps = by_picture_mps if given_mps is None else given_mps
    source = SpeedSource.PICTURE if given_mps is None else SpeedSource.GIVEN
    return replace(
        result(index, WarningLevel.NONE, None),
        ego_speed_mps=used_mps,
        own_motion=OwnMotion(speed_mps=used_mps, speed_source=source, picture_speed_mps=by_picture_mps),
    )


def test_speed_by_the_picture_against_a_given_one_is_the_scale_of_all_distances() -> None:
    summary = summed(*(moved(k, 20.0, 18.8) for k in range(101)))
    own = summary.as_json(elapsed_s=1.0)["own_motion"]
    assert own["scale_ratio"] == pytest.approx(0.94)
    assert own["distance_m"] == pytest.approx(200.0)
    assert own["speed_known_part"] == 1.0
    assert any("6% short" in note for note in summary.all_notes)


def test_a_scale_that_is_right_is_not_talked_of() -> None:
    summary = summed(*(moved(k, 20.0, 20.4) for k in range(101)))
    assert summary.as_json(elapsed_s=1.0)["own_motion"]["scale_ratio"] == pytest.approx(1.02)
    assert summary.all_notes == ()


def test_without_a_given_speed_or_with_little_way_there_is_no_scale() -> None:
    assert (
        summed(*(moved(k, None, 20.0) for k in range(101))).as_json(1.0)["own_motion"]["scale_ratio"] is None
    )
    assert (
        summed(*(moved(k, 20.0, 19.0) for k in range(20))).as_json(1.0)["own_motion"]["scale_ratio"] is None
    )


def test_a_given_standstill_while_the_picture_drives_is_told() -> None:
    (note,) = summed(*(moved(k, 0.0, 17.0) for k in range(31))).all_notes
    assert note == (
        "the given own speed says that you stand for 3.0 s in which the picture shows that you drive: "
        "check it; if it is wrong, warnings are missing there"
    )
    assert summed(*(moved(k, 0.0, 17.0) for k in range(15))).all_notes == ()  # 1.4 s
    assert summed(*(moved(k, 0.0, 0.2) for k in range(31))).all_notes == ()
    assert summed(*(moved(k, None, 17.0) for k in range(31))).all_notes == ()


def test_gaps_of_a_given_speed_are_told_where_there_are_pictures_in_them() -> None:
    times_s = [7.0, 7.1, 7.2, 12.0, 12.1]
    given = EgoSpeed(tuple(times_s), (20.0,) * 5)
    pictures = [moved(round((time_s - 7.0) * 10), 20.0, 20.0) for time_s in times_s]
    assert summed(*pictures).notes_on(given) == ()
    (note,) = summed(*pictures[:3], moved(25, None, 20.0), *pictures[3:]).notes_on(given)
    assert note == (
        "the given own speed is not used for 4.8 s, as its samples there are more than 1.0 s apart"
    )
