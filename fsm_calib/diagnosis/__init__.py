"""Replay, residuals, location, hypotheses, fit, decision."""
