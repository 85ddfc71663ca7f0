"""Following vehicles by their looks: finding an image patch in the next picture, and how much it has
grown."""
