"""The plots say what the log says: values are read back from the SVG."""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from review_drives import (
    ADVISORY_S,
    CAUTION_S,
    DURATION_S,
    FRAMES,
    NEAR_MISS_S,
    RATE_HZ,
    WARNING_END_S,
    WARNING_S,
)

from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.time.axis import TimeAxis
from fcw_viz.review_app.time.plots import PAD_PX, make_plots, plot_places, plots_svg, value_text

SVG = "{http://www.w3.org/2000/svg}"
HEIGHT_PX = 240.0


def drawn(drive: Drive, axis: TimeAxis) -> ET.Element:
    return ET.fromstring(plots_svg(drive, axis, HEIGHT_PX))


def corners(element: ET.Element) -> np.ndarray:
    numbers = re.split(r"[ ,]", element.get("points", ""))
    return np.array(numbers, float).reshape(-1, 2)


def curves(svg: ET.Element, key: str) -> list[np.ndarray]:
    group = svg.find(f"{SVG}g[@data-plot='{key}']")
    assert group is not None
    return [corners(line) for line in group.findall(f"{SVG}polyline[@data-name='curve']")]


def value_of(y: float, bottom: float, top: float, height_px: float) -> float:
    return bottom + (1 - (y - PAD_PX) / (height_px - 2 * PAD_PX)) * (top - bottom)


def places(drive: Drive) -> dict[str, tuple[float, float, float]]:
    """Lower and upper value and height of each plot."""
    plots = make_plots(drive.series, slice(0, FRAMES), False)
    heights = plot_places(plots, HEIGHT_PX)
    return {plot.key: (plot.bottom, plot.top, own) for plot, (_, own) in zip(plots, heights, strict=True)}


@pytest.mark.parametrize(("time_s", "distance_m"), [(2.0, 40.0), (10.0, 22.5), (15.5, 11.0), (20.0, 12.0)])
def test_distance_is_where_its_value_says(drive: Drive, time_s: float, distance_m: float):
    axis = TimeAxis(0.0, drive.duration_s, 900.0)
    (curve,) = curves(drawn(drive, axis), "distance")
    nearest = curve[np.argmin(np.abs(curve[:, 0] - axis.x(time_s)))]
    assert value_of(nearest[1], *places(drive)["distance"]) == pytest.approx(distance_m, abs=0.2)


def test_the_interval_lies_around_the_distance(drive: Drive):
    axis = TimeAxis(0.0, drive.duration_s, 900.0)
    svg = drawn(drive, axis)
    band = svg.find(f"{SVG}g[@data-plot='distance']/{SVG}polygon[@data-name='interval']")
    assert band is not None
    outline = corners(band)
    upper, lower = np.split(outline, 2)
    at = np.argmin(np.abs(upper[:, 0] - axis.x(10.0)))
    place = places(drive)["distance"]
    assert value_of(upper[at][1], *place) == pytest.approx(22.5 * 1.2, abs=0.3)
    assert value_of(lower[::-1][at][1], *place) == pytest.approx(22.5 * 0.9, abs=0.3)


def test_ttc_is_drawn_only_while_it_closes(drive: Drive):
    axis = TimeAxis(0.0, drive.duration_s, 900.0)
    runs = curves(drawn(drive, axis), "ttc")
    spans_s = [(run[0][0] / 900 * drive.duration_s, run[-1][0] / 900 * drive.duration_s) for run in runs]
    expected = [(CAUTION_S, WARNING_END_S - 1 / RATE_HZ), (NEAR_MISS_S, NEAR_MISS_S + 1 - 1 / RATE_HZ)]
    assert np.array(spans_s) == pytest.approx(np.array(expected), abs=0.05)


def test_levels_are_the_ground_of_their_time(drive: Drive):
    axis = TimeAxis(0.0, drive.duration_s, 900.0)
    group = drawn(drive, axis).find(f"{SVG}g[@data-name='levels']")
    assert group is not None
    starts_s = [float(rect.get("x", "")) / 900 * drive.duration_s for rect in group]
    assert starts_s == pytest.approx([CAUTION_S, WARNING_S, ADVISORY_S], abs=0.05)


def test_of_many_rows_on_a_pixel_the_extremes_are_kept(drive: Drive):
    distance_m = np.full(FRAMES, 40.0, np.float32)
    distance_m[301], distance_m[402] = 2.0, 59.0
    spiked = replace(drive, series=replace(drive.series, distance_m=distance_m))
    (curve,) = curves(drawn(spiked, TimeAxis(0.0, drive.duration_s, 100.0)), "distance")
    place = places(drive)["distance"]
    assert value_of(curve[:, 1].max(), *place) == pytest.approx(2.0, abs=0.3)
    assert value_of(curve[:, 1].min(), *place) == pytest.approx(59.0, abs=0.3)


def test_a_window_draws_only_its_rows_and_one_to_each_side(drive: Drive):
    (curve,) = curves(drawn(drive, TimeAxis(4.0, 6.0, 900.0)), "distance")
    assert len(curve) == pytest.approx(2 * RATE_HZ + 3, abs=1)
    assert curve[0][0] <= 0
    assert curve[-1][0] >= 900


def test_imperial_units(drive: Drive):
    distance, closing, *_ = make_plots(drive.series, slice(0, FRAMES), True)
    assert value_text(float(distance.values[0]), distance) == "131 ft"
    assert closing.unit == "mph"


def test_plots_share_the_height(drive: Drive):
    plots = make_plots(drive.series, slice(0, FRAMES), False)
    heights = plot_places(plots, HEIGHT_PX)
    ends = [top + own for top, own in heights]
    assert all(end <= top for end, (top, _) in zip(ends, heights[1:], strict=False))
    assert ends[-1] <= HEIGHT_PX
    assert drive.duration_s < DURATION_S  # the last frame begins a period before the end


def test_the_own_speed_has_its_interval_where_it_was_measured(drive: Drive):
    series = replace(
        drive.series,
        ego_speed_mps=np.full(len(drive.series), 20.0, np.float32),
        ego_speed_sigma_mps=np.full(len(drive.series), 1.0, np.float32),
    )
    own = make_plots(series, slice(0, FRAMES), False)[-1]
    assert own.low is not None
    assert own.high is not None
    assert (own.key, own.unit) == ("own", "km/h")
    assert (own.low[0], own.values[0], own.high[0]) == pytest.approx((68.4, 72.0, 75.6))
    given = replace(series, ego_speed_sigma_mps=np.zeros(len(series), np.float32))
    interval = make_plots(given, slice(0, FRAMES), False)[-1].low
    assert interval is not None
    assert np.isnan(interval).all()
