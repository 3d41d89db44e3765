"""A cap that no law can pass: what the float could yield to a device that may exchange angular momentum at will.

All that ring, spin axis and flywheel do to the float is the rate of change of their angular momentum about the spin axis
e = (cos psi, -sin psi): with h = K u1 + 2 N J3 psi' + J4 omega', equations (22)-(23) read

    (J1 + Jh) phi'' + d phi' + Mr + k phi = Me - d/dt (h e)        (and the lever term, which does no work)

So whatever the law: the moment on the float is -H', where H stays within a disc of radius max |h|, which the speed of
the flywheel sets. Drop all else that binds H (that it lies on the circle, that the ring must turn it, that the coupling
only brakes), keep the disc and the limits of motion, and let H choose itself with perfect foresight: a convex problem,
whose optimum is no less than what any law takes from the float. What a law takes feeds the generator and the slip.

Absorbed energy is the wave input less radiation, hinge and the float's stored energy. That it is a concave function of
the motion needs the storage of the radiation filters written out: Mr phi' = d/dt (z'Xz/2) + z'Qz/2 with A'X + XA = -Q,
X b = p (positive-real lemma). Time is discretised by the midpoint rule, which keeps this balance exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PHI1_RATE, PHI3, PHI3_RATE, PSI, PSI_RATE, RADIATION
from gyroctl.plant.kernel import TAPS, interpolate
from gyroctl.plant.compiled import entry_point
