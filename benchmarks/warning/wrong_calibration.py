"""Are dangers warned of in time, and only these, where the camera is not as its calibration says?

    PYTHONPATH=benchmarks python benchmarks/warning/wrong_calibration.py [--scenario NAME ...] [--seeds 1]

The simulated dangers, and what only looks like one, are rendered. The default detector, own motion and the
tracker go by a calibration that is taken for exact and is wrong in one number; they may find out. A focal
length is wrong with the horizon where it is, as when the lens was guessed. A yaw is one that nobody told.
Takes two minutes for each scenario and seed, and 1.5 GB of memory.
"""

import argparse
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from lines import say, say_row, where_and_with_what

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.choice import NET, load_model, make_detector
from fcw.evaluation.warning.threats import ThreatTrial, run_threat_trial
from fcw.simulation.drive import render_drive, true_calibration
from fcw.simulation.world.scenario import load_scenario, threat_names
from fcw.warning.policies import make_policy


def pitched(camera: GroundPlaneCamera, off_deg: float) -> GroundPlaneCamera:
    """Believed to look so much farther down than it does."""
    return replace(camera, pitch_rad=camera.pitch_rad + math.radians(off_deg))


def raised(camera: GroundPlaneCamera, times: float) -> GroundPlaneCamera:
    """Believed to be so many times as high as it is."""
    return replace(camera, height_m=camera.height_m * times)


def zoomed(camera: GroundPlaneCamera, times: float) -> GroundPlaneCamera:
    """Believed to have so many times its focal length, the horizon where it is."""
    focal_px = camera.focal_y_px * times
    pitch_rad = math.atan((camera.principal_row_px - camera.horizon_row_px) / focal_px)
    return replace(camera, focal_y_px=focal_px, pitch_rad=pitch_rad)


def turned(camera: GroundPlaneCamera, off_deg: float) -> GroundPlaneCamera:
    """Believed to look straight ahead, while it looks so much to the left."""
    aside_px = camera.focal_y_px * math.tan(math.radians(off_deg))
    return replace(camera, principal_column_px=camera.principal_column_px - aside_px)


WRONG: dict[str, Callable[[GroundPlaneCamera], GroundPlaneCamera]] = {
    "right": partial(pitched, off_deg=0.0),
    **{f"pitch {by:+g} degrees": partial(pitched, off_deg=by) for by in (-4, -2, -1, 1, 2, 4)},
    **{f"height {by:g} times": partial(raised, times=by) for by in (0.7, 0.85, 1.15, 1.3)},
    **{f"focal length {by:g} times": partial(zoomed, times=by) for by in (0.65, 0.8, 1.25, 1.5)},
    **{f"yaw {by:+g} degrees": partial(turned, off_deg=by) for by in (-2, 2)},
}


def main() -> None:
    """Print a line for each run that fails, and a table of the calibrations."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenario", nargs="+", choices=threat_names(), default=threat_names())
    parser.add_argument("--seeds", type=int, default=1)
    given = parser.parse_args()
    if given.seeds < 1:
        parser.error(f"--seeds {given.seeds}: expected 1 or more")
    say(where_and_with_what())
    trials: dict[str, list[ThreatTrial]] = {name: [] for name in WRONG}
    for scenario in given.scenario:
        for seed in range(given.seeds):
            for name, trial in run(scenario, seed).items():
                trials[name].append(trial)
                if not trial.passed:
                    say(f"{scenario}, seed {seed}, {name}: {words(trial)}")
    say("")
    say_row(("calibration", "dangers in their window", "the others", "harmless with a `warning`"), head=True)
    for name, of_name in trials.items():
        dangers = [trial for trial in of_name if trial.window is not None]
        harmless = [trial for trial in of_name if trial.window is None]
        say_row(
            (
                name,
                f"{sum(trial.passed for trial in dangers)} of {len(dangers)}",
                ", ".join(words(trial) for trial in dangers if not trial.passed),
                f"{sum(not trial.passed for trial in harmless)} of {len(harmless)}",
            )
        )


def run(name: str, seed: int) -> dict[str, ThreatTrial]:
    """A scenario with each of the calibrations, of the same pictures."""
    scenario = load_scenario(name)
    right, model = true_calibration(scenario), load_model(NET)
    pictures = list(render_drive(scenario, seed))
    trials = {}
    for told, wrong in WRONG.items():
        calibration = Calibration.from_camera(wrong(right.camera), right.image_size, right.reference_offset_m)
        detector = make_detector(NET, model, calibration, for_tracker=True)
        trials[told] = run_threat_trial(
            scenario, seed, make_policy(), detector, calibration=calibration, pictures=pictures
        )
    return trials


def words(trial: ThreatTrial) -> str:
    """What came of one that failed."""
    if trial.false_s:
        return f"a false `warning` at {trial.false_s[0]:.2f} s"
    if trial.window is None or trial.warned_s is None:
        return "no `warning`"
    return f"{trial.warned_s - trial.window.latest_s:.2f} s late"


if __name__ == "__main__":
    main()
