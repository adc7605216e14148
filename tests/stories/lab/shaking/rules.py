"""The checker's rule: what is shaken is in the hand, which swings it aside twice."""

import numpy as np

from tamp.checking.actions.rule import carry_out, has_steps, needs_in_hand

FAR = 0.05  # of the tool from where it began, in each swing [m]


class Shake:
    """An action `shake(object)`: one motion."""

    def check(self, replay, action):
        if not has_steps(replay, action):
            return
        (name,), (move,) = action.arguments, action.steps
        needs_in_hand(replay, name)
        tools = replay.scene.links.tree.tool(move.trajectory.positions)
        away = np.linalg.norm(tools[:, :3, 3] - tools[0, :3, 3], axis=1) > FAR
        if (swings := int((away[1:] & ~away[:-1]).sum())) < 2:
            replay.report("precondition", f"{name} is swung {swings} times", (name,))
        carry_out(replay, move)
        replay.state.facts.add(("shaken", name))


RULES = {"shake": Shake()}
