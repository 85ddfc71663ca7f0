"""Maps the pixels of a picture to a scaled picture, or to a part of it."""

from dataclasses import dataclass

from fcw.frame import ImageSize


@dataclass(frozen=True, slots=True)
class PixelMap:
    """A map from a picture to another one that was scaled and then cut, or the other way round.

    Attributes:
        size: size of the other picture.
        across: columns of the other picture for one column of this picture.
        down: rows of the other picture for one row of this picture.
        left_px: column of the scaled picture at which the other one begins; negative if that is wider.
        top_px: row of the scaled picture at which the other one begins; negative if that is higher.
    """

    size: ImageSize
    across: float = 1.0
    down: float = 1.0
    left_px: int = 0
    top_px: int = 0

    def column(self, column_px: float) -> float:
        """A column in the other picture; whole numbers are the middles of pixels."""
        return (column_px + 0.5) * self.across - 0.5 - self.left_px

    def row(self, row_px: float) -> float:
        """A row in the other picture."""
        return (row_px + 0.5) * self.down - 0.5 - self.top_px

    def places(self, places_px: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        """Columns and rows in the other picture."""
        return tuple((self.column(column_px), self.row(row_px)) for column_px, row_px in places_px)

    def back(self, size: ImageSize) -> "PixelMap":
        """The map back to this picture, whose size is given, if nothing was scaled."""
        return PixelMap(size, left_px=-self.left_px, top_px=-self.top_px)
