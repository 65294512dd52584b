"""A page to look at a run while it runs, or to replay one that has ended: it reads the run's files and nothing else."""
