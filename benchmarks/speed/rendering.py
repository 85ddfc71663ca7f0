"""How long one core takes to render the shipped scenario's pictures.

    python benchmarks/speed/rendering.py [--seeds 0 1 2] [--frames 100]

Times are of the processor, not of the clock on the wall, so that other work on the machine matters little.
"""

import argparse
import datetime
import sys
import time

import cv2
import numpy as np

from fcw.simulation.picture.renderer import Renderer
from fcw.simulation.world.scenario import IMAGE_SIZE, load_scenario
from fcw.simulation.world.world import World
from fcw.versions import machine, versions

SCENARIO = "demo"


def main() -> None:
    """Read the command line, render, and say how fast it was."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else None)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--frames", type=int, default=100, help="of each seed, spread over the drive")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    libraries = ", ".join(f"{name} {number}" for name, number in versions().items())
    sys.stdout.write(f"{datetime.datetime.now(datetime.UTC):%Y-%m-%d}, {machine()}; {libraries}\n")
    for seed in options.seeds:
        times_ms = frame_times_ms(seed, options.frames)
        median, slow = np.median(times_ms), np.percentile(times_ms, 95)
        sys.stdout.write(
            f"seed {seed}: {len(times_ms)} pictures of {IMAGE_SIZE}, median {median:.1f} ms "
            f"({1e3 / median:.1f}/s), 95 % within {slow:.1f} ms\n"
        )


def frame_times_ms(seed: int, count: int) -> list[float]:
    """Time of each of `count` pictures spread over the drive, after one that compiles and draws textures."""
    scenario = load_scenario(SCENARIO)
    renderer = Renderer(scenario.camera.camera(), IMAGE_SIZE, seed)
    states = list(World(scenario, seed).states())
    renderer.render(states[0])
    times_ms = []
    for state in states[:: max(len(states) // count, 1)][:count]:
        start_s = time.process_time()
        renderer.render(state)
        times_ms.append(1e3 * (time.process_time() - start_s))
    return times_ms


if __name__ == "__main__":
    main()
