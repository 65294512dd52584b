"""The proof on concealed data: robots from an independent generator, sealed labels, one command for the table."""
