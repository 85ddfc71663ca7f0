"""With what the program ends, but for 0 and for 1, a fault of ours: scripts rely on it."""

EXIT_WRONG_INPUT = 2
EXIT_INTERRUPTED = 130
