"""`fcw evaluate warning --kitti-tracking`: every `warning` on real drives, with one seed or more."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

    from fcw.evaluation.warning.false_alarms import Episode
    from fcw.warning.types import WarningPolicy


def evaluate_real_drives(
    folder: Path,
    make_policy: "Callable[[], WarningPolicy]",
    box_noise_px: float,
    seeds: range,
    with_own_motion: bool,
    own_speed_known: bool,
    console: "Console",
) -> dict[str, Any]:
    """Print and return the episodes of `warning` on the drives of KITTI tracking, seed by seed."""
    from fcw.evaluation.distance.kitti_tracking import sequence_names
    from fcw.evaluation.warning.false_alarms import kitti_episodes
    from fcw_viz.console import progress

    names = sequence_names(folder)
    found: list[tuple[int, Episode]] = []
    hours = 0.0
    with progress("drives", len(names) * len(seeds)) as bar:
        for seed in seeds:
            for name in names:
                episodes, driven_h = kitti_episodes(
                    folder,
                    [name],
                    make_policy,
                    box_noise_px,
                    seed,
                    with_own_motion=with_own_motion,
                    own_speed_known=own_speed_known,
                )
                found += [(seed, episode) for episode in episodes]
                hours += driven_h
                bar.advance()
    print_episodes(found, seeds, hours, console)
    by_seed = {seed: [episode for of_seed, episode in found if of_seed == seed] for seed in seeds}
    on_course = sum(episode.on_course for _, episode in found)
    return {
        "episodes": [
            {"seed": seed} | asdict(episode) | {"on_course": episode.on_course} for seed, episode in found
        ],
        "seeds": [
            {
                "seed": seed,
                "episodes": len(episodes),
                "on_course": sum(episode.on_course for episode in episodes),
            }
            for seed, episodes in by_seed.items()
        ],
        "on_course": on_course,
        "warnings_per_hour": len(found) / hours,
        "false_alarms": len(found) - on_course,
    }


def print_episodes(
    found: "Sequence[tuple[int, Episode]]", seeds: range, hours: float, console: "Console"
) -> None:
    """Print what was warned of on real drives, with the seed of each run."""
    from rich.table import Table

    from fcw.units import STANDARD_GRAVITY_MPS2

    def text(value: float | None, pattern: str) -> str:
        return "-" if value is None else format(value, pattern)

    table = Table(
        "seed", "drive", "s", "own m/s", "vehicle", "m", "TTC s", "needs g", "misses by m", box=None
    )
    for seed, episode in found:
        needed_mps2 = episode.required_mps2
        table.add_row(
            str(seed),
            episode.sequence,
            f"{episode.start_s:.1f}-{episode.end_s:.1f}",
            f"{episode.own_mps:.1f}",
            (episode.vehicle or "none labelled") + (" oncoming" if episode.oncoming else ""),
            text(episode.distance_m, ".1f"),
            text(episode.ttc_s, ".1f"),
            text(None if needed_mps2 is None else needed_mps2 / STANDARD_GRAVITY_MPS2, ".2f"),
            text(episode.miss_m, ".1f"),
        )
    console.print(table)
    if len(seeds) > 1:
        counts = Table("seed", "episodes", "on a collision course", box=None)
        for seed in seeds:
            of_seed = [episode for its_seed, episode in found if its_seed == seed]
            counts.add_row(str(seed), str(len(of_seed)), str(sum(episode.on_course for episode in of_seed)))
        console.print(counts)
    console.print(
        f"{len(found)} episodes of `warning` in {hours * 60:.1f} minutes, true figures at their start; "
        f"{sum(episode.on_course for _, episode in found)} of them on a collision course; "
        f"{len(found) / hours:.0f} per hour",
        highlight=False,
    )
