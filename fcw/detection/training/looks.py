"""How pictures may look otherwise: other light, weather and cameras than those of the training pictures.

Windows of vehicles and whole pictures that are mined for background are varied alike: trees must not learn
that what looks otherwise is a vehicle.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Looks:
    """How far pictures are varied.

    Attributes:
        gamma: largest logarithm of the exponent applied to the brightness.
        colour_gain: largest logarithm of the factor of a colour channel.
        recoloured_part: part of the pictures whose saturation and hue change.
        grey_part: part of the pictures without any colour, as some cameras and many nights give them.
        hue_rad: largest turn of the hue.
        hazy_part: part of the pictures in haze.
        clearest: least part of the light that haze lets through.
        dark_part: part of the pictures at dusk: darkened by up to `darkest`.
        darkest: least brightness of those, as a part.
        noisy_part: part of the pictures with the noise of a small camera in little light.
        noise: largest standard deviation of that, of 255 counts.
    """

    gamma: float = 0.4
    colour_gain: float = 0.08
    recoloured_part: float = 0.4
    grey_part: float = 0.15
    hue_rad: float = 0.3
    hazy_part: float = 0.2
    clearest: float = 0.3
    dark_part: float = 0.2
    darkest: float = 0.25
    noisy_part: float = 0.2
    noise: float = 7.0


BRIGHTNESS = Looks(
    gamma=0.3,
    colour_gain=0.05,
    recoloured_part=0.0,
    grey_part=0.0,
    hazy_part=0.0,
    dark_part=0.0,
    noisy_part=0.0,
)
"""Other exposures and white balances alone: for trees that learn from pictures as they are."""


def vary_looks(picture: NDArray[np.uint8], looks: Looks, random: np.random.Generator) -> NDArray[np.uint8]:
    """A (height, width, 3) BGR picture as another camera might have seen it on another day."""
    grey = random.uniform() < looks.grey_part
    if grey or random.uniform() < looks.recoloured_part:
        saturation = 0.0 if grey else random.uniform(0.2, 1.4)
        turn = random.uniform(-looks.hue_rad, looks.hue_rad)
        picture = np.asarray(cv2.transform(picture, _colour_matrix(saturation, turn)), np.uint8)
    exponent = math.exp(random.uniform(-looks.gamma, looks.gamma))
    gains = np.exp(random.uniform(-looks.colour_gain, looks.colour_gain, 3))
    levels = (np.arange(256) / 255.0) ** exponent
    levels = levels[:, None] * (gains.mean() if grey else gains)
    if random.uniform() < looks.hazy_part:
        clear, air = random.uniform(looks.clearest, 1.0), random.uniform(0.4, 1.0)
        levels = clear * levels + (1.0 - clear) * air
    if random.uniform() < looks.dark_part:
        levels = levels ** random.uniform(1.0, 1.6) * random.uniform(looks.darkest, 1.0)
    table = np.rint(255.0 * np.clip(levels, 0.0, 1.0)).astype(np.uint8)
    picture = np.asarray(cv2.LUT(picture, table[None]), np.uint8)
    if random.uniform() < looks.noisy_part:
        sigma = random.uniform(0.0, looks.noise)
        noise = np.empty(picture.shape, np.int16)
        cv2.setRNGSeed(int(random.integers(2**31)))
        cv2.randn(noise, np.zeros(3), np.full(3, sigma))
        picture = np.asarray(cv2.add(picture, noise, dtype=cv2.CV_8U), np.uint8)
    return picture


def _colour_matrix(saturation: float, turn_rad: float) -> NDArray[np.float64]:
    """(3, 3), about the axis of greys: colours stretched by a factor and turned by an angle."""
    axis = np.ones(3) / math.sqrt(3.0)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    grey = np.full((3, 3), 1.0 / 3.0)
    colour = (np.eye(3) - grey) * math.cos(turn_rad) + cross * math.sin(turn_rad)
    return grey + saturation * colour
