"""How well a camera is known before any click, where nobody says how well: standard deviations.

From data sheets and the cameras of the data (KITTI, TuSimple, Udacity), not from any calibration's error.
"""

import math

FIELD_OF_VIEW_SIGMA_DEG = 3.0
"""Data sheets round, state the diagonal, or ignore what stabilisation crops."""
PRINCIPAL_ROW_SIGMA_HEIGHTS = 0.03
"""How far lens and sensor are off centre in ordinary cameras, in picture heights."""
USUAL_FIELD_OF_VIEW_DEG, USUAL_FIELD_OF_VIEW_SIGMA_DEG = 75.0, 25.0
"""Horizontal, of any camera that somebody puts behind a windscreen; telephones and cropped pictures see 45
degrees, wide dash cameras 110 once they are rectilinear."""
ROLL_SIGMA_RAD = math.radians(1.5)
"""Of a camera that somebody mounted as level as the eye can."""
TAPE_ERROR = 0.01
"""Of taped distances, all together, as a part of them: the tape sags, or lies askew."""
HORIZON_ROW_SIGMA_PX = 2.0
"""How well a horizon is dragged by eye, and how well two straight lane lines extended by eye meet."""
