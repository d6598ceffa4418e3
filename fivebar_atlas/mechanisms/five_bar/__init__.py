"""The symmetric planar 5R parallel manipulator of Liu, Wang and Zheng 2006."""
