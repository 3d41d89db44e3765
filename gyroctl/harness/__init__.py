"""The closed loop: laws, sensors, actuators, one run, and the fair comparison."""
