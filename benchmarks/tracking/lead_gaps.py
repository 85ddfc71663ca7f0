"""Whether the lead is ever lost: gaps in its track, and changes of its identity, by the logs of drives.

    python benchmarks/tracking/lead_gaps.py DRIVE ... [--longest 0.2]

DRIVE is a folder of `fcw run`, or a folder of such folders. A vehicle counts that is the lead for half a
second or more. A gap is a time in which nothing saw it, neither detector nor picture, and after which it was
seen again; it changes its identity where another track begins within 2.5 s where it was believed. Whether the
vehicle was in sight at the end of its track, a person has to look: ends are listed with their frames.
"""

import argparse
import itertools
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.detection.boxes.overlap import intersection_over_union
from fcw.logs.export.clip import find_drives
from fcw.logs.mcap.reader import DriveLog
from fcw.tracking.types import SeenBy, Track

LEAD_S = 0.5
SUCCESSOR_S, SUCCESSOR_IOU = 2.5, 0.3


class Moment(NamedTuple):
    """Of one track."""

    frame: int
    time_s: float
    track: Track
    is_lead: bool


def corners(boxes: list[Box]) -> NDArray[np.float64]:
    """(N, 4): x, y, w, h."""
    return np.array([(box.x, box.y, box.w, box.h) for box in boxes])


def tracks_of(log: DriveLog) -> dict[int, list[Moment]]:
    """By id."""
    tracks: dict[int, list[Moment]] = {}
    for result in log.results():
        for track in result.tracks:
            moment = Moment(result.index, result.time_ns / 1e9, track, track.track_id == result.lead_id)
            tracks.setdefault(track.track_id, []).append(moment)
    return tracks


def successor(track: list[Moment], others: list[list[Moment]]) -> int | None:
    """Id of the track that begins where this one was believed after it was last seen."""
    last_s = max(moment.time_s for moment in track if not moment.track.coasting)
    believed = corners([moment.track.box for moment in track if moment.time_s >= last_s])
    for other in others:
        first = other[0]
        soon = last_s < first.time_s < last_s + SUCCESSOR_S
        if soon and intersection_over_union(believed, corners([first.track.box])).max() >= SUCCESSOR_IOU:
            return first.track.track_id
    return None


def main() -> None:
    """Print a line for each gap and end, and the sums of each drive."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("drives", type=Path, nargs="+")
    parser.add_argument("--longest", type=float, default=0.2, help="seconds; longer gaps are listed")
    options = parser.parse_args()
    for name, path in find_drives(options.drives).items():
        tracks = tracks_of(DriveLog(path))
        gaps = changes = leads = 0
        carried_s = 0.0
        for number, track in tracks.items():
            pairs = list(itertools.pairwise(track))
            if sum(after.time_s - before.time_s for before, after in pairs if before.is_lead) < LEAD_S:
                continue
            leads += 1
            carried_s += sum(b.time_s - a.time_s for a, b in pairs if b.track.seen_by is SeenBy.PICTURE)
            seen = [moment for moment in track if not moment.track.coasting]
            for before, after in itertools.pairwise(seen):
                gap_s = after.time_s - before.time_s
                if after.frame > before.frame + 1 and gap_s > options.longest and before.is_lead:
                    gaps += 1
                    sys.stdout.write(f"  {name} #{number}: {gap_s:.2f} s after frame {before.frame}\n")
            others = [other for key, other in tracks.items() if key != number]
            if seen[-1].is_lead and track[-1].track.coasting:
                heir = successor(track, others)
                changes += heir is not None
                box: Box = seen[-1].track.box
                sys.stdout.write(
                    f"  {name} #{number}: ends as lead after frame {seen[-1].frame}, {box.w:.0f} px wide, "
                    f"{'nothing' if heir is None else f'#{heir}'} follows\n"
                )
        sys.stdout.write(
            f"{name}: {leads} leads, {gaps} gaps, {changes} changes of identity, {carried_s:.1f} s carried\n"
        )


if __name__ == "__main__":
    main()
