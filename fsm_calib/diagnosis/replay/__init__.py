"""Recordings made ready, and what the roll-out says their sensors should have seen."""
