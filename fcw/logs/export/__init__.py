"""Exports drive logs to other formats, one module each; `clip` is the part of a drive to export."""
