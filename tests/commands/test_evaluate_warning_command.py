"""`fcw evaluate warning` as it is typed."""

import json

import pytest
from drives.kitti_drive import kitti_drive_at_a_standing_car

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.evaluation.warning.ncap import euro_ncap_scenarios, nhtsa_scenarios
from fcw.evaluation.warning.scenarios import BoxLevel, run_scenarios
from fcw.evaluation.warning.sights import SIGHTS
from fcw.evaluation.warning.threats import ThreatResult, ThreatTrial, Window
from fcw.frame import ImageSize
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader, FrameResult
from fcw.simulation.world.scenario import load_scenario
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel, WarningState
from fcw_viz.cli import main
from fcw_viz.commands.evaluate.warning import scenarios_as_json

SIZE = ImageSize(640, 360)


@pytest.fixture
def drive(tmp_path):
    """A log of three seconds that warns from 1.0 to 1.4 s and from 2.5 to 2.9 s."""
    camera = GroundPlaneCamera(0.03, 600.0, 179.5, 1.3, 319.5)
    header = DriveHeader("x.mp4", SIZE, 10.0, Calibration.from_camera(camera, SIZE), True, "acf", "", {})
    sink = McapSink(tmp_path / "drive.mcap")
    sink.open(header)
    for index in range(30):
        on = 10 <= index < 15 or index >= 25
        state = WarningState(WarningLevel.WARNING, 1, "ttc") if on else WarningState(WarningLevel.NONE)
        sink.write(FrameResult(index, 10**9 + index * 10**8, (), (), None, state, None), ())
    sink.close()
    return tmp_path


def test_events_against_a_log_as_json(drive, capsys):
    (drive / "events.csv").write_text("start_s,end_s\n0.9,1.1\n1.8,2.2\n")
    assert (
        main(["evaluate", "warning", "--events", str(drive / "events.csv"), "--log", str(drive), "--json"])
        == 0
    )
    result = json.loads(capsys.readouterr().out)
    assert (result["hits"], result["missed"], result["false_alarms"]) == (1, 1, 1)
    assert result["false_alarm_spans"][0]["start_s"] == pytest.approx(2.5)


def test_events_against_a_log_in_words(drive, capsys):
    (drive / "events.csv").write_text("start_s,end_s\n0.9,1.1\n1.8,2.2\n")
    assert main(["evaluate", "warning", "--events", str(drive / "events.csv"), "--log", str(drive)]) == 0
    out = capsys.readouterr().out
    assert "1 event warned of, 1 missed, 1 false alarm" in out
    assert "missed: warning 1.80 s to 2.20 s" in out
    assert "false alarm: warning 2.50 s to 2.90 s" in out


def test_of_many_misses_the_first_are_listed_and_the_rest_counted(drive, capsys):
    (drive / "events.csv").write_text(
        "start_s,end_s\n" + "".join(f"{100 + n},{100.5 + n}\n" for n in range(50))
    )
    assert main(["evaluate", "warning", "--events", str(drive / "events.csv"), "--log", str(drive)]) == 0
    out = capsys.readouterr().out
    assert out.count("missed: warning") == 20
    assert "missed: and 30 more; --json lists all" in out


def test_more_events_than_a_drive_has_are_refused(drive, capsys):
    (drive / "events.csv").write_text("start_s,end_s\n" + "1,2\n" * 100_001)
    assert main(["evaluate", "warning", "--events", str(drive / "events.csv"), "--log", str(drive)]) == 2
    assert "100001 events; expected those of one drive, at most 100000" in capsys.readouterr().err


def test_what_failed_is_named_for_each_kind_of_boxes(capsys, monkeypatch):
    window = Window(1.0, 2.0, 3.0)
    in_time, late = (ThreatTrial(window, warned_s, None, ()) for warned_s in (1.5, 2.5))
    silent, false = ThreatTrial(None, None, None, ()), ThreatTrial(None, 1.0, None, (1.0,))
    trials = {
        SIGHTS[0]: {"crossing": (in_time, in_time), "near-pass": (silent, false)},
        SIGHTS[1]: {"crossing": (late, late), "near-pass": (silent, silent)},
    }

    def results(scenarios, make_policy, seeds, on_trial, sight):
        return [ThreatResult(name, one.danger, trials[sight][name]) for name, one in scenarios]

    scenarios = [(name, load_scenario(name)) for name in ("crossing", "near-pass")]
    monkeypatch.setattr("fcw.evaluation.warning.variants.half_in_the_way", lambda: iter(scenarios))
    monkeypatch.setattr("fcw.evaluation.warning.sights.SIGHTS", tuple(trials))
    monkeypatch.setattr("fcw.evaluation.warning.threats.run_threats", results)
    assert main(["evaluate", "warning", "--threats", "--variants", "--seeds", "2"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["as", "usual", "2", "of", "2", "1", "of", "2", "near-pass"] in rows
    assert ["4", "px", "of", "noise", "0", "of", "2", "2", "of", "2", "crossing", "x2"] in rows
    assert ["5", "of", "8", "as", "required"] in rows


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "nothing to evaluate; give --ncap"),
        (["--events", "e.csv"], "--events needs --log: give the drive.mcap"),
        (["--ncap", "--sight", "0"], "--sight 0: expected metres"),
        (["--ncap", "--box-noise", "-1"], "--box-noise -1: expected pixels"),
        (["--ncap", "--pixels"], "--pixels needs --threats"),
        (["--threats", "--no-own-speed"], "--no-own-speed needs --ncap"),
        (["--ncap", "--no-own-motion"], "--no-own-motion needs --kitti-tracking"),
        (["--threats", "--seeds", "0"], "--seeds 0: expected a whole number"),
        (["--ncap", "--seed", "-1"], "--seed -1: expected"),
        (["--following-hours", "nan"], "--following-hours nan: expected a finite number"),
        (["--ncap", "--warning-policy", "x"], "--warning-policy x: no such policy"),
        (["--kitti-tracking", "nowhere"], "nowhere: no KITTI tracking labels there"),
        (["--events", "e.csv", "--log", "nowhere.mcap"], "nowhere.mcap: cannot read the log"),
    ],
)
def test_wrong_input_is_named_and_leaves_stdout_empty(arguments, message, capsys):
    assert main(["evaluate", "warning", *arguments, "--json"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err.replace("\n", " ")


@pytest.mark.slow
def test_scenarios_as_json_have_the_keys_that_scripts_rely_on():
    chosen = [nhtsa_scenarios()[0], next(s for s in euro_ncap_scenarios() if s.name == "CCRs 30 km/h")]
    result = scenarios_as_json(run_scenarios(chosen, make_policy, BoxLevel(), 0))
    stopped, standing = result["scenarios"]
    for entry in (stopped, standing):
        assert entry["trials"] == 7
        assert 0 <= entry["trials_passed"] <= 7
        assert entry["passed"] == (entry["trials_passed"] == 7)
        assert entry["distance_at_warning_m"] / entry["speed_mps"] == pytest.approx(
            entry["ttc_at_warning_s"], rel=0.05
        )
    assert stopped["required_ttc_s"] == 2.1
    assert standing["required_distance_m"] == pytest.approx(18.85, abs=0.05)
    assert {"false_alarms", "missed"} <= result.keys()


def test_following_and_real_drives_as_json(data_dir, capsys):
    arguments = ["--following-hours", "0.02", "--kitti-tracking", str(data_dir / "kitti-tracking"), "--json"]
    assert main(["evaluate", "warning", *arguments]) == 0
    result = json.loads(capsys.readouterr().out)
    assert sum(part["hours"] for part in result["following"]) == pytest.approx(0.02)
    assert sum(part["warnings"] for part in result["following"]) == 0
    off_course = [episode for episode in result["episodes"] if not episode["on_course"]]
    assert result["false_alarms"] == len(off_course)


def test_the_episodes_of_several_seeds_are_counted_each_and_together(tmp_path, capsys):
    folder = kitti_drive_at_a_standing_car(tmp_path, lateral_m=0.0)
    arguments = ["--kitti-tracking", str(folder), "--seed", "3", "--seeds", "2"]
    assert main(["evaluate", "warning", *arguments, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["seeds"] == [
        {"seed": 3, "episodes": 1, "on_course": 1},
        {"seed": 4, "episodes": 1, "on_course": 1},
    ]
    assert [episode["seed"] for episode in result["episodes"]] == [3, 4]
    assert (result["on_course"], result["false_alarms"]) == (2, 0)
    # Two episodes in twice 5.6 s.
    assert result["warnings_per_hour"] == pytest.approx(3600 / 5.6)
    assert main(["evaluate", "warning", *arguments]) == 0
    assert "2 episodes of `warning` in 0.2 minutes" in capsys.readouterr().out


def test_without_a_number_of_seeds_drives_run_once(tmp_path, capsys):
    folder = kitti_drive_at_a_standing_car(tmp_path, lateral_m=0.0)
    assert main(["evaluate", "warning", "--kitti-tracking", str(folder), "--json"]) == 0
    assert [run["seed"] for run in json.loads(capsys.readouterr().out)["seeds"]] == [0]
