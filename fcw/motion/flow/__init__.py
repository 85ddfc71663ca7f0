"""Points followed from picture to picture: where they are taken, and when the pictures were."""
