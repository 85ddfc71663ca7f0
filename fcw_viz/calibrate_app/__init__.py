"""The click-to-calibrate page: what somebody told it, what follows, and the page that shows both.

`document` holds what was said and its edits; `journal` keeps the edits on disk; `solution` says
what follows from a document; `session` joins the three for all tabs. `tab` is one browser tab: its picture
(`picture_overlay`), its panels and its figures. `server` serves them.
"""
