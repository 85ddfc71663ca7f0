"""`fcw bench`: speed measured side by side in one run, through the public interfaces only.

Every round runs each case once, so that a noisy machine slows all of them alike: the ratios within a round
are what to hold on to.
"""
