"""How a finished drive is recognised: by its content and everything else that its result depends on."""

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
    """What was run. Digests are SHA-256 in hexadecimal, or empty if there is no such file.

    Attributes:
        content: digest of the source's bytes, or of a folder's video names and bytes; for a file in an object
            store, what the store states about its content.
        calibration: digest of the calibration file, likewise; empty if the source contains it.
        model: digest of the detector's file.
        options: the options as given.
        version: version of this program.
        track: digest of the GPX file beside the source, likewise.
        topic: name of the topic of an MCAP file; empty if none was named.
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
        """SHA-256 of all of it; drives with equal keys have equal logs."""
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
    """Read the files of a drive once, which takes one hundredth of the time of running it.

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
