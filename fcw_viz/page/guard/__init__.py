"""Who may speak with a page: the person who started it, from the page itself, and nobody else."""
