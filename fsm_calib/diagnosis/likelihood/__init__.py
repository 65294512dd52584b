"""Residuals turned into white numbers, the noise that makes them likeliest, and robust weights."""
