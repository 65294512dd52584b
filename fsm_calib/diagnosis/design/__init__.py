"""The designer of drives: given how sure we are of what, the drive that would make us surer soonest; pure."""
