"""The commands of `fcw`, each with its options."""
