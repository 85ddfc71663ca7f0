"""The application: all that a person sees or types."""
