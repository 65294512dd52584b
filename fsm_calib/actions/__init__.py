"""What a state does: ask the robot, call perception, return an outcome."""
