"""Compile what detectors and renderer need, once, before tests that run side by side all ask for it."""

from fcw.detection.choice import ACF, ACF_FULL, NET, load_model, make_detector
from fcw.simulation.drive import true_calibration
from fcw.simulation.picture.renderer import Renderer
from fcw.simulation.world.scenario import IMAGE_SIZE, load_scenario
from fcw.simulation.world.world import World

scenario = load_scenario("demo")
picture = Renderer(scenario.camera.camera(), IMAGE_SIZE, 0).render(next(iter(World(scenario, 0).states())))
for name in (ACF, ACF_FULL, NET):
    make_detector(name, load_model(name), true_calibration(scenario)).detect(picture)
