"""The closed loop: what a law is, sensors, actuators, one run, and the check of a law."""
