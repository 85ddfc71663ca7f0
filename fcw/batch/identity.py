"""How a finished drive is recognised: by its content, and by all that its result depends on."""

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path

from fcw.batch.remote import Place, RemoteFile
from fcw.detection.choice import DEFAULT_DETECTOR, model_path
from fcw.detection.model import model_sha256
from fcw.sources.folders.listing import VIDEO_SUFFIXES, files_in
from fcw.versions import __version__
from fcw.warning.policies import DEFAULT_POLICY, DEFAULT_TIMING


@dataclass(frozen=True, slots=True)
class BatchOptions:
    """How all drives of a batch are run; see `fcw.job.DriveJob`.

    Attributes:
        model: path of the detector's, as text for the manifest; empty for the shipped one.
    """

    detector: str = DEFAULT_DETECTOR
    warning_policy: str = DEFAULT_POLICY
    warning_timing: str = DEFAULT_TIMING
    own_motion: bool = True
    model: str = ""

    @property
    def model_file(self) -> Path | None:
        """The model that was named."""
        return Path(self.model) if self.model else None


@dataclass(frozen=True, slots=True)
class Identity:
    """What was run; SHA-256 in hexadecimal, empty for none.

    Attributes:
        content: of the source's bytes; of a folder, of its videos' names and bytes; of one in an object store
            what that says of its content.
        calibration: of its file's, likewise; empty where the source has it inside.
        model: of the detector's file.
        options: as given.
        version: of this program.
        track: of the GPX file beside the source, likewise.
        topic: of an MCAP file, whose pictures; its name, empty where none was named.
    """

    content: str
    calibration: str
    model: str
    options: BatchOptions
    version: str = __version__
    track: str = ""
    topic: str = ""

    @property
    def key(self) -> str:
        """SHA-256 of all of it: equal keys make equal logs."""
        fields = asdict(self)
        del fields["options"]["model"]  # it is known by its content, wherever it lies
        for later in ("track", "topic"):
            if not fields[later]:
                del fields[later]  # drives without one are known by what they were before there were any
        return hashlib.sha256(json.dumps(fields, sort_keys=True).encode()).hexdigest()


def identity_of(
    source: Place,
    calibration: Place | None,
    options: BatchOptions,
    track: Place | None = None,
    topic: str | None = None,
) -> Identity:
    """Read a drive's files once, which takes a hundredth of the time that running it does.

    Raises:
        OSError: a file cannot be read.
        UserError: there is no detector of that name, or a store cannot be read.
    """
    return Identity(
        content=_sha256(source),
        calibration="" if calibration is None else _sha256(calibration),
        model=model_sha256(model_path(options.detector, options.model_file)),
        options=options,
        track="" if track is None else _sha256(track),
        topic=topic or "",
    )


def _sha256(path: Place) -> str:
    if isinstance(path, RemoteFile):
        return path.content()
    if path.is_dir():
        contents = [(file.name, _sha256(file)) for file in files_in(path, VIDEO_SUFFIXES)]
        return hashlib.sha256(json.dumps(contents).encode()).hexdigest()
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
