"""What a page shows before viser's script has started, which takes seconds: HTML inside the page."""

import gzip
from html import escape
from pathlib import Path

from websockets.http11 import Response

_BROWSER_SIDE = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")
_STYLE = Path(__file__).with_suffix(".css").read_text(encoding="utf-8")
_BODY = b"<body>"
_START = b"<script data-p="
_WAITS = b'<script type="text/plain" data-p='
"""viser's only script, and the same as text, which `first.js` starts."""
_QUICK = 1
"""Level of gzip; the page is already compact."""


def first_html(html: str, drawn_by: str, dark: bool) -> str:
    """HTML that is shown until the page has drawn the same; what the user does in it meanwhile is kept.

    Args:
        html: the content, with the same ids and `data-fcw` attributes as the element that replaces it.
        drawn_by: CSS selector of the element that replaces it, to which the scroll position is passed.
        dark: whether the colours are dark.
    """
    look = "fcw-first dark" if dark else "fcw-first"
    return (
        f'<div class="{look}" data-fcw-until="{escape(drawn_by)}"><style>{_STYLE}</style>{html}</div>'
        f"<script>{_BROWSER_SIDE}</script>"
    )


def with_first(response: Response, html: str) -> None:
    """Insert HTML at the start of the body of viser's page; viser's script starts after it is drawn."""
    packed = response.headers.get("Content-Encoding") == "gzip"
    page = gzip.decompress(response.body) if packed else response.body
    head, body, rest = page.rpartition(_BODY)
    if body:
        page = head.replace(_START, _WAITS, 1) + body + html.encode() + rest
        response.body = gzip.compress(page, _QUICK) if packed else page
        del response.headers["Content-Length"]
        response.headers["Content-Length"] = str(len(response.body))
