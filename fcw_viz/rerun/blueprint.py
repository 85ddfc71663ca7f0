"""Where everything stands in the rerun recording of a drive, and how the viewer lays it out.

Entities (all paths below the root, without a leading slash):

====================================  ========================================================
`frames`                              one row for each shown frame: its index, time and warning
`world/ego`                           vehicle axes of ISO 8855, origin on the road at the reference
`world/ego/vehicles`                  a box for each track, and a line for the lead's distance interval
`world/ego/path`, `.../distances`     the road ahead: own path and lines at fixed distances
`world/ego/camera`                    pose of the camera; `.../image` its pinhole
`world/ego/camera/image/video`        the video, one sample for each packet
`world/ego/camera/image/vehicles`     boxes of the tracks with their words
`world/ego/camera/image/detections`   what the detector gave, not shown at first
`world/ego/camera/image/rows`         rows of fixed distances
`plots/...`                           of the lead vehicle: distance, time to collision, speed
`warning/level`, `warning/log`        the level over time, and its changes in words
`drive`                               source, versions and calibration as a text
====================================  ========================================================
"""

import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint import encodings
from rerun.blueprint.components import AbsoluteTimeRange

FRAMES = "frames"
EGO = "world/ego"
EGO_BODY = "world/ego/body"
PATH = "world/ego/path"
DISTANCES = "world/ego/distances"
VEHICLES = "world/ego/vehicles"
CAMERA = "world/ego/camera"
IMAGE = "world/ego/camera/image"
VIDEO = "world/ego/camera/image/video"
IMAGE_VEHICLES = "world/ego/camera/image/vehicles"
IMAGE_DETECTIONS = "world/ego/camera/image/detections"
IMAGE_ROWS = "world/ego/camera/image/rows"
PLOT_DISTANCE = "plots/distance"
PLOT_TTC = "plots/ttc"
PLOT_SPEED = "plots/speed"
LEVEL = "warning/level"
LOG = "warning/log"
DRIVE = "drive"

FRAME_TIMELINE = "frame"
TIME_TIMELINE = "drive_time"

TTC_AXIS_S = (0.0, 10.0)
"""Beyond ten seconds nobody is warned: the plot keeps its room for what matters."""


class EndingBlueprint(rrb.Blueprint):
    """A blueprint whose own recording can be ended. rerun 0.41 makes one in memory to send a blueprint, and
    keeps it, with its threads, until the process ends."""

    _sent_by: rr.RecordingStream | None = None

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        super()._log_to_stream(stream)
        self._sent_by = stream

    def end(self) -> None:
        """Called once it was sent."""
        if self._sent_by is not None:
            self._sent_by.disconnect()
            self._sent_by = None


def drive_blueprint(imperial: bool = False, played_ns: tuple[int, int] | None = None) -> EndingBlueprint:
    """Camera, ground view, plots and the warnings' log at once; the rest is folded away.

    Every property here costs 3 kB in each file, so only what a person would miss is set.

    Args:
        imperial: whether the plots are in feet and miles per hour.
        played_ns: a part of the drive, on its clock, that is played again and again from the beginning;
            None to stand at the drive's first frame.
    """
    distance_unit, speed_unit = ("ft", "mph") if imperial else ("m", "m/s")
    camera = rrb.Spatial2DView(
        origin=IMAGE,
        contents=["$origin/**", f"- {IMAGE_DETECTIONS}"],
        name="Camera",
    )
    ground = rrb.Spatial3DView(
        origin=EGO,
        contents=["$origin/**", f"- {IMAGE}/**"],
        name="Ground, from above",
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(
            position=(36.0, 0.0, 105.0), look_target=(36.0, 0.0, 0.0), eye_up=(1.0, 0.0, 0.0)
        ),
    )
    legend = rrb.PlotLegend(visible=False)
    plots = [
        rrb.TimeSeriesView(
            origin=PLOT_DISTANCE, name=f"Distance of the lead [{distance_unit}]", plot_legend=legend
        ),
        rrb.TimeSeriesView(
            origin=PLOT_TTC,
            name="Time to collision [s]",
            axis_y=rrb.ScalarAxis(range=TTC_AXIS_S, zoom_lock=True),
            plot_legend=legend,
        ),
        rrb.TimeSeriesView(origin=PLOT_SPEED, name=f"Closing speed [{speed_unit}]", plot_legend=legend),
    ]
    level = rrb.StateTimelineView(origin=LEVEL, name="Warning level")
    log = rrb.TextLogView(
        origin=LOG,
        name="Warnings",
        columns=rrb.TextLogColumns(
            timeline_columns=[
                encodings.TimelineColumn(TIME_TIMELINE),
                encodings.TimelineColumn(FRAME_TIMELINE),
            ],
            text_log_columns=[encodings.TextLogColumn("LogLevel"), encodings.TextLogColumn("Body")],
        ),
    )
    drive = rrb.TextDocumentView(origin=DRIVE, name="Drive")
    return EndingBlueprint(
        rrb.Horizontal(
            rrb.Vertical(
                rrb.Horizontal(camera, ground, column_shares=[11, 4]),
                rrb.Tabs(log, drive, active_tab=0),
                row_shares=[5, 2],
            ),
            rrb.Vertical(level, *plots, row_shares=[2, 4, 4, 4]),
            column_shares=[11, 5],
        ),
        _time_panel(played_ns),
        auto_layout=False,
        auto_views=False,
        collapse_panels=True,
    )


def _time_panel(played_ns: tuple[int, int] | None) -> rrb.TimePanel:
    """Where the viewer stands in time: it has no cursor to set, but goes to the part that it plays."""
    if played_ns is None:
        return rrb.TimePanel(state="collapsed", timeline=TIME_TIMELINE, play_state="paused")
    return rrb.TimePanel(
        state="collapsed",
        timeline=TIME_TIMELINE,
        play_state="playing",
        loop_mode="selection",
        time_selection=AbsoluteTimeRange(*played_ns),
    )
