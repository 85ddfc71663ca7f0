"""What a click on the picture can mean."""

from enum import Enum


class Tool(Enum):
    """The tool in hand of a tab."""

    POINTS = "points"
    LANE_LINES = "lane lines"
    HORIZON = "horizon"
    EDGE = "edge"
    CORNERS = "corners"
    MEASURE = "measure"
