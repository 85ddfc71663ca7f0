"""Messages that no page sends, of a client that knows the secret: one line, and it is closed."""

import socket
import struct
import time
from collections.abc import Callable, Generator
from contextlib import suppress
from urllib.parse import urlsplit

import msgspec.msgpack
import pytest
import viser
import zstandard
from strangers.bare_client import CAMERA, PATIENCE_S, get, open_socket
from websockets.exceptions import ConnectionClosed
from websockets.sync.connection import Connection

from fcw.frame import ImageSize
from fcw_viz.page.channel import PageChannel
from fcw_viz.page.controls import on_choice
from fcw_viz.page.guard.messages import LARGEST_UPLOAD_BYTES, UPLOAD_PART_BYTES
from fcw_viz.page.server import PageServer
from fcw_viz.page.tab import PageTab

FIRST_PORT = 18930
NAN = float("nan")
CLICK = {
    "type": "ScenePointerMessage",
    "event_type": "click",
    "ray_origin": [0.0, -1.0, 0.0],
    "ray_direction": [0.0, 1.0, 0.0],
    "screen_pos": [[0.5, 0.5]],
    "modifier": None,
}
FOREIGN: dict[str, object] = {
    "text": "hello",
    "no MessagePack": b"\xc1\xff",
    "cut off": b"\xdd\xff\xff\xff\xff",
    "text that is not UTF-8": b"\x81\xa4type\xa2\xff\xfe",
    "nested 100,000 deep": b"\x91" * 100_000 + b"\xc0",
    "a number": 5,
    "no type": {},
    "a type that is a list": {"type": [1]},
    "an unknown type": {"type": "Nope"},
    "a message to pages": {"type": "RunJavascriptMessage", "source": "alert(1)"},
    "a camera of nothing": {"type": "ViewerCameraMessage"},
    "a camera of words": CAMERA | {"position": ["a", "b", "c"]},
    "a short camera": CAMERA | {"wxyz": [1.0]},
    "a camera nowhere": CAMERA | {"position": [NAN, NAN, NAN]},
    "a camera with more": CAMERA | {"evil": 1},
    "a camera without a direction": CAMERA | {"wxyz": [0.0, 0.0, 0.0, 0.0]},
    "a click without rays": CLICK | {"ray_direction": None},
    "a click nowhere": CLICK | {"screen_pos": []},
    "a click at infinity": CLICK | {"ray_direction": [0.0, 1e308, 0.0]},
    "a box with one corner": CLICK | {"event_type": "rect-select"},
    "an upload in a million parts": {
        "type": "FileTransferStartUpload",
        "source_component_uuid": "u",
        "transfer_uuid": "t",
        "filename": "f",
        "mime_type": "m",
        "part_count": 1_000_000,
        "size_bytes": 5,
    },
}


class TalkingPage(PageServer):
    """A page with a list, a slider and a channel; `heard` is what came from them."""

    def __init__(self) -> None:
        self.heard: list[object] = []
        super().__init__(FIRST_PORT, "talking", dark=False)

    def open_tab(self, client: viser.ClientHandle) -> PageTab:
        tab = PageTab(client, "talking", ImageSize(64, 48))
        on_choice(client.gui.add_dropdown("list", ("a", "b")), tab.run, self.heard.append)
        on_choice(client.gui.add_slider("slider", 0, 10, 1, 3), tab.run, self.heard.append)
        channel = PageChannel(client, tab.run)
        channel.on("seek", lambda about: self.heard.append(float(about)))
        channel.open()
        return tab


@pytest.fixture
def page() -> Generator[TalkingPage]:
    served = TalkingPage()
    yield served
    served.stop()


def elements(tab: Connection) -> dict[str, str]:
    """The ids of the list, the slider and the channel of a tab, by their kinds."""
    found: dict[str, str] = {}
    while len(found) < 3:
        raw = tab.recv(PATIENCE_S)
        assert isinstance(raw, bytes)
        unpacked, packed = struct.unpack("<QQ", raw[:16])
        inner = zstandard.ZstdDecompressor().decompress(raw[16 : 16 + packed], max_output_size=unpacked)
        for message in msgspec.msgpack.decode(inner)["messages"]:
            if message["type"] in ("GuiDropdownMessage", "GuiSliderMessage", "GuiTextMessage"):
                found[message["type"]] = message["uuid"]
    return found


def says(kind: str, value: object) -> Callable[[dict[str, str]], dict[str, object]]:
    return lambda ids: {"type": "GuiUpdateMessage", "uuid": ids[kind], "updates": {"value": value}}


def is_closed(tab: Connection) -> bool:
    try:
        while True:
            tab.recv(PATIENCE_S)
    except ConnectionClosed as closed:
        return closed.rcvd is not None and closed.rcvd.code == 1008
    except TimeoutError:
        return False


def check_one_line(capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture) -> None:
    said = capfd.readouterr().err
    assert said.startswith("fcw: closed a connection that sent what no page does (")
    assert said.count("\n") == 1
    assert not caplog.records


@pytest.mark.parametrize("name", list(FOREIGN))
def test_what_no_page_sends_closes_its_client_with_one_line(
    page: TalkingPage, name: str, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
):
    message = FOREIGN[name]
    with open_socket(page.url) as tab:
        tab.send(msgspec.msgpack.encode(CAMERA))
        elements(tab)
        tab.send(message if isinstance(message, str | bytes) else msgspec.msgpack.encode(message))
        assert is_closed(tab)
    check_one_line(capfd, caplog)


@pytest.mark.parametrize(
    "message",
    [
        says("GuiSliderMessage", "5"),
        says("GuiSliderMessage", True),
        says("GuiSliderMessage", NAN),
        says("GuiSliderMessage", 10**18),
        says("GuiDropdownMessage", 1),
        says("GuiDropdownMessage", ["a"]),
        says("GuiTextMessage", "1 seek:soon"),
        lambda ids: {
            "type": "GuiUpdateMessage",
            "uuid": ids["GuiTextMessage"],
            "updates": {"removed": True},
        },
        lambda ids: {"type": "GuiUpdateMessage", "uuid": ids["GuiTextMessage"], "updates": [1]},
    ],
)
def test_a_value_of_another_kind_than_the_element_has_closes_its_client(
    page: TalkingPage,
    message: Callable[[dict[str, str]], object],
    capfd: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
):
    with open_socket(page.url) as tab:
        tab.send(msgspec.msgpack.encode(CAMERA))
        tab.send(msgspec.msgpack.encode(message(elements(tab))))
        assert is_closed(tab)
    assert not page.heard
    check_one_line(capfd, caplog)


def test_what_is_no_page_at_all_is_answered_or_cut_off_without_a_word(
    page: TalkingPage, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
):
    assert get(f"{page.url}/{'a' * 5000}")[0] == 404
    parts = urlsplit(page.url)
    assert get(page.url, Host=f"{parts.netloc}, attacker.example")[0] == 403
    ask = (
        f"GET {parts.path} HTTP/1.1\r\nHost: {parts.netloc}\r\nOrigin: http://{parts.netloc}\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: "
    ).encode()
    ours = ask + f"viser-v{viser.__version__}\r\n\r\n".encode()
    for sent in (
        bytes(3000),
        b"GET /" + b"a" * 1_000_000,
        ask + b"viser-v0.0.1\r\n\r\n",
        ours + b"\x89\xfe\x00\xc8\0\0\0\0" + bytes(200),  # a ping longer than pings are
        ours + b"\x82\xff" + b"\xff" * 8,  # a message of 2^64 bytes
    ):
        with socket.create_connection((parts.hostname, parts.port), PATIENCE_S) as bare, suppress(OSError):
            bare.sendall(sent)
            bare.shutdown(socket.SHUT_WR)
            while bare.recv(1 << 16):
                pass
    assert get(page.url)[0] == 200
    assert capfd.readouterr() == ("", "")
    assert not caplog.records


def test_what_pages_do_send_is_heard_and_what_comes_too_late_is_passed_over(
    page: TalkingPage, capfd: pytest.CaptureFixture[str]
):
    upload = {
        "type": "FileTransferStartUpload",
        "source_component_uuid": "u",
        "transfer_uuid": "t",
        "filename": "track.gpx",
        "mime_type": "",
        "part_count": -(-2 * LARGEST_UPLOAD_BYTES // UPLOAD_PART_BYTES),
        "size_bytes": 2 * LARGEST_UPLOAD_BYTES,
    }
    with open_socket(page.url) as tab:
        tab.send(msgspec.msgpack.encode(CAMERA))
        ids = elements(tab)
        for message in (
            CAMERA | {"image_height": 0},  # a window without room
            {"type": "GuiUpdateMessage", "uuid": "gone", "updates": {"value": 1}},
            says("GuiDropdownMessage", "c")(ids),  # no longer offered
            upload,  # too large: the tab is told
            says("GuiDropdownMessage", "b")(ids),
            says("GuiSliderMessage", 4.0)(ids),
            says("GuiTextMessage", "1 seek:2.5")(ids),
            CLICK,
        ):
            tab.send(msgspec.msgpack.encode(message))
        ends_s = time.monotonic() + PATIENCE_S
        while len(page.heard) < 3 and time.monotonic() < ends_s:
            with suppress(TimeoutError):  # what is heard last need not be answered
                tab.recv(0.1)
    assert page.heard == ["b", 4, 2.5]
    assert capfd.readouterr().err == ""
