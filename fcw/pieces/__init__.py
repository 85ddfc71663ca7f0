"""One long drive on many cores, with the very result that one core has.

What is found in a picture depends on that picture alone, and takes most of the time: the drive is cut into
pieces, in which vehicles are found at the same time. All that is believed over time (tracks, mount, own
motion, warnings) is followed through the whole drive once, a piece after the other as they come in. So there
is no seam: log, summary and events are those of a run in one go.
"""

from fcw.pieces.drive import run_in_pieces
from fcw.pieces.plan import Piece, plan_pieces

__all__ = ["Piece", "plan_pieces", "run_in_pieces"]
