"""Own speed from a number or a CSV file, and what is said of wrong ones."""

import re

import pytest

from fcw.errors import UserError
from fcw.warning.ego_speed import EgoSpeed


def csv_file(tmp_path, text):
    path = tmp_path / "speed.csv"
    path.write_text(text)
    return path


def test_a_number_is_metres_per_second_all_the_time():
    speed = EgoSpeed.parse("13.9")
    assert speed.at(0) == speed.at(10**12) == 13.9


def test_a_csv_is_linear_between_its_samples_and_unknown_outside(tmp_path):
    path = csv_file(tmp_path, "time_s,speed_mps\n1.0,10\n2.0,20\n\n4.0,20\n")
    speed = EgoSpeed.parse(str(path))
    assert [speed.at(t * 10**8) for t in (10, 15, 20, 30, 40)] == pytest.approx([10, 15, 20, 20, 20])
    assert speed.at(999_999_999) is None
    assert speed.at(4_000_000_001) is None


def test_columns_may_come_in_any_order_among_others(tmp_path):
    speed = EgoSpeed.read_csv(csv_file(tmp_path, "speed_mps, gear, time_s\n10, 3, 0\n12, 4, 1\n"))
    assert speed.at(500_000_000) == pytest.approx(11)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no column time_s"),
        ("time_s,v\n0,1\n", "no column speed_mps in the first line; expected a CSV with the header"),
        ("time_s,speed_mps\n", "no line below the header"),
        ("time_s,speed_mps\n0,1\n1,fast\n", "line 3: speed_mps is 'fast', expected a number"),
        ("time_s,speed_mps\n0,1\n1\n", "line 3: speed_mps is '', expected a number"),
        ("time_s,speed_mps\nnan,1\n", "line 2: time_s is 'nan', expected a number"),
        ("time_s,speed_mps\n0,1\n1,2\n1,3\n", "line 4: time_s 1 is not after 1"),
        ("time_s,speed_mps\n0,-3\n", "line 2: speed_mps is -3, expected metres per second between 0 and 150"),
        ("time_s,speed_mps\n0,1\n\n1,inf\n", "line 4: speed_mps is 'inf', expected a number"),
    ],
)
def test_a_wrong_file_is_named_with_line_and_value(tmp_path, text, message):
    path = csv_file(tmp_path, text)
    with pytest.raises(UserError, match=re.escape(message)) as caught:
        EgoSpeed.parse(str(path))
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("text", ["-1", "nan", "inf", "400"])
def test_an_implausible_number_is_refused(text):
    with pytest.raises(UserError, match="expected metres per second between 0 and 150"):
        EgoSpeed.parse(text)


def test_a_missing_file_says_what_may_be_given(tmp_path):
    with pytest.raises(UserError, match="no such file; give metres per second or the path of a CSV file"):
        EgoSpeed.parse(str(tmp_path / "none.csv"))


def test_a_folder_cannot_be_read(tmp_path):
    with pytest.raises(UserError, match="cannot be read"):
        EgoSpeed.parse(str(tmp_path))
