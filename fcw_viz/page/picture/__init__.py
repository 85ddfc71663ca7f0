"""The picture in viser that is slid and zoomed, and what is drawn and dragged on it."""
