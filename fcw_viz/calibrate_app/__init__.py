"""The click-to-calibrate page: the user's input, the solution that follows, and the page that shows both.

`document` contains the input, its edits, their journal on disk, and the solution. `session` joins these for
all tabs. `desk` is what one person works with: the picture (with `drawing` over it), the selection and the
tool. `panels`, `handles` and `keys` use a desk, `tab` puts them together, and `server` serves the tabs.
"""
