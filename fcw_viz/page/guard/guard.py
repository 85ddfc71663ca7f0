"""The rules: a request has to come from the page's own address, and its path has to begin with the secret.

Any web page in the person's browser can send requests to this machine's servers, and read the answers of one
that its own domain's name was made to point to (DNS rebinding); other users of this machine can too. So

- the Host must be this machine's loopback, by its name or number (any port: an ssh tunnel has another one);
- an Origin must be that Host; a web socket must have one, as every browser sends it;
- the path must begin with the token of `fcw_viz.page.guard.token`. viser's and rerun's pages ask for all they
  need relative to their address, so it goes with every request, also after a reload, and needs no cookie,
  which browsers would show to all servers on this machine.

The command line of a browser that is started can be seen by other users: it gets a ticket, good once.
"""

import re
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from http import HTTPStatus
from urllib.parse import urlsplit

from fcw_viz.page.guard.token import page_token

HOST = "127.0.0.1"
LOOPBACK_NAMES = frozenset({"127.0.0.1", "localhost", "::1"})
TICKET_S = 60.0
LARGEST_MESSAGE_BYTES = 1 << 20
"""Of a web socket: notes and clicks are far smaller."""
MOST_CLIENTS = 256
"""Web sockets at once: a person has a few tabs, and what connects without end is refused."""
SAFE_HEADERS = {
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
"""No other page shows this one in a frame, or learns its address from a link."""

_BARE_ADDRESS = re.compile(r"http://127\.0\.0\.1:\d{1,5}")

Header = Callable[[str], str | None]
"""The value of a header, by its name."""


@dataclass(frozen=True, slots=True)
class Admitted:
    """A request that is answered.

    Attributes:
        path: below the token, with its query, e.g. `/?at=drive@8`.
    """

    path: str


@dataclass(frozen=True, slots=True)
class Redirected:
    """A ticket was shown: the browser goes on to the page's address."""

    location: str


@dataclass(frozen=True, slots=True)
class Refused:
    """A request that is not answered, and why, in words."""

    status: HTTPStatus
    words: str


@dataclass(slots=True)
class Guard:
    """The rules of one server."""

    token: str = field(default_factory=page_token)
    _tickets: dict[str, float] = field(default_factory=dict)

    def url(self, port: int) -> str:
        """The page's address."""
        return f"{bare_address(port)}/{self.token}"

    def ticket_url(self, port: int) -> str:
        """An address that leads to the page once, within a minute."""
        ticket = secrets.token_urlsafe(16)
        self._tickets[ticket] = time.monotonic() + TICKET_S
        return f"{bare_address(port)}/ticket-{ticket}"

    def judge(self, path: str, header: Header, web_socket: bool) -> Admitted | Redirected | Refused:
        """What becomes of a request.

        Args:
            path: with its query, as it was sent.
            header: its headers.
            web_socket: whether it opens a web socket.
        """
        if words := foreign(header, web_socket):
            return Refused(HTTPStatus.FORBIDDEN, words)
        # The query comes off first: viser's page writes addresses with slashes into its own.
        place, question, query = path.partition("?")
        first, _, rest = place.lstrip("/").partition("/")
        if self._has_ticket(first):
            return Redirected(f"/{self.token}/")
        if not secrets.compare_digest(first.encode(errors="replace"), self.token.encode()):
            words = "the secret is missing in the address: open the address that the program printed"
            return Refused(HTTPStatus.FORBIDDEN, words)
        return Admitted(f"/{rest}{question}{query}")

    def _has_ticket(self, text: str) -> bool:
        valid_until_s = self._tickets.pop(text.removeprefix("ticket-"), None)
        return valid_until_s is not None and time.monotonic() < valid_until_s


def foreign(header: Header, web_socket: bool) -> str:
    """Why a request can be of another web page, in words; empty where it cannot."""
    host, origin = header("Host") or "", header("Origin")
    if _name(host) not in LOOPBACK_NAMES:
        return "this page can be opened only on its own computer"
    if origin not in ({f"http://{host}"} if web_socket else {None, f"http://{host}"}):
        return "other web pages must not connect to this one"
    return ""


def bare_address(port: int) -> str:
    """Where a page is, without the secret: for a file that others may read."""
    return f"http://{HOST}:{port}"


def whole_address(bare: str) -> str:
    """The address of a page of this user's, with the secret; any other text as it is."""
    return f"{bare}/{page_token()}" if _BARE_ADDRESS.fullmatch(bare) else bare


def _name(host: str) -> str | None:
    """The name in a Host header, without its port; None where it is no such header."""
    try:
        parts = urlsplit(f"//{host}")
        whole = parts.netloc == host and parts.username is None and parts.port != 0  # raises for another text
        return parts.hostname if whole else None
    except ValueError:
        return None
