"""Own speed from a number or a CSV file, and what is said of wrong ones."""

import re

import numpy as np
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


@pytest.mark.parametrize("step_s", [1 / 30, 1.0, 5.0])
def test_one_lost_sample_is_bridged_and_more_are_a_gap(step_s):
    lost = {10, 20, 21, *range(30, 130)}
    numbers = [number for number in range(140) if number not in lost]
    speed = EgoSpeed(tuple(n * step_s for n in numbers), tuple(n * 0.25 for n in numbers))

    def at(number):
        return speed.at(round(number * step_s * 1e9))

    assert at(10) == pytest.approx(2.5)
    two_lost = pytest.approx(5.25) if step_s < 0.5 else None  # within 0.1 s no car changes its speed
    assert at(21) == two_lost
    assert at(80) is None
    assert at(29.001) is None
    assert at(28.999) == pytest.approx(28.999 * 0.25, abs=1e-6)


def test_of_a_few_samples_none_is_far_from_the_others():
    assert EgoSpeed((0.0, 10.0), (10.0, 20.0)).at(5 * 10**9) == 15.0
    rare = EgoSpeed((0.0, 100.0), (30.0, 0.0))
    assert [rare.at(t * 10**9) for t in (0, 1, 50, 99, 100)] == [30.0, None, None, None, 0.0]
    assert EgoSpeed((3.0,), (30.0,)).at(3 * 10**9) == 30.0


def test_a_yaw_rate_has_the_gaps_of_the_speed():
    turning = EgoSpeed((0.0, 0.1, 0.2, 5.0, 5.1), (10.0,) * 5, (0.1,) * 5)
    assert [turning.yaw_rate_at(t * 10**8) for t in (1, 25, 50)] == [0.1, None, 0.1]


def test_gaps_are_measured_as_far_as_they_are_in_a_drive():
    speed = EgoSpeed((0.0, 0.1, 0.2, 5.0, 5.1, 15.1), (10.0,) * 6)
    assert speed.gaps_s(1.0, 8.0) == pytest.approx((4.0, 2.9))
    assert speed.gaps_s(0.0, 0.2) == ()
    assert EgoSpeed.constant(10.0).gaps_s(0.0, 100.0) == ()


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
        ("time_s,speed_mps\n0,-3\n", "line 2: speed_mps is -3, expected metres per second between 0 and 70"),
        ("time_s,speed_mps\n0,30\n1,120\n", "line 3: speed_mps is 120, expected metres per second between"),
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
    with pytest.raises(UserError, match="expected metres per second between 0 and 70"):
        EgoSpeed.parse(text)


def test_a_speed_in_kilometres_an_hour_is_asked_about():
    with pytest.raises(UserError, match=r"did you mean 27\.8 m/s \(100 km/h\)\?"):
        EgoSpeed.parse("100")
    assert EgoSpeed.parse("70").at(0) == 70.0  # 252 km/h


def test_a_decimal_comma_is_no_file():
    with pytest.raises(UserError, match=r"ego speed 22,5: expected metres per second with a point: 22\.5"):
        EgoSpeed.parse("22,5")


def test_a_missing_file_says_what_may_be_given(tmp_path):
    with pytest.raises(
        UserError, match="no such file; give metres per second or the path of a CSV or GPX file"
    ):
        EgoSpeed.parse(str(tmp_path / "none.csv"))


def test_a_folder_cannot_be_read(tmp_path):
    with pytest.raises(UserError, match="cannot be read"):
        EgoSpeed.parse(str(tmp_path))


def gpx_file(tmp_path, points, name_space=' xmlns="http://www.topografix.com/GPX/1/1"'):
    path = tmp_path / "drive.gpx"
    path.write_text(f"<gpx{name_space}><trk><trkseg>{''.join(points)}</trkseg></trk></gpx>")
    return path


def point(second, lat=48.0, lon=11.0, speed=None):
    given = "" if speed is None else f"<extensions><speed>{speed}</speed></extensions>"
    return (
        f'<trkpt lat="{lat:.9f}" lon="{lon:.9f}"><time>2026-05-01T10:00:{second:02d}Z</time>{given}</trkpt>'
    )


@pytest.mark.parametrize("name_space", ["", ' xmlns="http://www.topografix.com/GPX/1/0"'])
def test_a_gpx_track_gives_the_receivers_own_speeds_from_its_first_point_on(tmp_path, name_space):
    points = [point(second, speed=10 + second) for second in (5, 6, 8)]
    speed = EgoSpeed.parse(str(gpx_file(tmp_path, points, name_space)))
    assert [speed.at(t * 10**9) for t in (0, 1, 2, 3)] == pytest.approx([15, 16, 17, 18])
    assert speed.at(4 * 10**9) is None


def test_without_speeds_in_it_they_follow_from_the_places(tmp_path):
    # One degree of latitude is 6371 km pi / 180 = 111.195 km: 20 m/s northwards.
    points = [point(second, lat=48 + 20 * second / 111_194.93) for second in range(5)]
    speed = EgoSpeed.read_gpx(gpx_file(tmp_path, points))
    assert [speed.at(t * 10**9) for t in range(5)] == pytest.approx([20] * 5, rel=1e-4)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([point(1)], "1 track points; expected a GPX track"),
        ([point(2), point(1)], "track point 2: its time is not later than that of the point before"),
        ([point(1), '<trkpt lat="1" lon="2"/>'], "track point 2: 'time'; expected a GPX track"),
        ([point(1), '<trkpt lat="x" lon="2"><time>2026-05-01</time></trkpt>'], "track point 2: could not"),
        (
            [point(1), point(2, lat=49.0)],
            "track point 1: 111195 m/s, expected metres per second between 0 and 70; remove",
        ),
        ([point(1, speed=3), point(2, speed="fast")], "'fast'; expected metres per second in <speed>"),
        (["<trkpt>"], "cannot be read"),
    ],
)
def test_a_wrong_gpx_file_is_named_with_the_point(tmp_path, points, message):
    path = gpx_file(tmp_path, points)
    with pytest.raises(UserError, match=re.escape(message)) as caught:
        EgoSpeed.parse(str(path))
    assert str(path) in str(caught.value)


def test_a_yaw_rate_is_read_where_there_is_one_and_unknown_elsewhere(tmp_path):
    turning = EgoSpeed.read_csv(csv_file(tmp_path, "time_s,speed_mps,yaw_rate_radps\n0,10,0.1\n2,10,-0.1\n"))
    assert [turning.yaw_rate_at(t * 10**9) for t in (0, 1, 2)] == [0.1, 0.0, -0.1]
    assert turning.yaw_rate_at(3 * 10**9) is None
    assert EgoSpeed.read_csv(csv_file(tmp_path, "time_s,speed_mps\n0,10\n2,10\n")).yaw_rate_at(0) is None
    assert EgoSpeed.parse("13.9").yaw_rate_at(0) is None


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("12", "yaw_rate_radps is 12, expected radians per second"),
        ("", "yaw_rate_radps is '', expected a number"),
    ],
)
def test_a_wrong_yaw_rate_is_named_with_line_and_value(tmp_path, value, message):
    path = csv_file(tmp_path, f"time_s,speed_mps,yaw_rate_radps\n0,10,{value}\n")
    with pytest.raises(UserError, match=re.escape(f"line 2: {message}")):
        EgoSpeed.read_csv(path)


NAN: float = float("nan")


@pytest.mark.parametrize(
    ("samples", "message"),
    [
        (((28.0, 29.0), (20.0, NAN)), "nan, expected a number"),
        (((28.0, NAN), (20.0, 20.0)), "nan, expected a number"),
        (((0.0, 1.0), (20.0, "20")), "20, expected a number"),
        (((0.0, 1.0), (20.0, None)), "None, expected a number"),
        (((29.0, 28.0), (20.0, 21.0)), "time 28 s is not after 29 s; sort the samples by time"),
        (((28.0, 28.0), (20.0, 21.0)), "time 28 s is not after 28 s; sort the samples by time"),
        (((28.0, 29.0), (20.0,)), "2 times, 1 speeds and 0 yaw rates, expected as many speeds as times"),
        (((), ()), "0 times, 0 speeds and 0 yaw rates, expected as many speeds as times, or one speed"),
        (((0.0, 1.0), (2.0, 2.0), (0.1,)), "2 times, 2 speeds and 1 yaw rates"),
        (((0.0, 1.0), (20.0, -3.0)), "speed -3, expected metres per second between 0 and 70"),
        (((), (100.0,)), "speed 100, expected metres per second between 0 and 70; did you mean 27.8 m/s"),
        (((0.0, 1.0), (2.0, 2.0), (0.1, 12.0)), "yaw rate 12, expected radians per second between -3 and 3"),
    ],
)
def test_samples_that_are_none_are_named_when_they_are_given(samples, message):
    with pytest.raises(UserError, match="^EgoSpeed: " + re.escape(message)):
        EgoSpeed(*samples)


def test_numbers_may_be_of_numpy():
    speed = EgoSpeed(tuple(np.array([0, 1], np.float32)), tuple(np.array([10, 20])))
    assert speed.at(500_000_000) == 15.0
