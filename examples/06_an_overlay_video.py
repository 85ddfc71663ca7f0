"""Make a video of the ten seconds around the worst moment of a drive, with what the program saw over it.

    python examples/06_an_overlay_video.py [DRIVE] [FILE]

DRIVE is a folder of `fcw run`, by default recordings/demo/out (`fcw demo`).
"""

import sys
from pathlib import Path

import fcw
from fcw.logs.events import find_events
from fcw.logs.export.clip import DriveClip
from fcw.logs.export.mp4 import write_overlay_mp4
from fcw_viz.overlay import OverlayPainter

drive = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "recordings" / "demo" / "out"
out = Path(sys.argv[2]) if len(sys.argv) > 2 else drive / "worst-moment.mp4"

log = fcw.read_drive(drive)
worst = max(find_events(log.series()), key=lambda event: event.severity)
clip = DriveClip.open(log.path, between=(max(worst.peak_s - 5, 0), worst.peak_s + 5))
pictures = write_overlay_mp4(out, clip, OverlayPainter(log.header, clip.first_ns).paint, lambda: None)
print(f"{out}: {pictures} pictures around {worst.kind} at {worst.peak_s:.1f} s")
