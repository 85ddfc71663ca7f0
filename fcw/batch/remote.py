"""Files in object stores, read with fsspec: how they are found, identified, and fetched for a run."""

import hashlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, cast

from fcw.errors import UserError

if TYPE_CHECKING:
    from fsspec import AbstractFileSystem

CONTENT_KEYS = ("sha256", "md5Hash", "ETag", "etag")
"""What stores state about the content of a file; the first one that exists is used."""
CHUNK_BYTES = 4 << 20
EMPTY = "empty file; copy it again from where it was recorded"


class StoreError(UserError):
    """A file in a store cannot be read."""


@dataclass(frozen=True, slots=True)
class RemoteFile:
    """A file that fsspec can read, for example `s3://bucket/van-3/a.mp4`."""

    url: str

    def __str__(self) -> str:
        return self.url

    @property
    def path(self) -> PurePosixPath:
        """The path without the protocol."""
        return PurePosixPath(self.url.partition("://")[2])

    def beside(self, name: str) -> "RemoteFile":
        """Another file in the same folder."""
        return RemoteFile(f"{self.url.rpartition('/')[0]}/{name}")

    def exists(self) -> bool:
        """Whether the file exists.

        Raises:
            StoreError: the store cannot be read.
        """
        with _told(self.url):
            return bool(_filesystem(self.url).exists(self.url))

    def content(self) -> str:
        """What identifies its content: what the store states about it, or else its SHA-256.

        Raises:
            StoreError: the file cannot be read, or is empty.
        """
        with _told(self.url):
            filesystem = _filesystem(self.url)
            about = filesystem.info(self.url)
            if about.get("size") == 0:
                raise StoreError(f"{self.url}: {EMPTY}")
            for key in CONTENT_KEYS:
                if about.get(key):
                    return f"{key} {about[key]} {about.get('size')}"
            digest = hashlib.sha256()
            with filesystem.open(self.url, "rb") as file:
                while data := file.read(CHUNK_BYTES):
                    digest.update(cast(bytes, data))
            return digest.hexdigest()


Place = Path | RemoteFile
"""The place of a drive or a calibration."""


def place_of(text: str | Path) -> Place:
    """A path, or a URL with a protocol."""
    return RemoteFile(text) if isinstance(text, str) and "://" in text else Path(text)


def files_below(url: str) -> tuple[list[RemoteFile], bool]:
    """All files below a folder, sorted by name, and False; or, if the URL is a file, that file and True.

    Raises:
        UserError: there is nothing at the URL, or the store cannot be read.
    """
    with _told(url):
        filesystem = _filesystem(url)
        found = [RemoteFile(filesystem.unstrip_protocol(name)) for name in sorted(filesystem.find(url))]
        if not found:
            raise UserError(f"{url}: no such file or folder; expected a video, an MCAP file, or a folder")
        return found, bool(filesystem.isfile(url))


@contextmanager
def fetched(*places: Place | None) -> Iterator[tuple[Path | None, ...]]:
    """Local paths of the files under their own names; what had to be fetched is deleted at the end.

    Raises:
        StoreError: a file cannot be fetched.
    """
    with ExitStack() as stack:
        yield tuple(
            _fetch(place, Path(stack.enter_context(TemporaryDirectory(prefix="fcw-"))))
            if isinstance(place, RemoteFile)
            else place
            for place in places
        )


def _fetch(file: RemoteFile, folder: Path) -> Path:
    path = folder / file.path.name
    with _told(file.url):
        _filesystem(file.url).get_file(file.url, str(path))
    return path


def _filesystem(url: str) -> "AbstractFileSystem":
    try:
        from fsspec.core import url_to_fs
    except ImportError:
        raise UserError(
            f"{url}: needs fsspec, which is not installed; install it with `pip install 'fcw[batch]'`"
        ) from None
    return url_to_fs(url)[0]


@contextmanager
def _told(url: str) -> Iterator[None]:
    """Turn the errors of a store, which each store has its own of, into one message."""
    protocol = url.partition("://")[0]
    try:
        yield
    except UserError:
        raise
    except ImportError as error:
        raise StoreError(
            f"{url}: files of {protocol}:// need a package that is not installed here ({error}); install it "
            f"here and on every worker with `pip install 'fsspec[{protocol}]'`"
        ) from error
    except FileNotFoundError as error:
        raise StoreError(f"{url}: no such file or folder ({error})") from error
    except Exception as error:
        raise StoreError(
            f"{url}: cannot be read ({type(error).__name__}: {error}); expected a file or folder that this "
            "machine, and every worker, may read"
        ) from error
