"""The base robot alone, from whichever channels a recording holds."""
