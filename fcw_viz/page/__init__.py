"""What all pages have in common: the picture, what is drawn and dragged on it, playback, and fields.

`picture_view` is the surface for clicks, `script` and `style` are what the browser does and how it looks, and
`server` starts viser on this machine only.
"""
