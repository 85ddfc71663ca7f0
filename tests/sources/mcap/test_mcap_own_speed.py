"""The own speed in an MCAP file of others: which of its messages are used, and what is said of the rest."""

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mcap_files import DELAY_NS, START_NS, ros_file, ros_image, ros_twist

from fcw.sources.mcap.facts import McapFacts, mcap_facts

IMAGE, TWIST = "sensor_msgs/msg/Image", "geometry_msgs/msg/TwistStamped"
COVARIANT = "geometry_msgs/msg/TwistWithCovarianceStamped"
PERIOD_NS = 100_000_000
HOUR_NS = 3600 * 10**9
TWIST_NOTE = "drive.mcap: own speed from /twist (geometry_msgs/TwistStamped)"

Message = tuple[str, str, int, Any]


def picture(time_ns: int = START_NS) -> Message:
    grey = np.zeros((4, 6, 1), np.uint8)
    return "/camera", IMAGE, time_ns + DELAY_NS, ros_image(grey, "mono8", time_ns)


def twist(number: int, speed_mps: float, late_ns: int = 0, topic: str = "/twist") -> Message:
    """A speed ten times a second, whose stamp may be late by some time."""
    time_ns = START_NS + number * PERIOD_NS
    return topic, TWIST, time_ns + DELAY_NS, ros_twist(time_ns + late_ns, speed_mps)


def facts(folder: Path, messages: Sequence[Message]) -> McapFacts:
    return mcap_facts(ros_file(folder / "drive.mcap", [picture(), *messages]))


def test_a_speed_that_is_0_throughout_is_as_good_as_none(tmp_path: Path) -> None:
    found = facts(tmp_path, [twist(number, 0.0) for number in range(10)])
    assert found.ego_speed is None
    assert found.notes == (
        "drive.mcap: the own speed in /twist (geometry_msgs/TwistStamped) is 0 throughout, as if never "
        "filled in: it is not used; if the car stood, give --ego-speed 0",
    )


def test_who_stands_at_times_stands(tmp_path: Path) -> None:
    found = facts(tmp_path, [twist(number, 0.0 if number < 9 else 0.5) for number in range(10)])
    assert found.ego_speed is not None
    assert found.ego_speed.at(START_NS) == 0.0
    assert found.notes == (TWIST_NOTE,)


def test_after_one_that_is_0_throughout_the_next_kind_is_asked(tmp_path: Path) -> None:
    empty = [_with_covariance(twist(number, 0.0, topic="/gps")) for number in range(10)]
    found = facts(tmp_path, [*empty, *(twist(number, 20.0) for number in range(10))])
    assert found.ego_speed is not None
    assert found.ego_speed.at(START_NS) == 20.0
    assert ["/gps" in note for note in found.notes] == [True, False]
    assert found.notes[1] == TWIST_NOTE


def test_speeds_beyond_any_cars_are_left_out_and_counted(tmp_path: Path) -> None:
    found = facts(tmp_path, [twist(number, 300.0 if number == 4 else 20.0) for number in range(10)])
    assert found.ego_speed is not None
    assert set(found.ego_speed.speeds_mps) == {20.0}
    assert found.notes == (TWIST_NOTE, "drive.mcap: /twist: 1 of its speeds, beyond 70 m/s, left out")


def test_a_speed_that_is_beyond_any_cars_throughout_is_said_not_to_be_used(tmp_path: Path) -> None:
    found = facts(tmp_path, [twist(number, 90.0) for number in range(10)])
    assert found.ego_speed is None
    assert found.notes == (
        "drive.mcap: the own speed in /twist (geometry_msgs/TwistStamped) is beyond 70 m/s throughout: it is "
        "not used; if it is in km/h, give it with --ego-speed in m/s",
    )


def _with_covariance(message: Message) -> Message:
    topic, _, log_ns, stamped = message
    twist = SimpleNamespace(twist=stamped.twist, covariance=[0.0] * 36)
    return topic, COVARIANT, log_ns, SimpleNamespace(header=stamped.header, twist=twist)


def test_one_stamp_of_an_hour_later_leaves_the_speeds_as_they_are(tmp_path: Path) -> None:
    late = {number: HOUR_NS if number in (0, 5) else 0 for number in range(20)}
    found = facts(tmp_path, [twist(number, 10.0 + number, late[number]) for number in late])
    assert found.ego_speed is not None
    speeds = [found.ego_speed.at(START_NS + number * PERIOD_NS) for number in late]
    # At the ends rounding may put a time just outside.
    assert speeds[1:-1] == pytest.approx([10.0 + number for number in late][1:-1], abs=1e-4)
    assert found.ego_speed.times_s[-1] == pytest.approx((START_NS + 19 * PERIOD_NS) / 1e9)
    strays = "drive.mcap: /twist: 2 messages with impossible time stamps: their log times are used"
    assert found.notes == (TWIST_NOTE, strays)


def test_speeds_are_sorted_by_their_stamps(tmp_path: Path) -> None:
    numbers = [0, 2, 1, 3, 5, 4, 6]
    messages = [twist(number, 10.0 + number) for number in numbers]
    logged = [(*message[:2], START_NS + i, message[3]) for i, message in enumerate(messages)]
    found = facts(tmp_path, logged)
    assert found.ego_speed is not None
    assert found.ego_speed.speeds_mps == (10, 11, 12, 13, 14, 15, 16)
    assert found.notes == (TWIST_NOTE,)


def test_a_clock_that_is_set_while_recording_is_followed(tmp_path: Path) -> None:
    found = facts(tmp_path, [twist(number, 10.0, HOUR_NS if number >= 10 else 0) for number in range(20)])
    assert found.ego_speed is not None
    first_s = START_NS / 1e9
    assert found.ego_speed.times_s[9:11] == pytest.approx((first_s + 0.9, first_s + 3601.0))
    assert found.notes == (TWIST_NOTE,)
