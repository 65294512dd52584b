"""Concealed robots from another engine: MuJoCo's rigid bodies and contacts."""
