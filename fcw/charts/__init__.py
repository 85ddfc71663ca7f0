"""Charts as SVG: their pieces, and a plain chart made of them.

They are drawn here and not by a library: a page draws its plots anew with every frame, and words and axes in
`currentColor` read on dark and on light pages. matplotlib takes longer to import than `fcw --help` takes, and
knows no `currentColor`; plotly and its like bring megabytes of JavaScript along in every report.
"""
