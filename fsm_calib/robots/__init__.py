"""Sockets for robots: the simulated one, ROS 1 (Duckietown daffy), DTPS (ente); the guard that owns the wheels."""
