"""The five calibration machines and their supervisor, declared as data."""
