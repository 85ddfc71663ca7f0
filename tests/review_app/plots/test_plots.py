"""The plots say what the log says: values are read back from the SVG."""

import json
import math
import re
import threading
import xml.etree.ElementTree as ET
from dataclasses import fields, replace

import numpy as np
import pytest
from review_drives import (
    ADVISORY_S,
    BOX,
    CAUTION_S,
    FRAMES,
    NEAR_MISS_S,
    OTHER_BOX,
    RATE_HZ,
    WARNING_END_S,
    WARNING_S,
)

from fcw.errors import UserError
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.plots.area import figures_html
from fcw_viz.review_app.plots.choice import PlotChoice
from fcw_viz.review_app.plots.drawing import PAD_PX, plots_svg
from fcw_viz.review_app.plots.plot import make_plots, plot_places, readout
from fcw_viz.review_app.plots.quantities import Span, ticks
from fcw_viz.review_app.plots.signals import (
    AHEAD,
    DEFAULT,
    LIVE,
    MOST_PLOTS,
    OWN,
    VEHICLE_SIGNALS,
    Chosen,
    chosen_text,
    in_series,
    parse_chosen,
    signals_of,
)
from fcw_viz.review_app.plots.values import BLOCK_ROWS, FrameSignals, Run
from fcw_viz.review_app.time.axis import TimeAxis

SVG = "{http://www.w3.org/2000/svg}"
HEIGHT_PX = 240.0
ALL_OF_VEHICLE = [one.key for one in VEHICLE_SIGNALS]


def whole(drive: Drive) -> TimeAxis:
    return TimeAxis(0.0, drive.duration_s, 900.0)


def drawn(drive: Drive, axis: TimeAxis) -> ET.Element:
    runs = [Run.of(drive, axis.start_s, axis.end_s)]
    return ET.fromstring(plots_svg(make_plots(runs, LIVE, False), runs, axis, HEIGHT_PX))


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
    plots = make_plots([Run.of(drive, 0.0, drive.duration_s)], LIVE, False)
    heights = plot_places(plots, HEIGHT_PX)
    return {
        plot.signal.key: (plot.bottom, plot.top, own) for plot, (_, own) in zip(plots, heights, strict=True)
    }


@pytest.mark.parametrize(("time_s", "distance_m"), [(2.0, 40.0), (10.0, 22.5), (15.5, 11.0), (20.0, 12.0)])
def test_distance_is_where_its_value_says(drive: Drive, time_s: float, distance_m: float):
    axis = whole(drive)
    (curve,) = curves(drawn(drive, axis), "distance")
    nearest = curve[np.argmin(np.abs(curve[:, 0] - axis.x(time_s)))]
    assert value_of(nearest[1], *places(drive)["distance"]) == pytest.approx(distance_m, abs=0.2)


def test_the_interval_lies_around_the_distance(drive: Drive):
    axis = whole(drive)
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
    axis = whole(drive)
    runs = curves(drawn(drive, axis), "ttc")
    spans_s = [(run[0][0] / 900 * drive.duration_s, run[-1][0] / 900 * drive.duration_s) for run in runs]
    expected = [(CAUTION_S, WARNING_END_S - 1 / RATE_HZ), (NEAR_MISS_S, NEAR_MISS_S + 1 - 1 / RATE_HZ)]
    assert np.array(spans_s) == pytest.approx(np.array(expected), abs=0.05)


def test_a_curve_above_the_axis_is_told_in_words_where_it_would_be(drive: Drive):
    axis = whole(drive)
    # 40 m ahead at 4 m/s; at 1 m/s for as long as words do not fit.
    speed_mps = np.full(FRAMES, 20.0, np.float32)
    speed_mps[: 6 * RATE_HZ] = 4.0
    speed_mps[7 * RATE_HZ : 8 * RATE_HZ] = 4.0
    slow = replace(drive, series=replace(drive.series, ego_speed_mps=speed_mps, headway_s=40.0 / speed_mps))
    group = drawn(slow, axis).find(f"{SVG}g[@data-plot='headway']")
    assert group is not None
    said = group.findall(f"{SVG}g[@data-name='beyond']/{SVG}text")
    assert [text.text for text in said] == ["over 4.0 s"]
    assert float(said[0].get("x", "")) == pytest.approx(axis.x(3.0), abs=1.0)
    assert drawn(drive, axis).find(f".//{SVG}g[@data-name='beyond']") is None


def test_levels_are_the_ground_of_their_time(drive: Drive):
    axis = whole(drive)
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


def test_every_axis_names_round_values_that_hold_the_curve(drive: Drive):
    svg = drawn(drive, whole(drive))
    for key, (bottom, top, height_px) in places(drive).items():
        group = svg.find(f"{SVG}g[@data-plot='{key}']")
        assert group is not None
        texts = group.findall(f"{SVG}g[@data-name='tick']/{SVG}text")
        values = [float((text.text or "").replace("−", "-")) for text in texts]
        assert len(values) >= 2
        assert all(bottom <= value <= top for value in values)
        for text, value in zip(texts, values, strict=True):
            # The words stand a little below their line, and inside the plot.
            y = float(text.get("y", "")) - 3.5
            assert value_of(y, bottom, top, height_px) == pytest.approx(value, abs=0.25 * (top - bottom))


@pytest.mark.parametrize(
    ("values", "expected"),
    [([3.0, 41.0], (0.0, 60.0, 20.0)), ([-3.2, 9.0], (-5.0, 10.0, 5.0)), ([], (0.0, 1.0, 0.25))],
)
def test_an_axis_ends_on_round_values(values: list[float], expected: tuple[float, float, float]):
    assert Span(high=None if values else 1.0).axis([np.array(values)], 1.0) == pytest.approx(expected)


@pytest.mark.parametrize("values", [[], [math.nan], [0.0, 0.0]])
def test_without_values_an_axis_still_begins_at_zero(values: list[float]):
    assert Span().axis([np.array(values)], 3.6) == pytest.approx((0.0, 1.0, 0.25))


def test_of_many_values_those_that_have_room_are_named():
    assert ticks(0.0, 40.0, 10.0, 6) == [0.0, 10.0, 20.0, 30.0, 40.0]
    assert ticks(0.0, 40.0, 10.0, 3) == [0.0, 20.0, 40.0]
    assert ticks(-20.0, 30.0, 10.0, 4) == [-20.0, 0.0, 20.0]
    assert ticks(1.0, 4.0, 1.0, 1) == [1.0, 4.0]


def without(drive: Drive, rows: slice) -> Drive:
    """The drive with some frames missing."""
    kept = np.delete(np.arange(FRAMES), rows)
    of_frames = {
        field.name: getattr(drive.series, field.name)[kept]
        for field in fields(drive.series)
        if len(getattr(drive.series, field.name)) == FRAMES
    }
    return replace(drive, series=replace(drive.series, **of_frames))


def distance_without(drive: Drive, rows: slice, axis: TimeAxis) -> list[np.ndarray]:
    """The curves of the distance where some frames are missing."""
    runs = [Run.of(without(drive, rows), axis.start_s, axis.end_s)]
    plots = make_plots(runs, [Chosen("distance", AHEAD)], False)
    return curves(ET.fromstring(plots_svg(plots, runs, axis, HEIGHT_PX)), "distance")


def test_frames_that_a_live_drive_skips_do_not_make_dashes_of_its_curves(drive: Drive):
    skipped = slice(100, 100 + round(0.4 * RATE_HZ))
    assert len(distance_without(drive, skipped, TimeAxis(0.0, 8.0, 900.0))) == 1


def test_a_gap_in_time_is_a_gap_of_the_curve(drive: Drive):
    axis = TimeAxis(0.0, 8.0, 900.0)
    before, after = distance_without(drive, slice(100, 150), axis)
    assert before[-1][0] == pytest.approx(axis.x(99 / RATE_HZ), abs=0.1)
    assert after[0][0] == pytest.approx(axis.x(150 / RATE_HZ), abs=0.1)


@pytest.mark.parametrize("start_s", [0.0, 10.0])
def test_a_run_that_has_ended_has_no_value_any_more(drive: Drive, start_s: float):
    end_s, axis = 4.0, TimeAxis(start_s, start_s + 10.0, 900.0)
    short = without(drive, slice(round(end_s * RATE_HZ) + 1, FRAMES))
    runs = [Run.of(one, axis.start_s, axis.end_s, name=name) for name, one in (("a", drive), ("b", short))]
    plots = make_plots(runs, [Chosen("distance", AHEAD)], False)

    def figures(time_s: float) -> list[str]:
        return re.findall("<b>(.*?)</b>", figures_html(plots, time_s, 190.0, 0.0, HEIGHT_PX))

    assert figures(start_s + 8.0)[1] == "–"
    _, ended = json.loads(readout(plots, axis))
    last = int(np.searchsorted(ended["times_s"], start_s + 8.0, side="right")) - 1
    assert ended["curves"][0]["values"][last] == ""
    if start_s < end_s:
        assert figures(end_s) == ["40.0 m", "40.0 m"]


def test_imperial_units(drive: Drive):
    plots = make_plots([Run.of(drive, 0.0, 1.0)], DEFAULT, True)
    distance, closing, _ = plots
    assert distance.text(float(distance.curves[0].told.value[0])) == "131 ft"
    assert closing.unit == "mph"


def test_plots_share_the_height(drive: Drive):
    plots = make_plots([Run.of(drive, 0.0, drive.duration_s)], LIVE, False)
    heights = plot_places(plots, HEIGHT_PX)
    ends = [top + own for top, own in heights]
    assert all(end <= top for end, (top, _) in zip(ends, heights[1:], strict=False))
    assert ends[-1] <= HEIGHT_PX


def test_the_own_speed_has_its_interval_where_it_was_measured(drive: Drive):
    series = replace(
        drive.series,
        ego_speed_mps=np.full(len(drive.series), 20.0, np.float32),
        ego_speed_sigma_mps=np.full(len(drive.series), 1.0, np.float32),
    )

    def own_speed(drive: Drive) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        (plot,) = make_plots([Run.of(drive, 0.0, 1.0)], [Chosen("own_speed", OWN)], False)
        told = plot.curves[0].told
        assert told.low is not None
        assert told.high is not None
        return told.low, told.value, told.high

    low, value, high = own_speed(replace(drive, series=series))
    assert (low[0], value[0], high[0]) == pytest.approx((68.4, 72.0, 75.6))
    given = replace(series, ego_speed_sigma_mps=np.zeros(len(series), np.float32))
    assert np.isnan(own_speed(replace(drive, series=given))[0]).all()


def read_frames(drive: Drive, before: FrameSignals | None = None) -> FrameSignals:
    """All of a drive's signals."""
    came = threading.Event()
    signals = FrameSignals(drive.log, lambda: None if signals.reading else came.set(), before)
    signals.want(slice(0, len(drive.series)))
    if not signals.reading:
        came.set()
    assert came.wait(60)
    signals.close()
    return signals


def test_signals_of_the_frames_are_those_of_the_columns_where_both_have_them(drive: Drive):
    signals = read_frames(drive)
    run = Run.of(drive, 0.0, drive.duration_s, signals)
    for subject in (AHEAD, OWN):
        for signal in signals_of(subject):
            chosen = Chosen(signal.key, subject)
            if in_series(chosen):
                np.testing.assert_allclose(
                    signals.values(run.rows, chosen).value, run.values(chosen).value, rtol=1e-6
                )


def test_a_vehicle_has_its_signals_while_it_is_followed(drive: Drive):
    run = Run.of(drive, 0.0, drive.duration_s, read_frames(drive))
    assert len(run.times_s) > 2 * BLOCK_ROWS
    near_miss = (run.times_s >= NEAR_MISS_S - 1e-6) & (run.times_s < NEAR_MISS_S + 1 - 1e-6)
    heights = run.values(Chosen("box_height", "9")).value
    np.testing.assert_array_equal(np.isfinite(heights), near_miss)
    assert set(heights[near_miss]) == {BOX.h}
    assert set(run.values(Chosen("box_height", "2")).value) == {OTHER_BOX.h}
    assert set(run.values(Chosen("vehicles", OWN)).value) == {2.0}
    distance = run.values(Chosen("distance", "2"))
    assert distance.high is not None
    assert np.isposinf(distance.high).all()


def test_a_part_in_the_middle_of_a_block_has_its_own_values(drive: Drive):
    signals = read_frames(drive)
    rows = slice(BLOCK_ROWS - 10, BLOCK_ROWS + 10)
    all_of_it = signals.values(slice(0, len(drive.series)), Chosen("distance", AHEAD)).value
    part = signals.values(rows, Chosen("distance", AHEAD)).value
    np.testing.assert_array_equal(part, all_of_it[rows])


def test_what_was_read_of_a_growing_drive_is_kept(drive: Drive):
    signals = read_frames(drive)
    again = FrameSignals(drive.log, lambda: None, signals)
    again.want(slice(0, BLOCK_ROWS))
    assert not again.reading


def test_curves_are_chosen_and_taken_away():
    choice = PlotChoice()
    assert choice.chosen == DEFAULT
    choice.switch("score 7")
    choice.switch("ttc ahead")
    assert choice.chosen == (*DEFAULT[:2], Chosen("score", "7"))
    assert parse_chosen(chosen_text(choice.chosen)) == choice.chosen
    assert choice.kept_text() == "distance ahead,closing ahead"
    choice.leave_drive()
    assert choice.chosen == DEFAULT[:2]
    choice.switch("no such,score own,distance 7x")
    assert choice.chosen == DEFAULT[:2]


def test_more_plots_than_can_be_read_are_refused_but_not_curves_in_them():
    choice = PlotChoice()
    choice.take_all(",".join(f"{key} ahead" for key in ALL_OF_VEHICLE[:MOST_PLOTS]))
    with pytest.raises(UserError, match="remove one first"):
        choice.switch(f"{ALL_OF_VEHICLE[MOST_PLOTS]} ahead")
    choice.switch("distance 7")
    assert len(choice.chosen) == MOST_PLOTS + 1


def test_curves_of_one_signal_share_a_plot(drive: Drive):
    chosen = [Chosen("distance", AHEAD), Chosen("ttc", AHEAD), Chosen("distance", "2")]
    plots = make_plots([Run.of(drive, 0.0, 4.0, read_frames(drive))], chosen, False)
    assert [(plot.title, len(plot.curves)) for plot in plots] == [("Distance", 2), ("Time to collision", 1)]
    assert plots[0].curves[0].color != plots[0].curves[1].color


def test_the_readout_holds_the_values_that_the_axis_leaves_out(drive: Drive):
    ttc_s = np.where(drive.series.warned_id >= 0, np.float32(37.0), np.float32(np.nan))
    slow = replace(drive, series=replace(drive.series, warned_ttc_s=ttc_s))
    axis = whole(drive)
    plots = make_plots([Run.of(slow, axis.start_s, axis.end_s)], [Chosen("ttc", AHEAD)], False)
    assert np.isnan(plots[0].curves[0].drawn.value[row_at := round(10 * RATE_HZ)])
    (run,) = json.loads(readout(plots, axis))
    assert run["times_s"][row_at] == 10.0
    assert run["curves"][0]["values"][row_at] == "37.0"
    assert run["curves"][0]["values"][0] == ""
