"""One recording type, its readers and writers."""
