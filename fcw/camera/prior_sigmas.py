"""How well a camera is known before any click, where nobody says how well: standard deviations."""

FIELD_OF_VIEW_SIGMA_DEG = 3.0
"""Data sheets round, state the diagonal, or ignore what stabilisation crops."""
PRINCIPAL_ROW_SIGMA_HEIGHTS = 0.03
"""How far lens and sensor are off centre in ordinary cameras, in picture heights."""
HORIZON_ROW_SIGMA_PX = 2.0
"""How well a horizon is dragged by eye, and how well two straight lane lines extended by eye meet."""
