"""The guard: a process of its own that owns the wheels, and stops them when anything else fails."""
