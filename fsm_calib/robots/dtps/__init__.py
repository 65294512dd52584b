"""Duckiebots with DTPS (Duckietown's ente), by Duckietown's own client library: the extra ``[dtps]``."""
