"""Folders as drives: of pictures, or of the videos that a dash camera made of one drive."""
