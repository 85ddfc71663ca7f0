"""The page of an evaluation: its curve, and the worst misses and false positives as pictures.

One HTML file that holds everything, to be sent around and opened anywhere.
"""

import base64
from collections import defaultdict
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.evaluation.detection.curve_chart import GRID_FPPI, PlottedCurve, curve_chart
from fcw.evaluation.detection.failures import Failure, FailureKind, count_kinds, false_positives, misses
from fcw.evaluation.detection.figures import DetectionEvaluation
from fcw.evaluation.detection.intervals import curve_intervals
from fcw.files import write_whole

REPORT_NAME = "report.html"
PAGE_START = '<!doctype html><html lang="en"><meta charset="utf-8"><title>'
TILES_PER_KIND = 36
TILES_PER_VEHICLE = 4
"""A vehicle missed all through a clip would fill the page."""
TILE_HEIGHT_PX = 230
CONTEXT = 0.9
"""How much of the surroundings is shown on each side, as a part of the box."""
SMALLEST_CROP_PX = 80
BAND_RESAMPLES = 300
Color = tuple[int, int, int]
COUNTED_COLOR: Color = (80, 220, 80)
IGNORED_COLOR: Color = (200, 200, 200)
DETECTION_COLOR: Color = (40, 40, 255)
UNSURE_COLOR: Color = (0, 210, 255)
CURVE_COLOR = "#1769aa"
STYLE = """
body{font:15px/1.45 system-ui,sans-serif;margin:0 auto;padding:24px;max-width:1240px;color:#1c2430;
background:#fff}
h1{font-size:24px;margin:0 0 4px}h2{font-size:19px;margin:36px 0 6px}h3{font-size:16px;margin:26px 0 6px}
p{margin:4px 0 10px;max-width:75ch}nav a{margin-right:16px}a{color:#1769aa}
.top{display:grid;grid-template-columns:minmax(420px,3fr) minmax(320px,2fr);gap:28px;align-items:start}
@media(max-width:900px){.top{grid-template-columns:1fr}}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;margin-bottom:12px}
th,td{text-align:left;padding:2px 14px 2px 0;border-bottom:1px solid #e3e7ec;vertical-align:top}
th{color:#5a6675;font-weight:600}.tables{display:flex;flex-wrap:wrap;gap:0 40px}
.tiles{display:flex;flex-wrap:wrap;gap:14px}figure{margin:0}
figure img{display:block;height:230px;border-radius:4px}
figcaption{font-size:13px;color:#3c4654;margin-top:3px;max-width:330px}
.key b{padding:0 7px;border-radius:3px;font-weight:600;color:#111}
"""


def write_detection_report(
    evaluation: DetectionEvaluation,
    figures: Mapping[str, Any],
    folder: Path,
    beside: Sequence[PlottedCurve] = (),
) -> Path:
    """Write report.html into a folder that is made if need be.

    Args:
        evaluation: what to report.
        figures: its figures, as `fcw evaluate detection --json` prints them.
        folder: where to.
        beside: curves of other detectors to draw with its own.

    Returns:
        The file.

    Raises:
        UserError: the file cannot be written, or a picture cannot be read.
    """
    missed, false = misses(evaluation), false_positives(evaluation)
    tiles = _tiles(evaluation, [*missed, *false])
    title = f"{figures['detector']} on {Path(figures['labels']).parent.name}/{Path(figures['labels']).name}"
    counts = count_kinds([*missed, *false])
    sections = "".join(
        f'<h3 id="{kind.name}">{escape(kind.capitalize())}: {count}</h3>{_shown(kind, count, tiles[kind])}'
        f'<div class="tiles">{"".join(tiles[kind])}</div>'
        for kind, count in counts.items()
    )
    links = "".join(f'<a href="#{kind.name}">{escape(kind)}: {n}</a>' for kind, n in counts.items())
    page = (
        f"{PAGE_START}{escape(title)}</title>"
        f'<meta name="viewport" content="width=device-width"><style>{STYLE}</style>'
        f"<h1>{escape(title)}</h1><p>{escape(_summary(figures))}</p>"
        f'<div class="top"><div>{_curve(evaluation, figures["detector"], beside)}</div><div>'
        f"{_headline_table(figures)}<h3>Failures at the shipped threshold</h3>{_counts_table(counts)}"
        "</div></div>"
        f'<div class="tables">{_strata_table(figures["by_distance"], "distance, m")}'
        f"{_strata_table(figures['by_height'], 'height, px')}"
        f"{_strata_table(figures['by_height_part'], 'part of the height')}"
        f"{_strata_table(figures['by_view'], 'view')}{_strata_table(figures['by_kind'], 'kind')}"
        f"{_strata_table(figures['by_clip'], 'clip')}</div>"
        f"<h2>Failures</h2><nav>{links}</nav>"
        f'<p class="key">{_key("vehicle that counts", COUNTED_COLOR)} {_key("ignored", IGNORED_COLOR)} '
        f"{_key('detection', DETECTION_COLOR)} {_key('detection under the threshold', UNSURE_COLOR)} "
        "Misses come nearest first, false positives surest first.</p>"
        f"{sections}</html>"
    )
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"--report {folder}: cannot make this folder ({error.strerror})") from error
    path = folder / REPORT_NAME
    write_whole(path, page)
    return path


def _summary(figures: Mapping[str, Any]) -> str:
    only = f", only {', '.join(figures['only'])}" if figures["only"] else ""
    return (
        f"{figures['frames']} pictures, {figures['vehicles']} boxes of {figures['distinct_vehicles']} "
        f"vehicles{only}; score threshold {figures['score_threshold']:.2f}. Intervals: "
        f"{figures['confidence']:.0%}, clips and vehicles resampled; the curve's band: these clips' vehicles."
    )


def _curve(evaluation: DetectionEvaluation, name: str, beside: Sequence[PlottedCurve]) -> str:
    band = curve_intervals(
        evaluation.matches,
        evaluation.grouping,
        lambda curve: [curve.at_fppi(float(fppi)).detection_rate for fppi in GRID_FPPI],
        BAND_RESAMPLES,
        same_clips=True,
    )
    mark = evaluation.operating_point
    own = PlottedCurve(f"{name} (dot: as shipped)", CURVE_COLOR, evaluation.curve, mark, band)
    return curve_chart([own, *beside]).svg()


def _headline_table(figures: Mapping[str, Any]) -> str:
    rows = [
        ("detection rate", figures["detection_rate"], figures["detection_rate_interval"]),
        ("false positives a picture", figures["fppi"], figures["fppi_interval"]),
        ("average precision", figures["average_precision"], figures["average_precision_interval"]),
    ] + [
        (f"rate at {point['fppi']:g} FPPI", point["detection_rate"], point["detection_rate_interval"])
        for point in figures.get("at_fppi", ())
    ]
    body = "".join(f"<tr><td>{name}<td>{_rate(value, between)}" for name, value, between in rows)
    return f"<table>{body}</table>"


def _counts_table(counts: Mapping[FailureKind, int]) -> str:
    return f"<table>{''.join(f'<tr><td>{escape(kind)}<td>{n}' for kind, n in counts.items())}</table>"


def _strata_table(strata: Mapping[str, Any], head: str) -> str:
    rows = "".join(
        f"<tr><td>{escape(name)}<td>{row['vehicles']}<td>{row['distinct_vehicles']}"
        f"<td>{_rate(row['detection_rate'], row['detection_rate_interval'])}"
        f"<td>{'-' if row['fppi'] is None else format(row['fppi'], '.3f')}"
        for name, row in strata.items()
        if row["vehicles"] or row["fppi"]
    )
    if not rows:
        return ""
    return f"<table><tr><th>{head}<th>boxes<th>vehicles<th>detection rate<th>FPPI{rows}</table>"


def _rate(value: float | None, interval: Sequence[float | None]) -> str:
    if value is None:
        return "-"
    return f"{value:.3f} ({' to '.join('-' if end is None else f'{end:.3f}' for end in interval)})"


def _key(name: str, color: Color) -> str:
    blue, green, red = color
    return f'<b style="background:rgb({red},{green},{blue})">{name}</b>'


def _shown(kind: FailureKind, count: int, tiles: Sequence[str]) -> str:
    return f"<p>{len(tiles)} of {count} shown.</p>" if len(tiles) < count else ""


def _tiles(evaluation: DetectionEvaluation, failures: Sequence[Failure]) -> dict[FailureKind, list[str]]:
    """The tiles of each kind, as HTML, in the order of the failures."""
    shown: list[Failure] = []
    kinds: dict[FailureKind, int] = defaultdict(int)
    vehicles: dict[int | None, int] = defaultdict(int)
    for failure in failures:
        repeated = failure.vehicle is not None and vehicles[failure.vehicle] >= TILES_PER_VEHICLE
        if kinds[failure.kind] < TILES_PER_KIND and not repeated:
            shown.append(failure)
            kinds[failure.kind] += 1
            vehicles[failure.vehicle] += 1
    tiles: dict[int, str] = {}
    for frame in sorted({failure.frame for failure in shown}):
        pixels = evaluation.images[frame].labelled.read()
        for index, failure in enumerate(shown):
            if failure.frame == frame:
                tiles[index] = _tile(evaluation, failure, pixels)
    by_kind: dict[FailureKind, list[str]] = defaultdict(list)
    for index, failure in enumerate(shown):
        by_kind[failure.kind].append(tiles[index])
    return by_kind


def _tile(evaluation: DetectionEvaluation, failure: Failure, pixels: NDArray[np.uint8]) -> str:
    image, found = evaluation.images[failure.frame], evaluation.found[failure.frame]
    crop, scale, corner = _crop(pixels, failure.box)
    for box, ignored in zip(image.labelled.boxes, image.labelled.ignored, strict=True):
        _draw(crop, box, scale, corner, IGNORED_COLOR if ignored else COUNTED_COLOR, 1 if ignored else 2)
    for box in image.labelled.rear_boxes[~np.isnan(image.labelled.rear_boxes[:, 0])]:
        _draw(crop, box, scale, corner, COUNTED_COLOR, 1)
    for box, score in zip(found.boxes, found.scores, strict=True):
        if score >= evaluation.threshold:
            _draw(crop, box, scale, corner, DETECTION_COLOR, 2, f"{score:.1f}")
        elif failure.label is not None and score == failure.score:
            _draw(crop, box, scale, corner, UNSURE_COLOR, 1, f"{score:.1f}")
    encoded = cv2.imencode(".jpg", crop, [cv2.IMWRITE_JPEG_QUALITY, 85])[1]
    source = base64.b64encode(encoded.tobytes()).decode()
    caption = _caption(evaluation, failure)
    return (
        f'<figure><img src="data:image/jpeg;base64,{source}" alt="{escape(caption)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def _caption(evaluation: DetectionEvaluation, failure: Failure) -> str:
    image = evaluation.images[failure.frame]
    _, _, w, h = failure.box
    parts = [
        f"{image.labelled.clip} {image.labelled.path.stem}",
        f"{failure.distance_m:.0f} m" if np.isfinite(failure.distance_m) else "above the horizon",
        f"{w:.0f}x{h:.0f} px",
    ]
    if failure.score is not None:
        parts.append(f"score {failure.score:.1f}, IoU {failure.iou:.2f}")
    if failure.label is not None:
        fields = image.attributes[failure.label]
        parts += [f"{name} {fields[name]}" for name in ("view", "occluded") if name in fields]
        same = evaluation.grouping.vehicle == failure.vehicle
        if failure.vehicle is not None and same.sum() > 1:
            parts.append(
                f"vehicle {failure.vehicle + 1}: missed in {(~evaluation.hit & same).sum()} of {same.sum()}"
            )
    return ", ".join(parts)


def _crop(
    pixels: NDArray[np.uint8], box: NDArray[np.float64]
) -> tuple[NDArray[np.uint8], float, tuple[int, int]]:
    """The surroundings of a box, enlarged; how much, and the crop's first column and row.

    Of a box outside the picture, which labels may hold by a slip, the nearest part of the picture.
    """
    x, y, w, h = box
    columns, rows = pixels.shape[1], pixels.shape[0]
    middle_x, middle_y = np.clip(x + w / 2, 0, columns), np.clip(y + h / 2, 0, rows)
    half_width = max(w * (0.5 + CONTEXT), SMALLEST_CROP_PX * 0.65)
    half_height = max(h * (0.5 + CONTEXT), SMALLEST_CROP_PX * 0.5)
    left, right = (round(np.clip(middle_x + side * half_width, 0, columns)) for side in (-1, 1))
    top, bottom = (round(np.clip(middle_y + side * half_height, 0, rows)) for side in (-1, 1))
    scale = TILE_HEIGHT_PX / (bottom - top)
    size = max(round((right - left) * scale), 1), TILE_HEIGHT_PX
    crop = cv2.resize(pixels[top:bottom, left:right], size, interpolation=cv2.INTER_CUBIC)
    return np.asarray(crop, np.uint8), scale, (left, top)


def _draw(
    crop: NDArray[np.uint8],
    box: NDArray[np.float64],
    scale: float,
    corner: tuple[int, int],
    color: Color,
    thickness: int,
    text: str = "",
) -> None:
    x, y = ((value + 0.5 - first) * scale for value, first in zip(box[:2], corner, strict=True))
    first, last = (round(x), round(y)), (round(x + box[2] * scale), round(y + box[3] * scale))
    cv2.rectangle(crop, first, last, color, thickness, cv2.LINE_AA)
    if text and 0 <= first[0] < crop.shape[1] and 0 <= first[1] < crop.shape[0]:
        place = (first[0], max(first[1] - 4, 12))
        cv2.putText(crop, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 4, cv2.LINE_AA)
        cv2.putText(crop, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (255, 255, 255), 1, cv2.LINE_AA)
