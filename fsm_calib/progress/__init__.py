"""Every progress bar of the command line: standard error, a bar on a terminal, plain lines elsewhere."""
