"""What a machine is: states and transitions declared as data, and everything that follows from the declaration.

`spec` holds the words of a table; `machinery.Machinery` is the one value that everything else here takes: the root
chart with the guards, the book-keeping and the activities that it names. `runtime.Machine` runs it, `validate` and
`explore` check it, `diagrams` draws and describes it. Nothing here knows a robot.
"""
