"""What people say of a recorded drive: verdicts on its warnings, missed events, notes, boxes."""
