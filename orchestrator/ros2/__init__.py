"""A scenario among ROS 2 nodes."""
