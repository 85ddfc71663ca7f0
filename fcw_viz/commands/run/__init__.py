"""`fcw run`: the whole job on one drive."""
