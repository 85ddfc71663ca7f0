"""Crafted calibrations, scenarios, speeds and events, by the name of their format in `readers.py`."""

import re
from collections.abc import Callable, Iterable


def _yaml(good: bytes) -> list[bytes]:
    def with_value(field: bytes, value: bytes) -> bytes:
        return re.sub(rb"(?m)^" + field + rb":.*$", field + b": " + value, good)

    heights = [b"yes", b".nan", b".inf", b"1:30:00", b"2024-01-01", b"!!binary aGk=", b"!!set {a, b}", b"~"]
    heights += [b"1_3", b"0o17", b"0b11", b"'1.3'", b"{}", b"[1.3]", b"-1.3", b"1e-320", b"1e308"]
    versions = [b"99", b"-1", b"true", b"'2'", b"2.0", b"[2]", b"1e400"]
    sizes = [b"{width: 0, height: 0}", b"{width: 1000000000, height: 1000000000}", b"{width: 1.5, height: 2}"]
    sizes += [b"[1280, 720]", b"{width: -1280, height: 720}", b"{width: yes, height: no}", b"1280x720"]
    points = b"\n".join(b"- {distance_m: %d, row_px: 400.0}" % k for k in range(1, 3000))
    return [
        *(with_value(b"height_m", value) for value in heights),
        *(with_value(b"fcw_calibration_version", value) for value in versions),
        *(with_value(b"image_size", value) for value in sizes),
        with_value(b"lens", b"{model: radtan, coefficients: [1e300, 1e300]}"),
        with_value(b"reference_offset_m", b"-1e9"),
        with_value(b"row_sigma_px", b"-0.5"),
        with_value(b"tape_error", b"1e300"),
        re.sub(rb"(?s)points:.*?residuals", b"points:\n" + points + b"\nresiduals", good),
        re.sub(rb"(?s)points:.*?residuals", b"points: {a: b}\nresiduals", good),
        re.sub(rb"distance_m: 6.0", b"distance_m: 30.0", good),
        re.sub(rb"covariance_px2:(?s:.*)", b"covariance_px2: [[.nan]]\n", good),
        re.sub(rb"covariance_px2:(?s:.*)", b"covariance_px2: [[-1, 0, 0], [0, -1, 0], [0, 0, -1]]\n", good),
        re.sub(rb"pitch_rad: [\d.]+", b"pitch_rad: 1.5707963267948966", good),
        re.sub(rb"focal_y_px: [\d.]+", b"focal_y_px: 0", good),
        good + b"height_m: 1.4\n",
        good + b"---\n" + good,
        good + b"? [a, b]\n: c\n",
        good + b"? {a: b}\n: c\n",
        good + b"<<: [{height_m: 2}, {height_m: 3}]\n",
        b"%YAML 9.9\n---\n" + good,
        b"%TAG ! tag:example.com,2000:app/\n---\n" + good,
        good.decode().encode("utf-16"),
        b"\xef\xbb\xbf" + good,
        good.replace(b"\n", b"\r"),
        good.replace(b": ", b":\t"),
        good + b"\x00",
        good + b"a: |\n" + b"  x\n" * 50_000,
        b"- " * 40_000,
        b"? " * 40_000,
        b"!a " * 40_000 + b"1",
        b"{" * 49 + b"}" * 49,
        b"#" * 200_000,
        b"'" + b"''" * 100_000,
        b"a: !!timestamp 9999-99-99\n",
        b"a: !!omap [b: 1]\n",
        b"a: !!float x\n",
        b"a: !!int ''\n",
        b"2001-01-01 25:61:61: x\n",
    ]


def _scenario(good: bytes) -> list[bytes]:
    changes = [
        (b"duration_s: 14", b"duration_s: 0"),
        (b"duration_s: 14", b"duration_s: -1"),
        (b"duration_s: 14", b"duration_s: .nan"),
        (b"duration_s: 14", b"duration_s: 3600000"),
        (b"lanes_left: 1", b"lanes_left: 1000000"),
        (b"lanes_left: 1", b"lanes_left: -1"),
        (b"speed_kmh: 80", b"speed_kmh: 1e300"),
        (b"speed_kmh: 80", b"speed_kmh: -80"),
        (b"gap_m: 44", b"gap_m: 0"),
        (b"gap_m: 44", b"gap_m: -1e300"),
        (b"kind: truck", b"kind: ../../etc/passwd"),
        (b"at_s: 2, lane: 0", b"at_s: -1e300, lane: 0"),
        (b"at_s: 2, lane: 0", b"at_s: 2, lane: 99999999"),
        (b"over_s: 2.5", b"over_s: 0"),
        (b"over_s: 2.5", b"over_s: 1e-300"),
        (b"headway_s: 1.2", b"headway_s: 0"),
        (b"reaction_s: 1.2", b"reaction_s: 1e300"),
        (b"name: truck", b"name: [a]"),
        (b"name: truck", b'name: "../\\x00\\e[2J"'),
        (b"description: A", b"description: {a: 1}\nx: A"),
    ]
    vehicle = b"  - {name: v%d, gap_m: %d, speed_kmh: 80}\n"
    return [
        *(good.replace(old, new) for old, new in changes),
        good + b"".join(vehicle % (k, 10 * k) for k in range(4000)),
        good + b"  - {name: truck, gap_m: 44, speed_kmh: 80}\n" * 2,
        b"duration_s: 5\nego: {actions: [" + b"{at_s: 1, speed_kmh: 50, over_s: 1}," * 5000 + b"]}\n",
        b"duration_s: 5\ncamera: {height_m: 1e300}\n",
        b"duration_s: 5\ncamera: {pitch_deg: 90}\n",
        b"duration_s: 5\nvehicles: 5\n",
        b"duration_s: 5\nvehicles: [null]\n",
        b"duration_s: 5\nroad: null\n",
    ]


def _speed(good: bytes) -> list[bytes]:
    return [
        good.replace(b"\n", b"\r\n"),
        good.replace(b"\n", b"\r"),
        good.replace(b",", b";"),
        b"\xef\xbb\xbf" + good,
        good.decode().encode("utf-16"),
        good.replace(b"11.5", "١١.٥".encode()),
        good.replace(b"11.5", b"1_1.5"),
        good.replace(b"11.5", b"nan"),
        good.replace(b"11.5", b"-11.5"),
        good.replace(b"11.5", b"1e308"),
        good.replace(b"1,11.5", b"0,11.5"),
        good.replace(b"1,11.5", b"-9,11.5"),
        good.replace(b"1,11.5", b"1e308,11.5"),
        good.replace(b"1,11.5", b'"1,11.5'),
        good.replace(b"1,11.5,0", b"1"),
        good.replace(b"1,11.5,0", b"1,2,3,4,5,6"),
        good.replace(b"0.1\n", b"nan\n"),
        good.replace(b"0.1\n", b"1e9\n"),
        b"time_s,time_s,speed_mps,speed_mps\n0,1,2,3\n",
        b"TIME_S,SPEED_MPS\n0,1\n",
        b"time_s,speed_mps\n",
        b"time_s,speed_mps\n" * 1000,
        b"time_s,speed_mps\n\x00,\x00\n",
        b"time_s,speed_mps\n" + b"".join(b"%d,1\n" % k for k in range(900_000)),
        b"," * 100_000 + b"\n",
        b"\n" * 1_000_000,
        b'"' * 100_001,
    ]


def _gpx(good: bytes) -> list[bytes]:
    point = b'<trkpt lat="%s" lon="%s"><time>%s</time></trkpt>'

    def track(*rows: tuple[bytes, bytes, bytes]) -> bytes:
        return b"<gpx><trk><trkseg>" + b"".join(point % row for row in rows) + b"</trkseg></trk></gpx>"

    first = (b"48.1", b"11.5", b"2024-01-01T12:00:00Z")
    return [
        track(first),
        track(first, first),
        track(first, (b"-48", b"-170", b"2024-01-01T12:00:01Z")),
        track((b"91", b"0", first[2]), (b"1e308", b"1e308", b"2024-01-01T12:00:01Z")),
        track((b"nan", b"0", first[2]), first),
        track(first, (b"48.1", b"11.5", b"2023-01-01T12:00:00Z")),
        track(first, (b"48.1", b"11.5", b"0001-01-01T00:00:00+23:59")),
        track(first, (b"48.1", b"11.5", b"9999-12-31T23:59:59-23:59")),
        track(first, (b"48.1", b"11.5", b"2024-01-01T12:00:01")),
        track(first, (b"48.1", b"11.5", b"2024-W01-1")),
        track(first, (b"48.1", b"11.5", b"")),
        track(*((b"48.%d" % k, b"11", b"2024-01-01T12:%02d:%02dZ" % (k // 60, k % 60)) for k in range(3600))),
        good.replace(b"<gpx>", b'<g:gpx xmlns:g="http://x">'),
        good.replace(b"<gpx>", b'<gpx xmlns="%s">' % (b"x" * 100_000)),
        good.replace(b"<gpx>", b"<gpx %s>" % b" ".join(b'a%d=""' % k for k in range(20_000))),
        good.replace(b"<time>", b"<time><![CDATA[").replace(b"</time>", b"]]></time>"),
        good.replace(b"<gpx>", b"<?xml-stylesheet href='file:///etc/passwd'?><gpx>"),
        good.replace(
            b"<gpx>", b'<gpx xmlns:xi="http://www.w3.org/2001/XInclude"><xi:include href="/etc/passwd"/>'
        ),
        good.replace(b"48.1", b"&#49;8.1"),
        good.replace(b"48.1", b"&#0;"),
        good.replace(b"48.1", b"&lol;"),
        good.decode().encode("utf-16"),
        b"<!--" + b"-" * 1_000_000 + b"-->" + good,
        b"<gpx/>",
        b"<html><body>404</body></html>",
    ]


def _events_json(_good: bytes) -> list[bytes]:
    return [
        b'[{"start_s": NaN, "end_s": Infinity, "level": "warning"}]',
        b'[{"start_s": 1e400, "end_s": 2, "level": "warning"}]',
        b'[{"start_s": 5, "end_s": 2, "level": "warning"}]',
        b'[{"start_s": -5, "end_s": -2, "level": "warning"}]',
        b'[{"start_s": true, "end_s": false, "level": "warning"}]',
        b'[{"start_s": "1", "end_s": "2", "level": "warning"}]',
        b'[{"start_s": 1, "start_s": 2, "end_s": 3, "level": "warning"}]',
        b'[{"start_s": 1, "end_s": 3, "level": "\\ud800"}]',
        b'[{"start_s": 1, "end_s": 3, "level": "warning\\u0000"}]',
        b'[{"start_s": 1, "end_s": 3, "level": null}]',
        b'[{"start_s": 1, "end_s": 3, "level": "none"}]',
        b"[[1, 2, 3]]",
        b'"events"',
        b"null",
        b'{"events": [{"start_s": 1, "end_s": 2, "level": "warning"}]}',
        b'{"start_s": 1}\n{"start_s": 2}',
        b"[" + b'{"start_s":1,"end_s":2,"level":"warning"},' * 100_000 + b"{}]",
        b"[1,]",
        b"\xef\xbb\xbf[]",
        b'[{"start_s": 1, "end_s": 2, "level": "warning"}]'.decode().encode("utf-16"),
    ]


def _events_csv(_good: bytes) -> list[bytes]:
    head = b"start_s,end_s,level\n"
    return [
        head,
        head + b"5,1,warning\n",
        head + b"nan,inf,warning\n",
        head + b"1,2,WARNING\n",
        head + b"1,2,\n",
        head + b"1\n",
        head + b"1,2,warning,4,5\n",
        head + b"1,2,[/red]\n",
        head + b"1,2,warning\n" * 200_000,
        b"level,level,level\na,b,c\n",
        head.replace(b",", b"\t") + b"1\t2\twarning\n",
    ]


BY_NAME: dict[str, Callable[[bytes], Iterable[bytes]]] = {
    "c.calibration.yaml": _yaml,
    "s.yaml": _scenario,
    "speed.csv": _speed,
    "track.gpx": _gpx,
    "events.csv": _events_csv,
    "events.json": _events_json,
}
