"""What people say about a recorded drive: verdicts on its warnings, missed events, notes and boxes."""
