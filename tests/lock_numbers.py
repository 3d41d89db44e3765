"""Numbers of the lock on the design: speed of the waves, gear ratio, inertia of the flywheel."""

from __future__ import annotations

WP, N, J4 = 3.14, 0.203 / 0.009, 0.3671  # [rad/s], [-], [kg m^2]
