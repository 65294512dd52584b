"""Scenario files: what to calibrate, where, with which settings; read strictly, every error at once."""
