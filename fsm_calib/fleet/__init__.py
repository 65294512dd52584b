"""Many real robots in one call: whose recordings are whose, and what each of them tells."""
