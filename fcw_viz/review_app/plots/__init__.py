"""The plots under the picture: which signals there are, their values, and how they are drawn."""
