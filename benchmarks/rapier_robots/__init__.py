"""Simulated robots in Rapier, with hidden effects and a key."""
