"""Where the pixels of one picture lie in another of the same camera: the same scaled, or a part of it."""

from dataclasses import dataclass

from fcw.frame import ImageSize


@dataclass(frozen=True, slots=True)
class PixelMap:
    """From a picture to one that was scaled, and then cut, or the other way round.

    Attributes:
        size: of the other picture.
        across: columns of the other picture for one of this picture.
        down: rows likewise.
        left_px: column of the scaled picture at which the other one begins; negative where it is larger.
        top_px: row likewise.
    """

    size: ImageSize
    across: float = 1.0
    down: float = 1.0
    left_px: int = 0
    top_px: int = 0

    def column(self, column_px: float) -> float:
        """A column in the other picture; columns and rows are those of the middles of pixels."""
        return (column_px + 0.5) * self.across - 0.5 - self.left_px

    def row(self, row_px: float) -> float:
        """A row likewise."""
        return (row_px + 0.5) * self.down - 0.5 - self.top_px

    def places(self, places_px: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        """Columns and rows likewise."""
        return tuple((self.column(column_px), self.row(row_px)) for column_px, row_px in places_px)

    def back(self, size: ImageSize) -> "PixelMap":
        """From the other picture to this one of a size, where nothing was scaled."""
        return PixelMap(size, left_px=-self.left_px, top_px=-self.top_px)
