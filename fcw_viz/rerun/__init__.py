"""The drive log for the rerun viewer, and the viewer itself."""

import os

# Rerun and Arrow keep what they have freed for a while, each thread its own: 40 MB of a run. Before they are
# loaded they are told here to give it back at once.
os.environ.setdefault("MIMALLOC_PURGE_DELAY", "0")
