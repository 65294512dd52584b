"""The five calibration machines, the focus step and their supervisor, declared as data; nothing computes
here.

Open `focus`, `scan`, `orientation`, `wheels`, `exit` or `lane` to read one machine; `supervisor` puts them in
the paper's order; `activities` is the contract of what a state does; `calibration.CALIBRATION`
holds it all as one value, which `statechart` runs, checks and draws.
"""
