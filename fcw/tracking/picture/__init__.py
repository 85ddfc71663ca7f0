"""Following vehicles by their looks: where a patch of one picture is in the next, and how it has grown."""
