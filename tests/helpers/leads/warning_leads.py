"""Leads as a tracker gives them, and their threats, for the tests of this folder."""

from fcw.box import Box
from fcw.motion.state import STRAIGHT, OwnPath
from fcw.threat.threat import Threat, assess
from fcw.tracking.types import SeenBy, Track


def make_lead(
    distance_m,
    closing_mps,
    sigma_mps=0.0,
    *,
    track_id=1,
    lateral_m=0.0,
    lateral_mps=0.0,
    growth_mps2=0.0,
    growth_sigma_mps2=0.0,
    spread=0.0,
    age_s=3.0,
    seen_by=SeenBy.DETECTOR,
):
    return Track(
        track_id=track_id,
        box=Box(600, 300, 80, 60),
        score=1.0,
        distance_m=distance_m,
        distance_low_m=distance_m * (1 - spread),
        distance_high_m=distance_m * (1 + spread),
        lateral_m=lateral_m,
        closing_speed_mps=closing_mps,
        closing_speed_sigma_mps=sigma_mps,
        ttc_s=distance_m / closing_mps if closing_mps > 0 else None,
        age_s=age_s,
        seen_by=seen_by,
        in_path=True,
        closing_acceleration_mps2=growth_mps2,
        closing_acceleration_sigma_mps2=growth_sigma_mps2,
        lateral_speed_mps=lateral_mps,
    )


def threats_of_lead(
    track: Track | None, own_mps: float | None = None, path: OwnPath = STRAIGHT, *, is_lead: bool = True
) -> tuple[Threat, ...]:
    """The threats where there is this vehicle alone, or none."""
    if track is None:
        return ()
    return assess((track,), track.track_id if is_lead else None, path, own_mps)
