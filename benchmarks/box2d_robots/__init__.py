"""Differential-drive robots as rigid bodies of Box2D with hidden effects, for recordings with a key."""
