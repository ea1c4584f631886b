"""The wire types in ROS 2's interface language, and the generator that makes Python of them."""
