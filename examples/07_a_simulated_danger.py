"""Render a danger with exact truth, run the program on it, and compare.

    python examples/07_a_simulated_danger.py [FOLDER]

The scenarios are YAML files in fcw/simulation/world/scenarios; `fcw simulate` takes your own.
"""

import sys
from dataclasses import replace
from pathlib import Path

import fcw
from fcw.evaluation.simulated import compare_with_truth
from fcw.simulation.drive import write_drive
from fcw.simulation.truth.file import read_truth
from fcw.simulation.world.scenario import load_scenario

out = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("simulated")
scenario = load_scenario("braking")  # of frozen dataclasses: change what you like
(lead,) = scenario.vehicles
(brakes,) = lead.actions
lead = replace(lead, actions=(replace(brakes, at_s=1.5),))
write_drive(replace(scenario, vehicles=(lead,), duration_s=4.5), out)
fcw.run_drive(fcw.DriveJob(out / "drive.mp4", out / "run", ego_speed=str(out / "drive.speed.csv")))
comparison = compare_with_truth(list(fcw.read_drive(out / "run").results()), read_truth(out / "truth.csv"))
print(f"{comparison.detection_rate:.0%} of {comparison.vehicles} vehicles found")
for due in comparison.due:
    print(f"{due.vehicle}: a warning was due at {due.due_s:.2f} s and came at {due.warned_s}")
