"""The simulated Duckiebot as a robot on a network: late frames, whole PWM numbers, encoders, no watchdog."""
