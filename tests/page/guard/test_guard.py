"""Who may speak with a page, asked by a client that is no browser."""

import threading
import time
from collections.abc import Callable, Generator
from contextlib import suppress
from http import HTTPStatus

import msgspec.msgpack
import pytest
import viser
from strangers.bare_client import CAMERA, PATIENCE_S, Tabs, get, open_socket
from websockets.exceptions import ConnectionClosedError, InvalidStatus

from fcw.frame import ImageSize
from fcw_viz.page.guard import guard as rules
from fcw_viz.page.guard.guard import LARGEST_MESSAGE_BYTES, Guard, whole_address
from fcw_viz.page.server import PageServer
from fcw_viz.page.tab import PageTab

FIRST_PORT = 18900
FOREIGN_HOSTS = ("attacker.example", "attacker.example:{port}", "127.0.0.1.attacker.example", "10.0.0.1", "")
FOREIGN_ORIGINS = (
    "https://evil.example",
    "null",
    "http://127.0.0.1",
    "https://127.0.0.1:{port}",
    "http://localhost:{port}",
    "http://127.0.0.1:{port}.evil.example",
    "http://127.0.0.1:9",
)


class EmptyPage(PageServer):
    """A page with nothing on it."""

    def open_tab(self, client: viser.ClientHandle) -> PageTab:
        return PageTab(client, "empty", ImageSize(64, 48))


@pytest.fixture
def page() -> Generator[EmptyPage]:
    served = EmptyPage(FIRST_PORT, "empty", dark=False)
    yield served
    served.stop()


def without_token(page: PageServer) -> str:
    return f"http://127.0.0.1:{page.port}"


def test_the_printed_address_opens_the_page_and_its_web_socket_again_and_again(page: EmptyPage):
    for _ in range(2):  # as a reload does
        status, headers, body = get(page.url)
        assert (status, headers.get_content_type()) == (200, "text/html")
        assert b"Viser client" in body
        with open_socket(page.url) as socket:
            assert socket.recv(PATIENCE_S)


@pytest.mark.parametrize("end", ["", "/"])
def test_a_reload_opens_the_page_whatever_stands_in_its_query(page: EmptyPage, end: str):
    # viser's page writes the first one into its own address where that has no slash at its end.
    for query in (f"websocket={page.url.replace('http', 'ws')}", "at=a/b?c", "at=drive%408", ""):
        status, headers, body = get(f"{page.url}{end}?{query}")
        assert (status, headers.get_content_type()) == (200, "text/html")
        assert b"Viser client" in body


def test_an_ssh_tunnel_may_have_another_port(page: EmptyPage):
    assert get(page.url, Host="localhost:9000")[0] == 200
    with open_socket(page.url, origin="http://localhost:9000", host="localhost:9000") as socket:
        assert socket.recv(PATIENCE_S)


@pytest.mark.parametrize("host", FOREIGN_HOSTS)
def test_a_foreign_host_is_refused(page: EmptyPage, host: str):
    host = host.format(port=page.port)
    status, _, body = get(page.url, Host=host)
    assert status == HTTPStatus.FORBIDDEN
    assert b"viser" not in body
    if host:
        with pytest.raises(InvalidStatus, match="403"):
            open_socket(page.url, origin=f"http://{host}", host=host)


@pytest.mark.parametrize("origin", FOREIGN_ORIGINS)
def test_a_foreign_origin_is_refused(page: EmptyPage, origin: str):
    origin = origin.format(port=page.port)
    assert get(page.url, Origin=origin)[0] == HTTPStatus.FORBIDDEN
    with pytest.raises(InvalidStatus, match="403"):
        open_socket(page.url, origin=origin)


def test_a_web_socket_without_an_origin_is_no_browsers(page: EmptyPage):
    with pytest.raises(InvalidStatus, match="403"):
        open_socket(page.url, origin="")


@pytest.mark.parametrize(
    "path",
    [
        *("", "/", "/?at=1", "/index.html", "//", "/wrong/", "/{half}/", "/{token}x/", "/%C3%A9"),
        *(
            "/?/{token}/",
            "/?{token}",
            "/wrong?/{token}/",
            "/{half}?/../{token}/",
            "/?websocket=ws://{token}/",
        ),
    ],
)
def test_without_the_token_everything_is_refused_and_says_what_to_do(page: EmptyPage, path: str):
    token = page.url.rpartition("/")[2]
    path = path.format(token=token, half=token[:-1])
    status, _, body = get(without_token(page), path or "/")
    assert status == HTTPStatus.FORBIDDEN
    assert b"open the address that the program printed" in body
    with pytest.raises(InvalidStatus, match="403"):
        open_socket(f"{without_token(page)}{path}")


def test_a_message_that_is_too_large_ends_its_connection_alone(page: EmptyPage):
    with open_socket(page.url) as other, open_socket(page.url) as socket:
        socket.send(bytes(LARGEST_MESSAGE_BYTES + 1))
        with suppress(ConnectionClosedError):
            for _ in socket:
                pass
        assert socket.close_code == 1009  # RFC 6455: message too big
        assert other.recv(PATIENCE_S)


def test_more_clients_than_anybody_needs_are_refused(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("fcw_viz.page.guard.viser_server.MOST_CLIENTS", 2)
    page = EmptyPage(FIRST_PORT, "empty", dark=False)
    try:
        with open_socket(page.url), open_socket(page.url), pytest.raises(InvalidStatus, match="503"):
            open_socket(page.url)
        wait(lambda: opens(page.url))  # once one is closed there is room
    finally:
        page.stop()


def test_a_ticket_leads_to_the_page_once(page: EmptyPage, monkeypatch: pytest.MonkeyPatch):
    guard = page._guard
    ticket = guard.ticket_url(page.port)
    assert page.url.rpartition("/")[2] not in ticket
    status, headers, _ = get(ticket)
    assert status == HTTPStatus.SEE_OTHER
    assert f"{without_token(page)}{headers['Location']}" == f"{page.url}/"
    assert get(ticket)[0] == HTTPStatus.FORBIDDEN
    late = guard.ticket_url(page.port)
    monkeypatch.setattr(rules.time, "monotonic", lambda: time.perf_counter() + 1e6)
    assert get(late)[0] == HTTPStatus.FORBIDDEN


def test_no_other_page_may_frame_it_or_learn_its_address(page: EmptyPage):
    headers = get(page.url)[1]
    assert headers["Content-Security-Policy"] == "frame-ancestors 'none'"
    assert headers["Referrer-Policy"] == "no-referrer"


def test_a_page_that_is_started_again_has_the_same_secret(page: EmptyPage):
    assert Guard().url(page.port) == page.url == whole_address(without_token(page))


def test_only_a_page_of_this_computer_is_told_the_secret():
    for text in (
        "http://evil.example",
        "http://127.0.0.1:8080@evil.example",
        "http://127.0.0.1:80\n",
        "words",
    ):
        assert whole_address(text) == text


def test_closed_tabs_leave_no_thread_and_no_tab(page: EmptyPage):
    before = threading.active_count()
    for _ in range(2):
        tabs = Tabs(page.url, 20)
        wait(lambda: len(page.tabs) == 20)
        tabs.close()
        wait(lambda: not page.tabs)
    wait(lambda: threading.active_count() == before)


def opens(url: str) -> bool:
    try:
        open_socket(url).close()
    except InvalidStatus:
        return False
    return True


def wait(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_no_tab_can_have_a_tunnel_opened_to_the_internet(page: EmptyPage, monkeypatch: pytest.MonkeyPatch):
    asked = threading.Event()
    monkeypatch.setattr(viser.ViserServer, "request_share_url", lambda server, verbose=True: asked.set())
    with open_socket(page.url) as socket:
        socket.send(msgspec.msgpack.encode({"type": "ShareUrlRequest"}))
        socket.send(msgspec.msgpack.encode(CAMERA))  # they are taken in their order
        wait(lambda: len(page.tabs) == 1)
    assert not asked.is_set()
