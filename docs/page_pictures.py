"""What the scripts that take pictures of the pages have in common."""

from playwright.sync_api import Page

BROWSER_ARGUMENTS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
READY_MS = 60_000
STEADY_MS, STEADY_LOOKS = 1_500, 20
"""The page counts as drawn once it has stayed the same this long: software rendering is slow."""
WITHOUT_WARNING = """
  const ask = WebGL2RenderingContext.prototype.getParameter;
  WebGL2RenderingContext.prototype.getParameter = function (name) {
    return name === 37446 ? "hardware" : ask.call(this, name);
  };
"""
"""viser warns of software rendering over the picture; 37446 is UNMASKED_RENDERER_WEBGL."""


def steady_screenshot(page: Page) -> bytes:
    """The page as a PNG, once two looks at it are the same."""
    before = b""
    for _ in range(STEADY_LOOKS):
        page.wait_for_timeout(STEADY_MS)
        seen = page.screenshot()
        if seen == before:
            return seen
        before = seen
    raise SystemExit("the page does not come to rest")
