"""The click-to-calibrate page: what somebody told it, what follows, and the page that shows both.

`document` holds what was said, its edits, their journal on disk, and what follows; `session` joins them for
all tabs. `desk` is what one person works on there: the picture (with `drawing` over it), the selection, the
tool. `panels`, `handles` and `keys` work on a desk; `tab` puts them together, and `server` serves the tabs.
"""
