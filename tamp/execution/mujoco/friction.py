"""Coulomb's friction where MuJoCo's own differs from it; what a step's contacts are asked for is mended half way.

MuJoCo asks each contact for an acceleration: `-B v` along it, `-B v - K depth` across it, v being the velocity of its
two bodies against each other. Three things are not as they should be then:

- What slides is pushed apart. In MuJoCo's convex cone the normal acceleration of a contact that slides is higher by the
  coefficient of friction times what is asked for along it and not had: 20 m/s^2 at 0.1 m/s with contacts as stiff as
  those of grips. So it hops, touches in an eighth of the steps with eight times the force, and what leans on a finger
  that draws back is kicked aside. The same is therefore taken off what is asked for across it.
- What turns along drifts. MuJoCo takes the acceleration of two points against each other for `J dv/dt`, without
  `dJ/dt v`, by which a point of a hand that swings round is pulled inwards: what the hand holds stays behind by 1 to
  2 mm in a metre of its way. So that is asked for too, less the half of it that comes of moving all through a step
  with the velocity at its end.
- Between two objects MuJoCo takes the larger coefficient; a task's contacts have the product.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ROWS = 6
"""Of a contact in MuJoCo's constraints: across it, two along it, about its normal, two of rolling."""


class Coulomb:
    """Mends what the contacts of a step are asked for, between MuJoCo's first half of it and the second.

    Args:
        model: MuJoCo's; all its contacts have six dimensions.
        links: which bodies are links of the robot, shape (bodies,).
    """

    def __init__(self, model: Any, links: NDArray[np.bool_]) -> None:
        self._model, self._links = model, links
        self._body = np.array(model.geom_bodyid)
        self._own = np.array(model.geom_friction[:, 0])
        self._jac = np.zeros((2, 3, model.nv))
        self._linear, self._angular = np.zeros((2, model.nbody, 3))
        self._turn = np.zeros((model.nbody, 3, 3))

    def mend(self, data: Any) -> None:
        """Mend the contacts of the step that `data`, MuJoCo's, is half way through."""
        contacts = data.contact
        address, geoms, friction, mu = contacts.efc_address, contacts.geom, contacts.friction, contacts.mu
        least = np.minimum(self._own[geoms[:, 0]], self._own[geoms[:, 1]])
        if least.any():  # else one of the two is the table or the robot, which have none
            least[least == 0.0] = 1.0
            friction[:, :2] *= least[:, None]
            mu *= least
        touching = np.flatnonzero(address >= 0)
        if not len(touching):
            return
        start, end = address[touching[0]], address[touching[-1]] + ROWS
        asked = data.efc_aref[start:end].reshape(-1, ROWS)
        asked[:, 0] -= np.sqrt(((friction[touching] * asked[:, 1:]) ** 2).sum(axis=1))
        bodies = self._body[geoms[touching]]
        some = np.flatnonzero(self._links[bodies].any(axis=1))
        if len(some):
            those, damping = touching[some], data.efc_KBIP[start:end, 1].reshape(-1, ROWS)[some, 1:]
            turning = self._turning(data, bodies[some], contacts.pos[those], contacts.frame[those].reshape(-1, 3, 3))
            asked[some, 1:] -= (1.0 - damping * self._model.opt.timestep / 2.0) * turning

    def _turning(self, data: Any, bodies: NDArray[np.int_], points: Array, frames: Array) -> Array:
        """`dJ/dt v` of the rows of contacts but the first, shape (n, 5) [m/s^2], [rad/s^2].

        Args:
            data: MuJoCo's.
            bodies: the two bodies of each contact, shape (n, 2).
            points: where they touch (world frame), shape (n, 3) [m].
            frames: the contacts' axes as rows, the normal first, shape (n, 3, 3).
        """
        for link in sorted({*bodies[self._links[bodies]].tolist()}):  # what is no link turns about its own origin only
            mujoco.mj_jacDot(self._model, data, self._jac[0], self._jac[1], data.xpos[link], link)
            self._linear[link], self._angular[link] = self._jac @ data.qvel
            x, y, z = self._angular[link]
            self._turn[link] = (0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)
        spin, arm = data.cvel[bodies, :3], points[:, None] - data.xpos[bodies]
        pull = spin * (spin * arm).sum(axis=2, keepdims=True) - arm * (spin * spin).sum(axis=2, keepdims=True)
        linear = self._linear[bodies] + (self._turn[bodies] @ arm[..., None])[..., 0] + pull
        angular = self._angular[bodies]
        both = np.stack([linear[:, 1] - linear[:, 0], angular[:, 1] - angular[:, 0]], axis=2)
        found: Array = (frames @ both).transpose(0, 2, 1).reshape(-1, ROWS)[:, 1:]
        return found
