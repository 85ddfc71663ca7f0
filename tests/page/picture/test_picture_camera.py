"""A picture stays whole when the window changes, also while the browser has yet to hear that it should be."""

from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np

from fcw.frame import ImageSize
from fcw_viz.page.picture.camera import PictureCamera

BEFORE = np.array([3.0, 3.0, 3.0])
"""Where viser's camera begins."""


def test_a_fit_counts_until_the_browser_is_there_and_somebody_slides():
    seen = SimpleNamespace(position=BEFORE, image_width=768, image_height=1024, aspect=0.75)
    client: Any = SimpleNamespace(camera=seen, atomic=nullcontext)
    camera = PictureCamera(client, ImageSize(1280, 720))
    assert not camera.is_fitted(BEFORE)  # nobody asked for it

    camera.fit()
    fitted = np.array(seen.position)
    # The window changes before the browser has heard of the fit, and once more.
    assert camera.is_fitted(BEFORE)
    assert camera.is_fitted(BEFORE)
    assert camera.is_fitted(fitted)
    assert not camera.is_fitted(fitted + np.array([0.1, 0.0, 0.0]))
    assert camera.is_fitted(fitted)
