"""Pictures of the simulated world: numpy, OpenCV and a few compiled loops, no GPU.

A picture is painted from far to near: sky and hills, the ground with its shadows, then everything upright in
the order of its distance; the lens comes last.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.simulation.picture.lens import Lens
from fcw.simulation.picture.light import Daylight
from fcw.simulation.picture.on_glass import paint_on_glass
from fcw.simulation.picture.road.roadside import RoadsidePainter
from fcw.simulation.picture.road.surface import Ground
from fcw.simulation.picture.sky import Sky
from fcw.simulation.picture.vehicles.painter import FARTHEST_M, VehiclePainter
from fcw.simulation.picture.view import View
from fcw.simulation.world.state import WorldState


class Renderer:
    """Renders one drive; the same seed and state give the same picture, bit for bit.

    Textures are kept between pictures: use one renderer for each thread.

    Args:
        camera: as calibrated; its deviations come with each state.
        image_size: of the pictures.
        on_glass: what the camera sees of its own car, see `fcw.simulation.picture.on_glass`.
        world_seed: of light, surfaces, sky and noise.
    """

    def __init__(
        self,
        camera: GroundPlaneCamera,
        image_size: ImageSize,
        world_seed: int,
        on_glass: Sequence[str] = (),
    ) -> None:
        self._on_glass = on_glass
        self._camera, self._size, self._seed = camera, image_size, world_seed
        streams = np.random.SeedSequence(world_seed).spawn(5)
        light, ground, sky, roadside, lens = (np.random.default_rng(stream) for stream in streams)
        self.light = Daylight.drawn(light)
        self._ground = Ground(camera, ground, self.light)
        self._sky = Sky(camera, sky, self.light)
        self._roadside = RoadsidePainter(roadside, self.light, world_seed)
        self._vehicles = VehiclePainter(self.light)
        self._lens = Lens(image_size, lens)

    def render(self, state: WorldState) -> NDArray[np.uint8]:
        """The picture of an instant: (height, width, 3) uint8 BGR."""
        image = np.empty((self._size.height, self._size.width, 3), np.float32)
        view = View(image, state, self._camera, self.light)
        ego = state.ego
        heading_rad = float(state.road.heading_at(ego.s_m)) + ego.heading_rad
        # On a grade the level horizon is not where the road's plane has its own.
        level_row_px = view.camera.horizon_row_px + self._camera.focal_y_px * float(
            state.road.grade_at(ego.s_m)
        )
        self._sky.paint(image, level_row_px, heading_rad)
        self._ground.paint(image, state, view.camera)
        items = self._roadside.visible(state)
        vehicles = [
            vehicle
            for vehicle in state.vehicles
            if vehicle.s_m + vehicle.size.length_m > ego.s_m and vehicle.s_m - ego.s_m < FARTHEST_M
        ]
        self._roadside.paint_shadows(view, items)
        for vehicle in vehicles:
            self._vehicles.paint_shadows(view, vehicle)
        jobs = list(self._roadside.jobs(view, items, vehicles))
        for vehicle in vehicles:
            shaded = self._roadside.shaded_by_bridge(items, vehicle.s_m)
            jobs.append((vehicle.s_m - ego.s_m, lambda v=vehicle, s=shaded: self._vehicles.paint(view, v, s)))
        for _, paint in sorted(jobs, key=lambda job: -job[0]):
            paint()
        paint_on_glass(image, self._on_glass)
        return self._lens.expose(image, (self._seed * 1_000_003 + state.time_ns) % 2**63)
