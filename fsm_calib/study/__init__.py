"""The paper's section 4 on any number of robots: by hand and automatic, both tests, and fleets in parallel."""
