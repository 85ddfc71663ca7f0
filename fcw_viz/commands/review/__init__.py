"""`fcw review`: look at drives that were logged, and judge their warnings."""
