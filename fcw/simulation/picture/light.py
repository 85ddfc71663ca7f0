"""Daylight of a drive: colours of ground, air and sky, drawn once from the seed."""

from dataclasses import dataclass

import numpy as np

from fcw.simulation.picture.canvas import Bgr, mixed

GREEN_GRASS: Bgr = (38, 84, 70)
GOLDEN_GRASS: Bgr = (78, 126, 152)


@dataclass(frozen=True, slots=True)
class Daylight:
    """What the light of a drive makes of things; colours BGR 0 to 255.

    Attributes:
        zenith: sky high above.
        haze: the air, and the sky at the horizon.
        visibility_m: contrast falls to 1/e over this distance.
        cloudiness: 0 for a clear sky, 1 for an overcast one.
        rear_light: brightness of what faces us against the ground: low with the sun ahead.
        shadow: how much of the light a shadow takes.
        shadow_lateral: where shadows fall, in heights of what casts them, positive to the left.
        shadow_along: the same along the road, positive away from us.
        asphalt: of new to worn asphalt.
        gravel: beside the asphalt.
        grass: where it is fresh.
        dry_grass: where it is not.
        foliage: of trees.
        paint: of markings.
    """

    zenith: Bgr
    haze: Bgr
    visibility_m: float
    cloudiness: float
    rear_light: float
    shadow: float
    shadow_lateral: float
    shadow_along: float
    asphalt: Bgr
    gravel: Bgr
    grass: Bgr
    dry_grass: Bgr
    foliage: Bgr
    paint: Bgr

    @classmethod
    def drawn(cls, generator: np.random.Generator) -> "Daylight":
        """The light of a drive."""

        def between(low: float, high: float) -> float:
            return float(generator.uniform(low, high))

        cloudiness = between(0.0, 1.0) ** 2.2
        grey = between(66, 104)
        dryness = between(0.0, 0.8)
        sky = mixed((186, 122, 66), (190, 180, 170), cloudiness)
        ahead = between(-0.7, 0.7) * (1 - cloudiness)
        return cls(
            zenith=sky,
            haze=mixed((222, 206, 190), (212, 210, 206), cloudiness),
            visibility_m=between(500, 1100),
            cloudiness=cloudiness,
            rear_light=0.92 + 0.22 * ahead,
            shadow=0.62 - 0.35 * cloudiness,
            shadow_lateral=between(-1.0, 1.0),
            shadow_along=ahead,
            asphalt=(grey * 1.02, grey, grey * between(0.96, 1.0)),
            gravel=(grey * 1.15, grey * 1.28, grey * 1.36),
            grass=mixed(GREEN_GRASS, GOLDEN_GRASS, dryness),
            dry_grass=mixed(GREEN_GRASS, GOLDEN_GRASS, min(dryness + 0.35, 1.0)),
            foliage=mixed((30, 62, 48), (40, 84, 66), between(0.0, 1.0)),
            paint=(214, 218, 220),
        )
