"""From a ranking to the answer that a person reads."""
