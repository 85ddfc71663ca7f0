"""Scenario files: the shipped ones are read, and every mistake is named with its place."""

import math

import pytest

from fcw.errors import UserError
from fcw.simulation.world.scenario import load_scenario, scenario_names
from fcw.simulation.world.state import VehicleKind

PLAIN = """
description: Following.
duration_s: 5
ego:
  speed_kmh: 50
vehicles:
  - name: lead
    kind: van
    gap_m: 20
    speed_kmh: 50
    actions:
      - {at_s: 1, speed_kmh: 30, rate_mps2: 2}
"""


def read(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    return load_scenario(str(path))


def test_the_shipped_scenarios_are_read():
    assert set(scenario_names()) >= {"demo", "braking", "cut-in", "oncoming"}
    for name in scenario_names():
        scenario = load_scenario(name)
        assert scenario.vehicles
        assert scenario.frame_count == round(scenario.duration_s * 30)


def test_a_file_of_ones_own_is_read_into_what_it_says(tmp_path):
    scenario = read(tmp_path, PLAIN + "camera: {pitch_deg: 2.0}\nroad:\n  bends:\n"
                    "    - {start_m: 10, length_m: 100, radius_m: -300}\n")  # fmt: skip
    (lead,) = scenario.vehicles
    assert lead.kind is VehicleKind.VAN
    assert lead.actions[0].rate_mps2 == 2
    assert scenario.camera.camera().pitch_rad == pytest.approx(math.radians(2))
    assert scenario.road.bends[0].radius_m == -300


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("duration_s: 5", "duration_s: soon", "duration_s is 'soon', expected a finite number"),
        ("duration_s: 5", "duration_s: -1", "duration_s is -1.0, expected 0 to 3600"),
        ("duration_s: 5", "duration_s: 0.01", "duration_s is 0.01, expected 1/30, a picture, or more"),
        ("duration_s: 5", "", "duration_s is missing"),
        ("kind: van", "kind: bus", "vehicles[0].kind is 'bus', expected one of saloon, hatch"),
        ("gap_m: 20", "gap: 20", "vehicles[0].gap is no field; expected one of name, gap_m"),
        ("gap_m: 20", "gap_m: 20\n    lane: 2", "lane is 2, expected 0 to 0"),
        ("gap_m: 20", "gap_m: 20\n    lane: 0.5", "vehicles[0].lane is 0.5, expected a whole number"),
        ("gap_m: 20", "gap_m: 20\n    parked: 1", "vehicles[0].parked is 1, expected true or false"),
        ("gap_m: 20", "gap_m: 20\n    parked: true", "parked is True, expected neither speed nor actions"),
        (", speed_kmh: 30", ", speed_kmh: 30, lane: 0", "vehicles[0].actions[0]: action is ['speed"),
        (", speed_kmh: 30", "", "expected exactly one of speed_kmh, follow_kmh, lane"),
        ("rate_mps2: 2", "rate_mps2: 0", "rate_mps2 is 0.0, expected a number above 0"),
        ("  speed_kmh: 50\nvehicles", "  speed_kmh: 500\nvehicles", "ego: speed_kmh is 500.0, expected"),
        ("vehicles:", "road: []\nvehicles:", "road is [], expected a mapping"),
        ("vehicles:", "road: {marks_m: [6, 3, 9]}\nvehicles:", "marks_m is [6.0, 3.0, 9.0], expected"),
        ("vehicles:", "road: {marks_m: 6}\nvehicles:", "road.marks_m is 6, expected a list"),
        ("description: Following.", "description: [", "not a YAML file"),
    ],
)  # fmt: skip
def test_mistakes_are_named_with_file_field_and_value(tmp_path, old, new, message):
    assert old in PLAIN
    with pytest.raises(UserError) as error:
        read(tmp_path, PLAIN.replace(old, new, 1))
    assert message in str(error.value)
    assert "mine.yaml" in str(error.value)


def test_two_vehicles_of_one_name_are_refused(tmp_path):
    with pytest.raises(UserError, match="names that differ"):
        read(tmp_path, PLAIN + "  - {name: lead, gap_m: 60}\n")


def test_an_unknown_scenario_is_answered_with_the_known_ones():
    with pytest.raises(UserError, match="expected one of braking, cut-in, demo, oncoming"):
        load_scenario("storm")
