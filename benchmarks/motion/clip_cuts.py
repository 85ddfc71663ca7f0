"""How far the likeness of pictures that follow each other is from that of pictures that do not.

    FCW_DATA=DIR PYTHONPATH=benchmarks python benchmarks/motion/clip_cuts.py

On the ten clips, the two drives of KITTI and the shipped one: steps within a view, and pairs drawn by chance
from two cameras, from two drives of one camera, and from one view at least 3 s apart.
"""

import argparse
import math
import random
import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from real_drives import data_folder

from fcw.motion.flow import cuts
from fcw.sources import open_source

ROOT = Path(__file__).parents[2]
EDITED = {"kb_dashcam2": (363, 434), "tmo_seattlestreet2": (820,)}
"""The first picture of each other view, seen by eye."""
UP_TO_MS = (50, 150, 210)
PAIRS, APART_S = 2000, 3.0

_View = tuple[str, float, list[NDArray[np.float32]]]


def main() -> None:
    """Print the least likeness of steps, and how many pairs have less than follow each other."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    views = list(read_views())
    steps: dict[int, list[float]] = {upto: [] for upto in UP_TO_MS}
    for _, rate_hz, pictures in views:
        for step in range(1, math.floor(UP_TO_MS[-1] / 1000 * rate_hz) + 1):
            upto = next(upto for upto in UP_TO_MS if 1000 * step / rate_hz <= upto)
            every = 2 if len(pictures) > 300 else 1
            pairs = zip(pictures[::every], pictures[step::every], strict=False)
            steps[upto] += [cuts.likeness(*pair) for pair in pairs]
    for upto, likenesses in steps.items():
        least = cuts.ALIKE_SOON if upto <= cuts.SOON_NS / 1e6 else cuts.ALIKE
        few, lowest = sum(one < least for one in likenesses), min(likenesses)
        sys.stdout.write(
            f"steps of up to {upto} ms: {len(likenesses)}, the lowest {lowest:.2f}, {few} below {least}\n"
        )
    apart: dict[str, list[float]] = {}
    for kind, before, now in drawn(views):
        apart.setdefault(kind, []).append(cuts.likeness(before, now))
    for kind, likenesses in apart.items():
        found = [f"{np.mean(np.array(likenesses) < one):.0%}" for one in (cuts.ALIKE, cuts.ALIKE_SOON)]
        sys.stdout.write(
            f"{kind}: {len(likenesses)}, {found[0]} below {cuts.ALIKE}, {found[1]} below {cuts.ALIKE_SOON}\n"
        )


def read_views() -> Iterator[_View]:
    """Name, rate in Hz and small pictures of all that one camera saw without a cut."""
    data = data_folder()
    drives = [*sorted((data / "clips").glob("*.mp4")), data / "kitti-odometry-03" / "drive.mp4"]
    for path in [*drives, data / "kitti-sfnd" / "images", ROOT / "recordings" / "demo" / "drive.mp4"]:
        kitti = path.parent.name.startswith("kitti")
        source = open_source(path, 10.0 if path.is_dir() else None)
        pictures = [cuts.details(frame.image) for frame in source.frames()]
        borders = [0, *EDITED.get(path.stem, ()), len(pictures)]
        for begin, end in pairwise(borders):
            name = path.parent.name if kitti else path.stem
            yield name, 10.0 if kitti else source.frame_rate_hz, pictures[begin:end]


def drawn(views: Sequence[_View]) -> Iterator[tuple[str, NDArray[np.float32], NDArray[np.float32]]]:
    """Pairs of pictures that do not follow each other, and what they are of."""
    chance = random.Random(1)
    for _ in range(PAIRS):
        (name, _, pictures), (other, _, others) = chance.sample(views, 2)
        if name != other:
            same = name.split("_")[0] == other.split("_")[0]
            kind = "one camera, two drives" if same else "two cameras"
            yield kind, chance.choice(pictures), chance.choice(others)
        _, rate_hz, pictures = chance.choice(views)
        first, second = sorted((chance.randrange(len(pictures)), chance.randrange(len(pictures))))
        if second - first >= APART_S * rate_hz:
            yield "one view, 3 s apart", pictures[first], pictures[second]


if __name__ == "__main__":
    main()
