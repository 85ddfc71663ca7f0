"""What a page's script sends, told from what it never does: viser takes any message at its word.

A message of another form is none of our page's, and its sender is not spoken with any longer. A value that an
element does not have (any more: what it offers may just have changed) is passed over.
"""

import dataclasses
import math
from collections.abc import Callable
from functools import cache
from typing import Any

import msgspec
import viser
from viser import _messages as viser_messages
from viser.infra import Message

FROM_PAGES = frozenset(
    {
        "CommandTriggerMessage",
        "FileTransferPart",
        "FileTransferPartAck",
        "FileTransferStartUpload",
        "GetRenderResponseMessage",
        "GuiButtonHoldMessage",
        "GuiFormDirtyMessage",
        "GuiFormSubmitMessage",
        "GuiUpdateMessage",
        "LocalStorageGetItemResponseMessage",
        "SceneNodeClickMessage",
        "SceneNodeDragMessage",
        "ScenePointerMessage",
        "TransformControlsDragEndMessage",
        "TransformControlsDragStartMessage",
        "TransformControlsUpdateMessage",
        "ViewerCameraMessage",
    }
)
"""What viser's page sends; all its other messages go the other way."""
SHARING = frozenset({"ShareUrlRequest", "ShareUrlDisconnect"})
"""For the first viser would open a tunnel, by which anybody on the internet could come."""
LARGEST_NUMBER = 1e9
"""Of what is in a picture and on a screen; also no value of a control is larger."""
LARGEST_SCREEN_PX = 100_000
LARGEST_UPLOAD_BYTES = 32 << 20
"""As the largest file that is read, a GPX track."""
UPLOAD_PART_BYTES = 512 << 10
"""In such parts viser's page sends a file."""
MOST_UPLOADS = 4
"""Under way at once in one tab, which has two buttons for them."""

Find = Callable[[], viser.ClientHandle | None]
"""Gives the tab that a message comes from; None while it has no elements yet."""


class ForeignMessageError(ValueError):
    """No page of ours sends that; the text says what is wrong with it, in a few words."""


def passes(raw: str | bytes, find: Find) -> bool:
    """Whether a message is for viser; one that came too late, or of a page without room, is not.

    Raises:
        ForeignMessageError: no page sends it.
    """
    try:
        fields = msgspec.msgpack.decode(raw) if isinstance(raw, bytes) else None
    except (msgspec.DecodeError, ValueError, RecursionError) as error:
        raise ForeignMessageError("not MessagePack") from error
    if not isinstance(fields, dict):
        raise ForeignMessageError("not the fields of a message")
    name = fields.pop("type", None)
    if not isinstance(name, str) or name not in FROM_PAGES | SHARING:
        raise ForeignMessageError("of a kind that pages do not send")
    if name in SHARING:
        return False
    kind: Any = _kinds()[name]
    if not fields.keys() <= {field.name for field in dataclasses.fields(kind)} or not _plain(fields):
        raise ForeignMessageError(f"{name} with other fields or numbers than it has")
    try:
        message = msgspec.convert(fields, kind)
    except msgspec.ValidationError as error:
        raise ForeignMessageError(f"{name}: {error}") from error
    return _passes(message, find)


def _passes(message: Message, find: Find) -> bool:
    if isinstance(message, viser_messages.ViewerCameraMessage):
        sides = message.image_height, message.image_width
        if max(sides) > LARGEST_SCREEN_PX or not any(message.wxyz) or not 0 < message.fov < math.pi:
            raise ForeignMessageError("a camera that no browser has")
        return min(sides) > 0  # a window without any room has nothing to show
    if isinstance(message, viser_messages.ScenePointerMessage):
        click = message.event_type == "click"
        rays = None not in (message.ray_origin, message.ray_direction)
        if len(message.screen_pos) != (1 if click else 2) or (click and not rays):
            raise ForeignMessageError("a click that is none")
    elif isinstance(message, viser_messages.GuiUpdateMessage):
        return _is_value(message, find())
    elif isinstance(message, viser_messages.FileTransferStartUpload):
        return _has_room(message, find())
    return True


def _has_room(message: viser_messages.FileTransferStartUpload, client: viser.ClientHandle | None) -> bool:
    """Whether a file may be sent: viser keeps what has come until it is whole."""
    if message.part_count != -(-message.size_bytes // UPLOAD_PART_BYTES) or message.size_bytes < 0:
        raise ForeignMessageError("a file in other parts than pages send")
    if client is None or len(client.gui._current_file_upload_states) >= MOST_UPLOADS:
        return False
    if message.size_bytes > LARGEST_UPLOAD_BYTES:
        client.add_notification(
            "This file is too large", f"Expected at most {LARGEST_UPLOAD_BYTES >> 20} MB.", color="orange"
        )
        return False
    return True


def _is_value(message: viser_messages.GuiUpdateMessage, client: viser.ClientHandle | None) -> bool:
    """Whether an element has such a value."""
    handle: Any = client.gui._gui_input_handle_from_uuid.get(message.uuid) if client else None
    if handle is None:
        return False
    if message.updates.keys() != {"value"}:
        raise ForeignMessageError("a change of something else than a control's value")
    value, kept = message.updates["value"], handle.value
    options = getattr(handle, "options", None)
    if isinstance(kept, bool):
        fits = isinstance(value, bool)
    elif isinstance(kept, int | float):
        fits = isinstance(value, int | float) and not isinstance(value, bool)
    else:
        fits = isinstance(kept, str) and isinstance(value, str)
    if not fits:
        raise ForeignMessageError(f"a value of another kind than that of a {type(handle).__name__}")
    return options is None or value in options


def _plain(value: object) -> bool:
    """Whether all numbers, at any depth, are such as a screen and a person can have."""
    level = [value]
    while level:
        below: list[object] = []
        for one in level:
            if isinstance(one, dict):
                below += [*one, *one.values()]
            elif isinstance(one, list | tuple):
                below += one
            elif isinstance(one, int | float) and not (math.isfinite(one) and abs(one) <= LARGEST_NUMBER):
                return False
        level = below
    return True


@cache
def _kinds() -> dict[str, type[Message]]:
    return {name: getattr(viser_messages, name) for name in FROM_PAGES}
