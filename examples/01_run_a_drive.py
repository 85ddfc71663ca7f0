"""Run a drive from Python, read its log back, and tell when it warned.

    python examples/01_run_a_drive.py [FOLDER]

The whole job on the shipped drive; its log goes to FOLDER, by default recordings/demo/out.
"""

import sys
from itertools import pairwise
from pathlib import Path

import fcw

drive = Path(__file__).parents[1] / "recordings" / "demo" / "drive.mp4"
out = Path(sys.argv[1]) if len(sys.argv) > 1 else drive.with_name("out")
fcw.run_drive(fcw.DriveJob(drive, out, ego_speed=str(drive.with_name("drive.speed.csv"))))

results = list(fcw.read_drive(out).results())
print(f"{len(results)} frames, a lead vehicle in {sum(result.lead is not None for result in results)}")
for before, result in pairwise(results):
    shown, shown_before = result.warning, before.warning
    if shown.level and (shown.level, shown.track_id) != (shown_before.level, shown_before.track_id):
        time_s = (result.time_ns - results[0].time_ns) / 1e9
        print(f"{time_s:.2f} s: {shown.level.name.lower()} about vehicle {shown.track_id} ({shown.rule})")
