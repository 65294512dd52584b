"""Tables and pictures of a run, a study or a diagnosis, in one offline page."""
