"""From one unjudged event to the next, in the drives that somebody asks for."""
