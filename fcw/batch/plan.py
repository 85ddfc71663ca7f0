"""What a batch has to do: which drives are finished, which cannot be run, and which are left."""

import hashlib
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from shlex import quote

from fcw.batch.drives import BatchDrive
from fcw.batch.identity import BatchOptions, Identity, identity_of
from fcw.batch.ledger import MANIFEST_NAME, RETRY_WORDS, Ledger, Record, State
from fcw.batch.remote import EMPTY, StoreError
from fcw.batch.tables import TABLE_NAMES
from fcw.batch.work import Task
from fcw.errors import UserError
from fcw.sources import check_path

RESERVED_NAMES = (MANIFEST_NAME, *TABLE_NAMES)
"""Names of files in the folder of the batch, which no folder of a drive may have."""


@dataclass(frozen=True, slots=True)
class Plan:
    """A batch before it runs.

    Attributes:
        tasks: drives to run.
        records: records of all others, with their earlier results or why they are not run.
        identities: identities of all drives that could be read, by key.
    """

    tasks: tuple[Task, ...]
    records: tuple[Record, ...]
    identities: dict[str, Identity]


def plan_batch(
    drives: Sequence[BatchDrive],
    options: BatchOptions,
    ledger: Ledger,
    retry: bool = False,
    on_drive: Callable[[], None] = lambda: None,
    piece_s: float | None = None,
) -> Plan:
    """Look at every drive once.

    Args:
        drives: all drives.
        options: how they are run.
        ledger: ledger of the batch's folder.
        retry: whether to run only those that failed.
        on_drive: called after each drive.
        piece_s: see `Task`; results do not depend on it.

    Raises:
        UserError: there is no such detector.
    """
    found: list[tuple[BatchDrive, Identity]] = []
    listed: list[Record] = []
    for drive in drives:
        record = _broken(drive) or _without_running(drive)
        try:
            if record is None:
                identity = identity_of(drive.source, drive.calibration, options, drive.track, drive.topic)
                found.append((drive, identity))
        except OSError as error:
            record = _record(
                drive, State.FAILED, f"{drive.source}: cannot be read ({error.strerror}); check the file"
            )
        except StoreError as error:
            record = _record(drive, State.FAILED, str(error))
        if record is not None:
            listed.append(record)
        on_drive()
    originals = _originals(found, ledger)
    records: list[Record] = []
    to_run: list[tuple[BatchDrive, Identity]] = []
    copies: list[tuple[BatchDrive, str]] = []
    called = {key: original.name for key, original in originals.items()}
    for drive, identity in found:
        original, known = originals[identity.key], ledger.known(identity)
        if original is not drive:
            copies.append((drive, identity.key))
        elif known is not None and (known.state is State.DONE or not retry):
            records.append(_known(known, drive))
            called[identity.key] = known.name
        elif retry and not ledger.has_failed(identity, str(drive.source)):
            reason = "not run yet, and --retry runs only what failed; run the batch without it"
            listed.append(_record(drive, State.LOST, reason))
        else:
            to_run.append((drive, identity))
    taken = {*RESERVED_NAMES, *(record.name for record in records)}
    tasks = []
    for drive, identity in to_run:
        name = _folder_name(drive, identity, ledger, taken)
        taken.add(name)
        called[identity.key] = name
        tasks.append(Task(replace(drive, name=name), identity, ledger.folder(name), piece_s))
    # Now the names of the drives that they are copies of are known.
    for drive, key in copies:
        reason = f"the same file and calibration as {called[key]}"
        listed.append(_record(drive, State.DUPLICATE, reason))
    for record in listed:
        name = record.name
        if name in taken or name in ledger.finished:
            name = f"{name}-{hashlib.sha256(record.source.encode()).hexdigest()[:8]}"
        taken.add(name)
        records.append(replace(record, name=name))
    return Plan(tuple(tasks), tuple(records), {identity.key: identity for _, identity in found})


def _originals(found: Iterable[tuple[BatchDrive, Identity]], ledger: Ledger) -> dict[str, BatchDrive]:
    """For equal drives, the one that stands for all: the one that was run, or else the first."""
    originals: dict[str, BatchDrive] = {}
    for drive, identity in found:
        known = ledger.known(identity)
        was_run = known is not None and known.source == str(drive.source)
        if was_run or identity.key not in originals:
            originals[identity.key] = drive
    return originals


def _folder_name(drive: BatchDrive, identity: Identity, ledger: Ledger, taken: Collection[str]) -> str:
    """The folder of a drive. It may replace the drive's own earlier log, but never that of another drive."""
    for name in (*ledger.names_of(str(drive.source), identity.content), drive.name):
        there = ledger.finished.get(name)
        if name not in taken and (there is None or there.content in ("", identity.content)):
            return name
    return f"{drive.name}-{identity.key[:8]}"


def _broken(drive: BatchDrive) -> Record | None:
    """The record of a drive that cannot be read; such drives look equal, but are no copies of each other."""
    source = drive.source
    if not isinstance(source, Path):
        return None
    try:
        check_path(source)  # a name that is no text fits into no table
    except UserError as error:
        return _record(drive, State.FAILED, str(error))
    if source.is_file() and source.stat().st_size == 0:
        return _record(drive, State.FAILED, f"{source}: {EMPTY}")
    if source.is_symlink() and not source.exists():
        reason = f"{source}: a link to {source.readlink()}, which is not there; mend the link, or remove it"
        return _record(drive, State.FAILED, reason)
    return None


def _without_running(drive: BatchDrive) -> Record | None:
    if drive.is_calibrated:
        return None
    make = f"`fcw calibrate {quote(str(drive.source))}` (a rough one, from the drive alone: --from-clip)"
    if drive.lacking_table is None:
        reason = f"make one with {make}, or name one for all with --calibration"
    else:
        reason = (
            f"{drive.lacking_table} has no line for camera {drive.camera}, which is the name of the drive's "
            f"folder; add one, or make a calibration with {make}"
        )
    return _record(drive, State.UNCALIBRATED, reason)


def _known(known: Record, drive: BatchDrive) -> Record:
    """An earlier record, with the present place of the file."""
    again = "" if known.state is State.DONE else RETRY_WORDS
    reason = known.reason if known.reason.endswith(again) else known.reason + again
    return replace(known, source=str(drive.source), camera=drive.camera, reason=reason)


def _record(drive: BatchDrive, state: State, reason: str) -> Record:
    return Record(drive.name, str(drive.source), drive.camera, state, reason)
