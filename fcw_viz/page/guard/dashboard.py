"""Dask's dashboard shows its pages to other web pages too, by whatever name they have for this machine.

Its address has no secret. So of the rules of `fcw_viz.page.guard.guard` it gets those on Host and Origin.
"""

from typing import Any

from tornado.httputil import HTTPServerRequest
from tornado.routing import Matcher, Rule
from tornado.web import Application, HTTPError, RequestHandler

from fcw_viz.page.guard.guard import foreign


def guard_dashboard(application: Application) -> None:
    """Have a Tornado application refuse the requests of other web pages, whatever path they ask for."""
    application.default_router.rules.insert(0, Rule(_Foreign(), _Refusal))


class _Foreign(Matcher):
    def match(self, request: HTTPServerRequest) -> dict[str, Any] | None:
        web_socket = request.headers.get("Upgrade", "").lower() == "websocket"
        return {} if foreign(request.headers.get, web_socket) else None


class _Refusal(RequestHandler):
    def prepare(self) -> None:
        raise HTTPError(403)
