"""The commands of `fsm-calib`: one file for each group, with `register(app)`."""
