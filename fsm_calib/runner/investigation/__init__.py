"""An investigation put together: machine, robot, tracker, designer and diagnosis; run, resumed, and written down."""
