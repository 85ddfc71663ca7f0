"""Own motion by the picture against true poses."""
