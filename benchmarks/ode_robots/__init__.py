"""Differential-drive robots in the Open Dynamics Engine with hidden effects, for recordings with a key."""
