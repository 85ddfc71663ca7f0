"""Which tracked boxes are believed to be vehicles."""
