"""The rigid-body Duckiebot, the scene around it and the camera that draws it."""
