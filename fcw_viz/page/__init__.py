"""What both pages have in common: the picture and what is drawn and dragged on it, playback, fields, manners.

`picture_view` is the clicking surface; `page_script` and `page_style` are what the browser has to do and how
it looks; `server` starts viser on this machine only.
"""
