"""One physical effect a file; the world, the roll-out and the diagnosis read them all from here."""
