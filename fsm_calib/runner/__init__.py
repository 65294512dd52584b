"""Runs a scenario: the active state's activity, its outcome, the journal, the machine; files and report."""
