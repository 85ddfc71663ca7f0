"""Put a warning policy of your own into the job: warn when a collision is likelier than not.

python examples/04_your_own_policy.py [FOLDER]
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import fcw

drive = Path(__file__).parents[1] / "recordings" / "demo" / "drive.mp4"
out = Path(sys.argv[1]) if len(sys.argv) > 1 else drive.with_name("own-policy")


class Likely:
    """Any class with a name and this method is a policy."""

    name = "likely"

    def update(
        self, time_ns: int, threats: Sequence[fcw.Threat], ego_speed_mps: float | None
    ) -> fcw.WarningState:
        """Threats are those of all vehicles, the most urgent first."""
        for threat in threats:
            if threat.collision_probability > 0.5 and threat.reach_s is not None and threat.reach_s < 2.0:
                return fcw.WarningState(
                    fcw.WarningLevel.WARNING,
                    threat.track.track_id,
                    rule="likely",
                    ttc_s=threat.reach_s,
                    collision_probability=threat.collision_probability,
                )
        return fcw.WarningState(fcw.WarningLevel.NONE)


outcome = fcw.run_drive(fcw.DriveJob(drive, out, detector="acf", warning_policy=Likely()))
for warning in outcome.summary["warnings"]:
    print(f"{warning['start_s']:.2f} to {warning['end_s']:.2f} s: {warning['min_distance_m']:.1f} m away")
