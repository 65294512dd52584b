"""Pure functions from an image to an observation."""
