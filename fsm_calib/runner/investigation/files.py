"""The names of an investigation's own files, beside journal and checkpoint."""

from __future__ import annotations

RESULT, PAGE, WORLD, DRIVES = "investigation.json", "index.html", "world.yaml", "drives"
OWN_FILES = (RESULT, PAGE, WORLD)
OWN_FOLDERS = (DRIVES, "calibration")
