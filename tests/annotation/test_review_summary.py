"""What the reviews of a folder of drives come to."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
from annotation_helpers import frame_result, write_log

from fcw.annotation.records import Judgement, MissedEvent, Reason, Verdict
from fcw.annotation.review import reference_to
from fcw.annotation.store import ReviewStore
from fcw.annotation.summary import DriveReview, ReviewSummary, Tally, summarise
from fcw.errors import UserError
from fcw.logs.events import find_events
from fcw.warning.types import WarningLevel
from fcw_viz.cli import main
from fcw_viz.commands.review.summary import summary_tables

WARNING, CAUTION, ADVISORY = WarningLevel.WARNING, WarningLevel.CAUTION, WarningLevel.ADVISORY


def write_drive(path, starts, frames=181):
    """18 s in which a warning of 0.5 s begins at some tenths, one of caution at 15 s."""
    levels = [WarningLevel.NONE] * frames
    for start in starts:
        levels[start : start + 5] = [WARNING] * 5
    levels[150:155] = [CAUTION] * 5
    return write_log(path, [frame_result(i, level) for i, level in enumerate(levels)])


@pytest.fixture(scope="module")
def drives(tmp_path_factory):
    """Two drives: Ann judged four warnings of the first, Bo two of them and one of the second."""
    folder = tmp_path_factory.mktemp("drives")
    first = write_drive(folder / "first/drive.mcap", (10, 30, 50, 70, 90))
    second = write_drive(folder / "second/drive.mcap", (20,))
    store = ReviewStore(first)
    events = find_events(first.series())
    for person, number, judgement, reason in (
        ("Ann", 0, Judgement.RIGHT, None),
        ("Ann", 1, Judgement.FALSE, Reason.ONCOMING),
        ("Ann", 2, Judgement.FALSE, None),
        ("Ann", 3, Judgement.TOO_LATE, Reason.CUT_IN),
        ("Bo", 0, Judgement.FALSE, Reason.PARKED),
        ("Bo", 1, Judgement.FALSE, None),
        ("Bo", 5, Judgement.FALSE, Reason.OTHER),
    ):
        store.add(person, Verdict(reference_to(events[number]), judgement, reason))
    store.add("Ann", MissedEvent(12.0, 12.5, "cut in"))
    store.close()
    store = ReviewStore(second)
    store.add("Bo", Verdict(reference_to(find_events(second.series())[0]), Judgement.FALSE, Reason.ONCOMING))
    store.close()
    return {"first": first.path, "second": second.path}


def test_a_drives_warnings_per_hour_and_share_judged_false(drives):
    first = summarise(drives).drives[0]
    tally = first.tallies[WARNING]
    assert (first.name, first.people, first.troubles) == ("first", ("Ann", "Bo"), ())
    assert tally.hours == pytest.approx(18 / 3600)
    assert tally.warnings == 5
    assert tally.per_hour == pytest.approx(5 * 200)
    # They judge the first one differently, nobody judged the last one.
    assert (tally.disagreements, tally.judged, tally.judged_false, tally.missed) == (1, 3, 2, 1)
    assert tally.share_false == pytest.approx(2 / 3)
    assert tally.reasons == {
        (Judgement.FALSE, Reason.ONCOMING): 1,
        (Judgement.FALSE, None): 1,
        (Judgement.TOO_LATE, Reason.CUT_IN): 1,
    }
    caution = first.tallies[CAUTION]
    assert (caution.warnings, caution.judged_false, caution.missed) == (1, 1, 0)
    advisory = first.tallies[ADVISORY]
    assert (advisory.warnings, advisory.share_false, advisory.share_false_interval) == (0, None, None)


def test_a_time_without_pictures_is_no_hour_driven(tmp_path):
    results = [frame_result(i, WARNING if i < 5 else WarningLevel.NONE) for i in range(81)]
    late_ns = 40 * 24 * 3600 * 10**9
    late = [replace(one, time_ns=one.time_ns + late_ns) for one in results[41:]]
    log = write_log(tmp_path / "drive.mcap", [*results[:41], *late])
    tally = summarise({"drive": log.path}).all[WARNING]
    assert tally.warnings == 1
    assert tally.hours == pytest.approx(7.9 / 3600)


def test_all_drives_together_are_their_sum(drives):
    tally = summarise(drives).all[WARNING]
    assert tally.hours == pytest.approx(36 / 3600)
    assert (tally.warnings, tally.judged, tally.judged_false) == (6, 4, 3)
    assert (tally.disagreements, tally.missed) == (1, 1)
    assert tally.per_hour == pytest.approx(600)
    assert tally.reasons[Judgement.FALSE, Reason.ONCOMING] == 2


def test_the_shares_interval_is_wilsons(drives):
    found = summarise(drives).all[WARNING].share_false_interval
    n, p, z = 4, 3 / 4, 1.959963984540054
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    assert found == pytest.approx((middle - half, middle + half))


def test_a_drive_that_cannot_be_read_is_left_out_and_told(drives, tmp_path):
    (tmp_path / "drive.mcap").write_bytes(b"not a log")
    told = []
    summary = summarise({**drives, "broken": tmp_path / "drive.mcap"}, lambda: told.append(1))
    assert [drive.name for drive in summary.drives] == ["first", "second"]
    assert len(told) == 3
    (reason,) = summary.left_out
    assert str(tmp_path / "drive.mcap") in reason
    with pytest.raises(UserError, match="not a drive log"):
        summarise({"broken": tmp_path / "drive.mcap"})


def test_a_drive_of_one_frame_has_no_rate(tmp_path):
    log = write_log(tmp_path / "drive.mcap", [frame_result(0, WARNING)])
    tally = summarise({"drive": log.path}).all[WARNING]
    assert (tally.warnings, tally.per_hour) == (1, None)


# As it is typed


def test_as_json_it_says_the_same_for_each_drive_and_all(drives, capsys):
    assert main(["review", str(drives["first"].parents[1]), "--summary", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    first, second = result["drives"]
    assert (first["drive"], first["people"], second["drive"]) == ("first", ["Ann", "Bo"], "second")
    warning = first["warning"]
    assert warning["per_hour"] == pytest.approx(1000)
    assert warning["judgements"] == {"right": 0, "too_early": 0, "too_late": 1, "false": 2}
    assert (warning["disagreements"], warning["unjudged"], warning["missed"]) == (1, 1, 1)
    assert warning["share_false"] == pytest.approx(2 / 3)
    assert warning["share_false_low"] < 2 / 3 < warning["share_false_high"]
    reasons = {(r["judgement"], r["reason"]): r["warnings"] for r in warning["reasons"]}
    assert reasons == {("false", "oncoming"): 1, ("false", None): 1, ("too_late", "cut_in"): 1}
    assert first["caution"]["judgements"]["false"] == 1
    assert result["all"]["warning"]["warnings"] == 6
    assert result["all"]["advisory"]["share_false"] is None


def test_in_words_it_is_by_drive_and_by_reason(drives, capsys):
    assert main(["review", str(drives["first"].parents[1]), "--summary"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["first", "warning", "18", "s", "5", "-", "1", "67%", "of", "3", "(21-94%)"] in lines
    assert ["second", "warning", "18", "s", "1", "-", "0", "100%", "of", "1", "(21-100%)"] in lines
    assert ["first", "warning", "0", "0", "1", "2", "1", "1"] in lines
    assert ["warning", "false", "oncoming", "vehicle", "2", "50%"] in lines
    assert ["warning", "false", "no", "reason", "given", "1", "25%"] in lines


def test_where_nobody_judged_only_the_rates_are_told(tmp_path, capsys):
    write_drive(tmp_path / "drive.mcap", (10,))
    assert main(["review", str(tmp_path), "--summary"]) == 0
    out = capsys.readouterr().out
    assert "18 s" in out
    assert "disagreed" not in out
    assert "reason" not in out


@pytest.mark.parametrize(
    ("hours", "told"), [(6 / 3600, "6 s -"), (4.9 / 60, "5 min -"), (0.1, "6 min 20.0"), (2.0, "2.0 h 1.0")]
)
def test_time_is_told_in_a_fitting_unit_and_a_rate_from_five_minutes_on(hours, told):
    tally = Tally(hours, 2, {}, 0, 0, {})
    tallies: dict[WarningLevel, Tally] = dict.fromkeys(WarningLevel, tally)
    drive = DriveReview("drive", Path("drive.mcap"), tallies, (), 0, ())
    rates = next(summary_tables(ReviewSummary((drive,), tallies, ())))
    driven, shown, rate = (next(iter(rates.columns[at].cells)) for at in (2, 3, 4))
    assert (f"{driven} {rate}", shown) == (told, "2")


def test_json_without_the_summary_and_a_folder_without_drives_are_told(tmp_path, capsys):
    assert main(["review", str(tmp_path), "--json"]) == 2
    assert "--json needs --summary; add it, or leave out --json" in capsys.readouterr().err
    assert main(["review", str(tmp_path), "--summary", "--json"]) == 2
    captured = capsys.readouterr()
    assert (captured.out, "no drive.mcap in this folder" in captured.err) == ("", True)


@pytest.mark.parametrize(
    "options", [["--reviewer", "Ann"], ["--dark"], ["--rerun"], ["--no-open"], ["--port", "8081"]]
)
def test_a_summary_takes_no_option_of_the_pages(options, tmp_path, capsys):
    assert main(["review", str(tmp_path), "--summary", *options]) == 2
    assert f"--summary {options[0]}: a summary is printed; leave out" in capsys.readouterr().err
