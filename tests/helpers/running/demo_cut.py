"""Parts of the shipped drive, for what needs a drive but not all forty seconds."""

from pathlib import Path

import av

DEMO = Path(__file__).parents[3] / "recordings" / "demo"
FRAMES_PER_SECOND = 30


def cut_demo(folder: Path, first_s: int, seconds: float, name: str = "drive") -> Path:
    """These seconds of it as a video of its own, with its calibration and its own speed beside it.

    The packets stay as they are: no frame leans on a later one, and each second begins with a keyframe.
    """
    folder.mkdir(parents=True, exist_ok=True)
    first, count = first_s * FRAMES_PER_SECOND, round(seconds * FRAMES_PER_SECOND)
    video = folder / f"{name}.mp4"
    with av.open(str(DEMO / "drive.mp4")) as whole, av.open(str(video), "w") as part:
        stream = whole.streams.video[0]
        written = part.add_stream_from_template(stream)
        packets = [packet for packet in whole.demux(stream) if packet.pts is not None][first : first + count]
        start = packets[0].pts
        for packet in packets:
            assert packet.pts is not None
            packet.pts = packet.dts = packet.pts - (start or 0)
            packet.stream = written
            part.mux(packet)
    (folder / f"{name}.calibration.yaml").write_bytes((DEMO / "drive.calibration.yaml").read_bytes())
    head, *speeds = (DEMO / "drive.speed.csv").read_text().splitlines()
    rows = [line.split(",") for line in speeds[first : first + count]]
    shifted = [f"{float(time_s) - first_s:.6f},{speed_mps}" for time_s, speed_mps in rows]
    (folder / f"{name}.speed.csv").write_text("\n".join([head, *shifted, ""]))
    return video
