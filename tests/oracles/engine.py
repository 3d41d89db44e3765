"""The four bodies in MuJoCo, an independent rigid-body engine.

The lever hangs on a ball joint whose speeds are its angular velocity along its own axes; ring, spin axis and flywheel
are real spinning bodies on hinges. Torque pairs act on the bodies, wave and spring forces on the float. Two ideal
constraints are linear in the speeds with constant coefficients, qvel = S (w1, w3, psi', omega'): the lever has no rate
about itself, the spin axis rolls at N psi'. So the engine's mass matrix and forces, projected by S, give the exact
accelerations; its own (soft) equality constraints are not used.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from oracles.generic_plant import RadiationRealisation, runge_kutta

Array = NDArray[np.float64]
_BALL = '<joint type="ball"/>'
_TWO_HINGES = '<joint type="hinge" axis="1 0 0"/><joint type="hinge" axis="0 0 1"/>'
_XML = """
<mujoco><option gravity="0 0 0"/><compiler angle="radian"/><worldbody>
  <body name="float">{hinge}
    <inertial pos="0 {a} 0" mass="{m1}" diaginertia="{J11} {J11} {J11}"/>
    <body name="ring" pos="0 {far} 0"><joint type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="{m2}" diaginertia="{J22_half} {J22} {J22_half}"/>
      <body name="axis"><joint type="hinge" axis="1 0 0"/>
        <inertial pos="0 0 0" mass="{m3}" diaginertia="{J13} {J13_half} {J13_half}"/></body>
      <body name="flywheel"><joint type="hinge" axis="1 0 0"/>
        <inertial pos="0 0 0" mass="{m4}" diaginertia="{J14} {J14_half} {J14_half}"/></body>
    </body>
  </body>
</worldbody></mujoco>
"""


class Forcing(NamedTuple):
    """What acts on the lever from outside, as moments of the linear model [Nm].

    Attributes
    ----------
    moments : ndarray, shape (2,)
        M1 and M3 but that of the added inertia.
    frame : {"lever", "space"}
        "lever": moments about the lever's own axes, as the model has them. "space": horizontal and vertical forces at
        the centre of the float, of fixed direction, as the sea and the springs act.
    """

    moments: Array
    frame: Literal["lever", "space"] = "lever"


class Engine:
    """The device in MuJoCo.

    Parameters
    ----------
    parameters : object
        Has the attributes of Table 1: a, b, r1, r2, m1 .. m4, J11, J22, J13, J14, Jh1, Jh3 (SI).
    hinge : {"no twist", "two hinges"}
        "no twist": ball joint, the rate about the lever held at zero. "two hinges": a fixed axis x1 and a moving axis
        x3, which lets the lever turn about itself at second order.
    """

    def __init__(self, parameters: Any, hinge: Literal["no twist", "two hinges"] = "no twist") -> None:
        values = {name: getattr(parameters, name) for name in ("a", "m1", "m2", "m3", "m4", "J11", "J22", "J13", "J14")}
        halves = {f"{name}_half": values[name] / 2 for name in ("J22", "J13", "J14")}
        joint = _BALL if hinge == "no twist" else _TWO_HINGES
        far = parameters.a + parameters.b
        self.model = mujoco.MjModel.from_xml_string(_XML.format(hinge=joint, far=far, **values, **halves))
        self.data = mujoco.MjData(self.model)
        self.gear = parameters.r2 / parameters.r1
        self.reach = far
        lever = 3 if hinge == "no twist" else 2
        self.speeds = np.zeros((self.model.nv, 4))
        self.speeds[0, 0] = self.speeds[lever - 1, 1] = self.speeds[lever, 2] = self.speeds[lever + 2, 3] = 1.0
        self.speeds[lever + 1, 2] = self.gear
        # Added inertia is a moment -Jh phi'' about the lever's axes without gyroscopic effect: MuJoCo's armature.
        self.model.dof_armature[0], self.model.dof_armature[lever - 1] = parameters.Jh1, parameters.Jh3
        self.body = {name: self.model.body(name).id for name in ("float", "ring", "axis", "flywheel")}

    def place(self, lever: Array, psi: float, speeds: Array) -> None:
        """Set position and speeds: `lever` is a unit quaternion (w, x, y, z), or the two hinge angles [rad]."""
        self.data.qpos[:] = [*lever, psi, 0.0, 0.0]
        self.data.qvel[:] = self.speeds @ speeds
        mujoco.mj_kinematics(self.model, self.data)

    def accelerations(self, u: tuple[float, float], forcing: Forcing) -> Array:
        """Return the accelerations along (w1, w3, psi', omega') at the state set by `place` [rad/s^2]."""
        model, data = self.model, self.data
        self._load(u, forcing)
        mujoco.mj_forward(model, data)
        columns = np.zeros((4, model.nv))
        for column, direction in zip(columns, self.speeds.T, strict=True):
            mujoco.mj_mulM(model, data, column, np.ascontiguousarray(direction))
        return np.linalg.solve(columns @ self.speeds, self.speeds.T @ data.qfrc_smooth)

    def unbalanced(self, accelerations: Array, u: tuple[float, float], forcing: Forcing) -> Array:
        """Return applied less inertia forces when the device is made to accelerate so (inverse dynamics) [Nm]."""
        self._load(u, forcing)
        mujoco.mj_forward(self.model, self.data)
        applied = self.data.qfrc_smooth + self.data.qfrc_bias
        self.data.xfrc_applied[:] = 0.0
        self.data.qacc[:] = self.speeds @ accelerations
        mujoco.mj_inverse(self.model, self.data)
        return np.asarray(self.speeds.T @ (applied - self.data.qfrc_inverse), dtype=np.float64)

    def contact(self, accelerations: Array, u: tuple[float, float], forcing: Forcing) -> tuple[float, float]:
        """Return what holds spin axis and flywheel while the device accelerates so (inverse dynamics) [Nm].

        First the moment about the ring's third axis between ring and both bodies, from the forces in the joints. Then
        the torque about the spin axis that makes it roll, which the torque on the ring must answer `gear` times.
        """
        self._load(u, forcing)
        mujoco.mj_forward(self.model, self.data)
        applied = self.data.qfrc_smooth + self.data.qfrc_bias
        self.data.qacc[:] = self.speeds @ accelerations
        mujoco.mj_rnePostConstraint(self.model, self.data)
        across = self.data.xmat[self.body["ring"]].reshape(3, 3)[:, 2]
        arm = self.data.subtree_com[self.body["float"]] - self.data.xpos[self.body["ring"]]
        joints = [self.data.cfrc_int[self.body[name]] for name in ("axis", "flywheel")]
        pressing = sum(float(across @ (joint[:3] + np.cross(arm, joint[3:]))) for joint in joints)
        self.data.xfrc_applied[:] = 0.0
        mujoco.mj_inverse(self.model, self.data)
        needed = self.data.qfrc_inverse - applied
        np.testing.assert_allclose(needed[-3], -self.gear * needed[-2], rtol=1e-9, atol=1e-9)
        return pressing, float(needed[-2])

    def tilt(self) -> Array:
        """Return phi1 and phi3 as a surveyor would: position of the float across and above, over its distance [rad]."""
        along = self.data.xmat[self.body["float"]].reshape(3, 3)[:, 1]
        return np.array([along[2], -along[0]])

    def tilt_rate(self) -> Array:
        """Return the time derivative of `tilt` on the ball joint [rad/s]."""
        frame = self.data.xmat[self.body["float"]].reshape(3, 3)
        swing = self.data.qvel[0] * frame[:, 2] - self.data.qvel[2] * frame[:, 0]
        return np.array([swing[2], -swing[0]])

    def _load(self, u: tuple[float, float], forcing: Forcing) -> None:
        data, (cc, cg) = self.data, u
        frame = data.xmat[self.body["float"]].reshape(3, 3)
        spin = data.xmat[self.body["ring"]].reshape(3, 3)[:, 0]
        psi_rate, _, omega_rate = data.qvel[-3:]
        coupling, generator = cc * (omega_rate - self.gear * psi_rate) * spin, cg * omega_rate * spin
        data.xfrc_applied[:] = 0.0
        torque = data.xfrc_applied[:, 3:]
        torque[self.body["axis"]] += coupling
        torque[self.body["ring"]] += generator
        torque[self.body["flywheel"]] -= coupling + generator
        first, third = forcing.moments
        if forcing.frame == "lever":
            torque[self.body["float"]] += first * frame[:, 0] + third * frame[:, 2]
        else:
            # phi1 > 0 moves the float along +x3, phi3 > 0 along -x1 (up). The force acts at a + b from the hinge.
            force = np.array([-third, 0.0, first]) / self.reach
            torque[self.body["float"]] += np.cross(self.reach * frame[:, 1] - data.xipos[self.body["float"]], force)
            data.xfrc_applied[self.body["float"], :3] += force


class Flight(NamedTuple):
    """Result of `free_flight`.

    Attributes
    ----------
    tilt : ndarray, shape (n, 2)
        phi1 and phi3 seen from outside [rad].
    psi : ndarray, shape (n,)
        Ring angle [rad].
    speeds : ndarray, shape (n, 4)
        w1, w3, psi', omega' [rad/s].
    """

    tilt: Array
    psi: Array
    speeds: Array


def free_flight(
    engine: Engine,
    start: Array,
    u: tuple[float, float],
    moments: Callable[[float, Array, Array], Array],
    radiation: tuple[RadiationRealisation, RadiationRealisation],
    steps: int,
    dt: float,
) -> Flight:
    """Integrate the engine's accelerations from phi = 0 with RK4, all outer forces at the float and of fixed direction.

    Parameters
    ----------
    engine : Engine
        With the hinge "no twist".
    start : ndarray, shape (5,)
        psi, w1, w3, psi', omega' at time zero. The radiation states are zero then.
    u : tuple of float
        cc, cg. [Nms]
    moments : callable
        (time, tilt, tilt rates) -> (2,): waves, springs and dampers, as moments of the linear model. [Nm]
    radiation : tuple of RadiationRealisation
        Driven by the tilt rates.
    steps, dt : int, float
        Number of steps and their length. [s]
    """

    def rate(time: float, state: Array) -> Array:
        quaternion = state[:4] / np.linalg.norm(state[:4])
        psi, speeds, memory = state[4], state[5:9], state[9:].reshape(2, -1)
        engine.place(quaternion, psi, speeds)
        tilt, tilt_rate = engine.tilt(), engine.tilt_rate()
        waves = np.array([system.p @ z for system, z in zip(radiation, memory, strict=True)])
        memory_rate = [
            system.A @ z + system.b * swing for system, z, swing in zip(radiation, memory, tilt_rate, strict=True)
        ]
        accelerations = engine.accelerations(u, Forcing(moments(time, tilt, tilt_rate) - waves, "space"))
        turning = np.zeros(4)
        mujoco.mju_mulQuat(turning, quaternion, np.array([0.0, speeds[0], 0.0, speeds[1]]))
        return np.concatenate([turning / 2, speeds[2:3], accelerations, *memory_rate])

    memory = np.zeros(sum(len(system.b) for system in radiation))
    state = np.concatenate([[1.0, 0.0, 0.0, 0.0], start, memory])
    states, tilts = [], []
    for step in range(steps + 1):
        engine.place(state[:4] / np.linalg.norm(state[:4]), state[4], state[5:9])
        states.append(state)
        tilts.append(engine.tilt())
        state = runge_kutta(rate, step * dt, state, dt)
    history = np.array(states)
    return Flight(np.array(tilts), history[:, 4], history[:, 5:9])
