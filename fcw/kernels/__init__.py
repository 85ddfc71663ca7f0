"""How loops over pixels and trees are compiled, and the memory they run over."""
