"""What the command line says of the road in the picture besides taped points."""

import math
from dataclasses import replace

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint, GroundRectangle, NumberPlate
from fcw.camera.joint.bent import bent_picture
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.odd_rectangle import odd_rectangle
from fcw.camera.joint.plates import PLATE_SIGMA_M, PLATE_WIDTHS_M
from fcw.camera.lens.plumb import BENT_PX, FEWEST_LINE_POINTS, bend_px
from fcw.camera.plausibility import height_finding
from fcw.camera.prior_sigmas import SIDE_SIGMA_M, UNKNOWN_HEIGHT_M, UNKNOWN_HEIGHT_SIGMA_M
from fcw.camera.vanishing import Segment
from fcw.errors import UserError
from fcw_viz.commands.calibrate.options import CalibrateCommand

LANE_WIDTH_SIGMA = 0.03
"""Of a lane's width, as a part of it: standards are kept to some centimetres, paint is as wide as a hand."""
HEIGHT_SIGMA = 0.02
"""Of a height that somebody measured, as a part of it."""
LOWEST_M, HIGHEST_M = 0.5, 4.0
"""Of a lens behind a windscreen: a go-kart's to that of the tallest lorry."""
LONGEST_OFFSET_M, SHORTEST_BONNET_M = 5.0, 0.2
"""From the windscreen to the bumper: about 2 m in cars, up to 4 in lorries with long bonnets."""
FEWEST_DASHES = 3


def stated_evidence(command: CalibrateCommand) -> Evidence | None:
    """Lane lines, horizon, dashes, rectangles and plates that are stated; None where there are none.

    Raises:
        UserError: one of them is not as expected.
    """
    lines = tuple(_segment("--lane-line", text) for text in command.lane_line)
    horizon = None if command.horizon_line is None else _segment("--horizon-line", command.horizon_line)
    width = None
    if command.lane_width is not None:
        if len(lines) < 2:
            raise UserError("--lane-width: needs two --lane-line, the left and the right one of the lane")
        value, *rest = _numbers(
            "--lane-width", command.lane_width, (1, 2), "M or M:SIGMA, such as 3.7 or 3.7:0.1"
        )
        width = Gaussian(value, rest[0] if rest else LANE_WIDTH_SIGMA * value)
        if not (value > 0 and width.sigma > 0):
            raise UserError(f"--lane-width {command.lane_width}: expected metres above 0")
    dashes = _dashes(command)
    rectangles, plates = _rectangles(command), _plates(command)
    if not (lines or horizon or dashes or rectangles or plates):
        return None
    places = (tuple(_places("--lane-line", text)) for text in command.lane_line)
    edges = tuple(along for along in places if len(along) >= FEWEST_LINE_POINTS)
    return Evidence(
        dashes, bool(dashes), lines, width, horizon, edges=edges, rectangles=rectangles, plates=plates
    )


def evidence_warnings(command: CalibrateCommand, calibration: Calibration) -> list[str]:
    """Warnings of a rectangle that is none, a lens that bends the picture, lines that bend, a wrong height.

    Raises:
        UserError: the sides of a rectangle are exchanged, so that every distance is wrong.
    """
    if command.exact:
        return []
    evidence = stated_evidence(command) or Evidence()
    if not evidence.points:
        evidence = replace(evidence, points=calibration.points)
    known = Known(
        evidence,
        calibration.image_size,
        stated_height(command),
        calibration.reference_offset_m,
        command.row_sigma,
        calibration.priors,
        calibration.lens,
        command.tape_error,
    )
    odd = odd_rectangle(known)
    if odd is not None and odd.swapped:
        raise UserError(
            f"{odd.text}; exchange them in --rectangle-sides or, if they are right, give the --height or "
            "--field-of-view that shows it"
        )
    if odd is not None:
        return [odd.text]
    height = height_finding(calibration, known.height_m)
    bent = [] if command.lens is not None else _bent_warnings(command, known)
    return bent if height is None else [height.text, *bent]


def _bent_warnings(command: CalibrateCommand, known: Known) -> list[str]:
    """Of a lens that bends the picture, or of lane lines that bend, by five places along one."""
    bent = bent_picture(known)
    if bent is not None:
        return [f"{bent.text}; make its file from pictures of a chessboard (--chessboard) for --lens"]
    return [
        f"the lane line {text} bends by {off_px:.1f} px: either the road does, or the lens, whose "
        "distortion is not known here; give it with --lens"
        for text in command.lane_line
        if len(places := _places("--lane-line", text)) >= FEWEST_LINE_POINTS
        and (off_px := bend_px(places)) > BENT_PX
    ]


def stated_height(command: CalibrateCommand) -> Gaussian:
    """The height of the camera in metres, and how well it is known; that of any where none is stated.

    Raises:
        UserError: no camera behind a windscreen is so high, or the height is known better than can be.
    """
    if command.height is None:
        return Gaussian(UNKNOWN_HEIGHT_M, UNKNOWN_HEIGHT_SIGMA_M)
    check_height(command.height)
    sigma_m = command.height_sigma
    if sigma_m is None:
        return Gaussian(command.height, HEIGHT_SIGMA * command.height)
    if not sigma_m > 0:
        raise UserError(f"--height-sigma {sigma_m:g}: expected metres above 0, how well the height is known")
    return Gaussian(command.height, sigma_m)


def check_height(height_m: float) -> None:
    """Refuse a height that no camera behind a windscreen has.

    Raises:
        UserError: naming the value, what was expected, and what was meant where it is in cm or mm.
    """
    if LOWEST_M <= height_m <= HIGHEST_M:
        return
    meant = [height_m / parts for parts in (100, 1000) if LOWEST_M <= height_m / parts <= HIGHEST_M]
    mend = f"; did you mean {meant[0]:.2f} m?" if meant else "; measure from the road up to the lens"
    raise UserError(
        f"--height {height_m:g} m: a camera behind a windscreen is {LOWEST_M:g} to {HIGHEST_M:g} m above the "
        f"road{mend}"
    )


def check_reference_offset(offset_m: float) -> None:
    """Refuse an offset that no car's bumper has.

    Raises:
        UserError: naming the value, what was expected, and what was meant where it is in cm or mm.
    """
    if 0 <= offset_m <= LONGEST_OFFSET_M:
        return
    meant = [m for parts in (100, 1000) if SHORTEST_BONNET_M <= (m := offset_m / parts) <= LONGEST_OFFSET_M]
    mend = f"did you mean {meant[0]:.2f} m?" if meant else "measure from the lens forward to the bumper"
    raise UserError(
        f"--reference-offset {offset_m:g} m: expected 0 to {LONGEST_OFFSET_M:g}, the metres from the camera "
        f"forward to where the distances start (the front bumper); {mend}"
    )


def _rectangles(command: CalibrateCommand) -> tuple[GroundRectangle, ...]:
    """Each rectangle with its sides; sides stated once are those of all."""
    if command.rectangle_sides and not command.rectangle:
        raise UserError("--rectangle-sides: needs --rectangle, the four corners")
    sides = [_sides(text) for text in command.rectangle_sides] or [(None, None)]
    if len(sides) == 1:
        sides *= len(command.rectangle)
    if len(sides) != len(command.rectangle):
        raise UserError(
            f"--rectangle-sides: {len(sides)} given for {len(command.rectangle)} --rectangle; "
            "expected one for each, or one for all"
        )
    expected = "the columns and rows of four corners in turn, such as 420:610:760:600:700:470:480:474"
    return tuple(
        GroundRectangle(
            tuple(_pairs(_numbers("--rectangle", text, (8,), expected))), *lengths, command.rectangle_along
        )
        for text, lengths in zip(command.rectangle, sides, strict=True)
    )


def _plates(command: CalibrateCommand) -> tuple[NumberPlate, ...]:
    width_m = PLATE_WIDTHS_M.get(command.plate_width.lower())
    if width_m is None:
        expected = f"{', '.join(PLATE_WIDTHS_M)} or metres, such as 0.52 or 0.52:0.005"
        value, *rest = _numbers("--plate-width", command.plate_width, (1, 2), expected)
        width = Gaussian(value, rest[0] if rest else PLATE_SIGMA_M)
    else:
        width = Gaussian(width_m, PLATE_SIGMA_M)
    expected = "columns and rows of two ends and of a tyre on the road, such as 612:410:664:411:640:436"
    return tuple(
        NumberPlate(tuple(_pairs(_numbers("--plate", text, (6,), expected))), width) for text in command.plate
    )


def _sides(text: str) -> tuple[Gaussian | None, Gaussian | None]:
    expected = "AxB in metres, such as 2.5x5, 2.5x, x5 or 2.5:0.1x5:0.2"
    both = text.lower().split("x")
    if len(both) != 2 or both == ["", ""]:
        raise UserError(f"--rectangle-sides {text}: expected {expected}")
    found: list[Gaussian | None] = []
    for side in both:
        value, *rest = _numbers("--rectangle-sides", side, (1, 2), expected) if side else (None,)
        found.append(None if value is None else Gaussian(value, rest[0] if rest else SIDE_SIGMA_M))
    return found[0], found[1]


def _dashes(command: CalibrateCommand) -> tuple[GroundPoint, ...]:
    """The dashes' ends, their distances counted from the first."""
    if not command.dashes:
        if command.dash_period is not None:
            raise UserError("--dash-period: needs --dashes, the rows of the dashes' near ends")
        return ()
    if command.dash_period is None:
        raise UserError("--dashes: --dash-period is missing: metres from one near end to the next one")
    if not command.dash_period > 0:
        raise UserError(
            f"--dash-period {command.dash_period:g}: expected metres above 0, from one near end to the next"
        )
    if command.points:
        raise UserError("--dashes: only for marks whose first distance is not known; leave out --points")
    if len(command.dashes) < FEWEST_DASHES:
        raise UserError(f"--dashes: {len(command.dashes)} ends given, expected {FEWEST_DASHES} or more")
    points = []
    for number, text in enumerate(command.dashes):
        row, *column = _numbers("--dashes", text, (1, 2), "ROW or ROW:COLUMN, such as 612 or 612:540")
        points.append(GroundPoint(number * command.dash_period, row, column[0] if column else None))
    return tuple(points)


def _segment(option: str, text: str) -> Segment:
    first, *_, last = _places(option, text)
    return first, last


def _places(option: str, text: str) -> list[tuple[float, float]]:
    """Two or more places along a line."""
    expected = "COLUMN:ROW:COLUMN:ROW, such as 210:700:590:420, or more places of the line"
    return _pairs(_numbers(option, text, tuple(range(4, 100, 2)), expected))


def _pairs(numbers: tuple[float, ...]) -> list[tuple[float, float]]:
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def _numbers(option: str, text: str, counts: tuple[int, ...], expected: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(part) for part in text.split(":"))
    except ValueError:
        numbers = ()
    if len(numbers) not in counts or not all(map(math.isfinite, numbers)):
        raise UserError(f"{option} {text}: expected {expected}")
    return numbers
