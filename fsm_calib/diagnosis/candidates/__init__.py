"""The hypotheses of the catalogue, where each could start, and their ranking."""
