"""Edits of the number plates of vehicles ahead: two ends and a tyre of each, clicked in turn."""

import math
from dataclasses import dataclass, replace

from fcw.camera.calibration import Gaussian
from fcw.camera.joint.plates import NARROWEST_M, NARROWEST_PX, PLACES, WIDEST_M
from fcw.errors import UserError
from fcw_viz.calibrate_app.document.besides.rectangles import place_in_picture
from fcw_viz.calibrate_app.document.document import Document


@dataclass(frozen=True, slots=True)
class AddPlatePlace:
    """A click: an end of a plate, its other end, a tyre of its vehicle; then the same of the next plate."""

    column_px: float
    row_px: float

    def apply(self, document: Document) -> Document:
        """The document with it.

        Raises:
            UserError: it is no place in the picture, or that of the first end again.
        """
        place, plates = place_in_picture(document, self.column_px, self.row_px), document.plates
        if not plates or len(plates[-1]) == PLACES:
            return replace(document, plates=(*plates, (place,)))
        if len(plates[-1]) == 1 and math.dist(place, plates[-1][0]) < NARROWEST_PX:
            raise UserError("that end of the plate is clicked already; click the other one")
        return replace(document, plates=(*plates[:-1], (*plates[-1], place)))


@dataclass(frozen=True, slots=True)
class MovePlatePlace:
    """One of them dragged."""

    plate: int
    place: int
    column_px: float
    row_px: float

    def apply(self, document: Document) -> Document:
        """The document with it elsewhere.

        Raises:
            UserError: it is gone, or no place in the picture.
        """
        if not (
            0 <= self.plate < len(document.plates) and 0 <= self.place < len(document.plates[self.plate])
        ):
            raise UserError("that plate is gone; it was removed in the meantime")
        places = list(document.plates[self.plate])
        places[self.place] = place_in_picture(document, self.column_px, self.row_px)
        plates = list(document.plates)
        plates[self.plate] = tuple(places)
        return replace(document, plates=tuple(plates))


@dataclass(frozen=True, slots=True)
class SetPlateWidth:
    """The width of all plates, by their country or measured."""

    width_m: Gaussian

    def apply(self, document: Document) -> Document:
        """The document with that width.

        Raises:
            UserError: no plate is so wide.
        """
        value, sigma = self.width_m.value, self.width_m.sigma
        if not (NARROWEST_M <= value <= WIDEST_M and 0 < sigma < math.inf):
            raise UserError(
                f"width of a number plate {value:g} ± {sigma:g} m: expected {NARROWEST_M:g} to "
                f"{WIDEST_M:g} m, and an error above 0"
            )
        return replace(document, plate_width_m=self.width_m)


@dataclass(frozen=True, slots=True)
class RemovePlate:
    """The plate clicked last taken away."""

    def apply(self, document: Document) -> Document:
        """The document without it."""
        return replace(document, plates=document.plates[:-1])


PlateEdit = AddPlatePlace | MovePlatePlace | SetPlateWidth | RemovePlate
