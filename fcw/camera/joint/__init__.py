"""One fit of all that is known of a camera."""
