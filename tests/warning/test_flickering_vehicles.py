"""A vehicle that the detector finds in a part of its frames is warned of where the danger lasts."""

from dataclasses import replace

from leads.warning_leads import make_lead, threats_of_lead

from fcw.tracking.types import SeenBy
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel

FRAME_NS = 33_333_333
NEAR, FAR = make_lead(15, 10), make_lead(60, 10)
UNSEEN = replace(NEAR, seen_by=SeenBy.COASTING)
SHOWN = {"n": NEAR, ".": FAR, "-": UNSEEN}


def levels(found_part: float, near: str) -> list[WarningLevel]:
    """By frame, of a vehicle that is near where the text has an n, and near but not seen where it has a -."""
    policy = make_policy()
    seen = [replace(SHOWN[letter], found_part=found_part) for letter in near]
    return [
        policy.update(frame * FRAME_NS, threats_of_lead(vehicle, None), None).level
        for frame, vehicle in enumerate(seen)
    ]


def first_warning(shown: list[WarningLevel]) -> int | None:
    return shown.index(WarningLevel.WARNING) if WarningLevel.WARNING in shown else None


def test_what_is_well_found_is_warned_of_at_once():
    calm = "." * 30
    assert first_warning(levels(1.0, calm + "n" * 10)) == 30


def test_what_is_badly_found_must_be_a_danger_for_a_while_and_gets_caution_until_then():
    shown = levels(0.5, "." * 30 + "n" * 10)
    first = first_warning(shown)
    assert first is not None
    assert 0.15e9 <= (first - 30) * FRAME_NS < 0.15e9 + FRAME_NS
    assert shown[30:first] == [WarningLevel.CAUTION] * (first - 30)


def test_a_danger_of_single_frames_of_a_badly_found_vehicle_is_never_warned_of():
    assert first_warning(levels(0.5, "." * 30 + "nnnn." * 6)) is None


def test_frames_in_which_it_is_not_seen_say_nothing_against_the_danger():
    assert first_warning(levels(0.5, "." * 30 + "n-nn--n" * 2)) == 36
