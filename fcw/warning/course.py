"""Whether the lead will be beside us when its distance is used up.

Seen from a car that turns, parked and waiting vehicles sweep across the straight path ahead, and a lead that
turns off or changes lanes leaves it. What is on a collision course keeps its bearing.
"""

from fcw.tracking.types import Track

LONGEST_S = 4.0
"""Sideways motion is not extrapolated farther than ISO 15623's largest TTC of a warning."""
CLEARANCE_M = 1.8
"""Two cars 1.8 m wide pass each other when their middles are farther apart."""


def will_miss(lead: Track) -> bool:
    """Whether the lead, if all goes on as it does now, is out of the way at contact; False if not closing."""
    if lead.ttc_s is None:
        return False
    return abs(lead.lateral_m + lead.lateral_speed_mps * min(lead.ttc_s, LONGEST_S)) > CLEARANCE_M
