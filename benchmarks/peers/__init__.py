"""Other ways to find out what a simulation leaves out, on the same recordings."""
