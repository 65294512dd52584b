"""ROS 1 on the standard library: a node that speaks TCPROS and XML-RPC, a small master, Duckietown's robot.

Source of the protocol: https://wiki.ros.org/ROS/Technical%20Overview, ROS/Connection%20Header, ROS/Master_API,
ROS/Slave_API.
"""
