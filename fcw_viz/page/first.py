"""What a page shows before viser's own script has started, which takes seconds: HTML within the page."""

import gzip
from html import escape
from pathlib import Path

from websockets.http11 import Response

_BROWSER_SIDE = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")
_STYLE = Path(__file__).with_suffix(".css").read_text(encoding="utf-8")
_BODY = b"<body>"
_START = b"<script data-p="
_WAITS = b'<script type="text/plain" data-p='
"""viser's one script, and the same as text, which `first.js` starts."""
_QUICK = 1
"""Of gzip's levels: the page is packed compactly already."""


def first_html(html: str, drawn_by: str, dark: bool) -> str:
    """HTML that is seen until the page has drawn the same by itself; what is done there meanwhile is kept.

    Args:
        html: what is seen, with the same ids and `data-fcw` attributes as what takes its place.
        drawn_by: CSS selector of the element that takes its place, and whose scroll position it keeps.
        dark: colours.
    """
    look = "fcw-first dark" if dark else "fcw-first"
    return (
        f'<div class="{look}" data-fcw-until="{escape(drawn_by)}"><style>{_STYLE}</style>{html}</div>'
        f"<script>{_BROWSER_SIDE}</script>"
    )


def with_first(response: Response, html: str) -> None:
    """Put HTML at the beginning of the body of viser's page, whose script starts when that is drawn."""
    packed = response.headers.get("Content-Encoding") == "gzip"
    page = gzip.decompress(response.body) if packed else response.body
    head, body, rest = page.rpartition(_BODY)
    if body:
        page = head.replace(_START, _WAITS, 1) + body + html.encode() + rest
        response.body = gzip.compress(page, _QUICK) if packed else page
        del response.headers["Content-Length"]
        response.headers["Content-Length"] = str(len(response.body))
