"""Command lines with values that nobody should give."""

BAD_NUMBERS = (
    "nan",
    "inf",
    "-inf",
    "1e308",
    "1e-300",
    "-1",
    "0",
    "9" * 400,
    "1e999",
    "",
    "[/x]",
    "\udcff",
    "a\x1b[2J",
)
POINTS = ("--points", "6:640", "15:520", "30:480")


def command_lines(folder: str) -> list[list[str]]:
    """All of them; each ends with 0 or 2, at once."""
    size = ["--image-size", "1280x720"]
    long = f"{folder}/{'x' * 300}"
    lines: list[list[str]] = []
    for value in BAD_NUMBERS:
        lines += [
            ["calibrate", *POINTS, *size, f"--height={value}"],
            ["calibrate", "--points", f"6:{value}", "15:520", "30:480", *size, "--height", "1.3"],
            ["calibrate", "--points", f"{value}:640", "15:520", "30:480", *size, "--height", "1.3"],
            ["calibrate", *POINTS, "--image-size", f"{value}x{value}", "--height", "1.3"],
            ["calibrate", *POINTS, *size, "--height", "1.3", f"--field-of-view={value}"],
            ["calibrate", *POINTS, *size, "--height", "1.3", f"--field-of-view=60:{value}"],
            ["calibrate", *POINTS, *size, "--height", "1.3", f"--principal-row={value}"],
            ["calibrate", *POINTS, *size, "--height", "1.3", f"--horizon-row={value}:{value}"],
            ["calibrate", *POINTS, *size, "--height", "1.3", f"--reference-offset={value}"],
            ["calibrate", *POINTS, *size, "--height", "1.3", f"--row-sigma={value}"],
            ["calibrate", *POINTS, *size, "--height", "1.3", f"--tape-error={value}"],
            [
                "export",
                f"{folder}/good.mcap",
                "--format",
                "csv",
                "--out",
                f"{folder}/o.csv",
                "--between",
                "0",
                value,
            ],
            [
                "evaluate",
                "motion",
                f"{folder}/pictures",
                f"--frame-rate={value}",
                "--poses",
                f"{folder}/none",
            ],
            ["review", f"{folder}/good.mcap", f"--port={value}", "--no-open"],
            ["simulate", "no-such", "--out", f"{folder}/sim", f"--seed={value}"],
            ["run", f"{folder}/{value}"],
            ["run", f"{folder}/pictures", f"--ego-speed=-{value}1"],
        ]
    for place in (long, f"{folder}/\udcff", f"{folder}/none/[/x]", "/dev/null", "/proc/self/mem", folder):
        lines += [
            ["run", place],
            ["calibrate", place, "--no-open", *POINTS, "--height", "1.3"],
            ["calibrate", *POINTS, *size, "--height", "1.3", "--save", place],
            ["recover", place],
            ["review", place, "--summary"],
            ["export", place, "--format", "csv", "--out", f"{folder}/p.csv"],
            ["evaluate", "warning", "--events", place, "--log", place],
            ["evaluate", "distance", "--kitti-tracking", place],
            ["simulate", place, "--out", place],
            ["train", "--data", place, "--out", f"{folder}/m.npz"],
        ]
    return lines
