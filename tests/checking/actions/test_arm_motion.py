from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.checking import check
from tamp.checking.actions.arm_motion import finger_touches
from tamp.checking.check import begin
from tamp.checking.geometry.solids import Solid, clearance
from tamp.checking.geometry.transforms import inverse
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Action, Box, Cylinder, Move, Object, Plan, Pose, Sphere, Task, load_robot
from tamp.task.mesh.parts import parts
from tests.checking.handmade import DOWN, OPEN, Hand, above, solve_ik, two_boxes

HOME = two_boxes()[1].home
TOP, TIP = 0.05, 0.00885  # of the box, and of the fingers under the tool's point [m]


def brushing(depth, along):
    """A finger of the open hand comes down on a box until it is so deep in it, and goes along it so far [m]."""
    box = Object("red", Box((0.05, 0.05, TOP)), Pose((0.05, 0.045, TOP / 2)))
    hand, z = Hand(HOME), TOP + TIP - depth
    first, last = Pose((0.05, 0.0, z), DOWN), Pose((0.05 + along, 0.0, z), DOWN)
    ways = [hand.free(above(first, 0.1)), hand.line(first), hand.line(last), hand.line(above(last, 0.1))]
    action = Action("move", (), tuple(Move("transit", way, OPEN) for way in ways))
    return Task("brush", (box,)), Plan("brush", "panda", 0, {"red": box.pose}, HOME, {}, (action,))


@pytest.mark.parametrize(
    ("depth", "along", "taken"),
    [(0.0006, 0.06, True), (0.0001, 0.06, True), (0.0006, 0.002, False), (0.0, 0.06, False)],
)
def test_what_the_hand_presses_on_as_it_slides_over_it_comes_along(depth, along, taken):
    """A box of 50 mm went along by 88 mm with a finger 0.1 mm in its top in PyBullet, 0.19 mm in it in MuJoCo too."""
    found = [problem.sentence for problem in check(*brushing(depth, along)).problems]
    assert any("finger presses on red as it slides over it" in sentence for sentence in found) == taken


@pytest.mark.parametrize(
    ("shape", "turn", "front", "rolls"),
    [
        (Cylinder(0.03, 0.1), np.pi / 2, 0.0091, True),
        (Sphere(0.03), 0.0, 0.009, True),
        (Box((0.06, 0.06, 0.06)), 0.0, 0.0105, False),
        (Cylinder(0.03, 0.06), None, 0.0105, False),  # at its end
    ],
)
@pytest.mark.parametrize("depth", [0.0009, -0.001])
def test_what_rolls_is_not_pushed_by_a_millimetre(shape, turn, front, rolls, depth):
    """A finger, which reaches so far ahead of the tool, stops in it and goes back.

    In both simulators a can rolls on by 9 cm, and a box stays.
    """
    rpy = (0.0, np.pi / 2, 0.0) if turn is None else (turn, 0.0, 0.0)
    thing = Object("red", shape, Pose.from_rpy((0.15, 0.045, 0.03), rpy))
    hand = Hand(HOME)
    first, last = (Pose((0.119 - front + by, 0.0, 0.03), DOWN) for by in (-0.08, 0.001 + depth))
    ways = [hand.free(above(first, 0.1)), *map(hand.line, (first, last, first, above(first, 0.1)))]
    action = Action("move", (), tuple(Move("transit", way, OPEN) for way in ways))
    plan = Plan("poke", "panda", 0, {"red": thing.pose}, HOME, {}, (action,))
    said = [problem.sentence for problem in check(Task("poke", (thing,)), plan).problems]
    assert any("pushes red, which rolls or tips over" in sentence for sentence in said) == (rolls and depth > 0.0), said
    assert said or not rolls or depth < 0.0


@pytest.mark.parametrize(("shape", "rolls"), [(Cylinder(0.03, 0.1), True), (Box((0.06, 0.06, 0.1)), False)])
def test_fingers_that_open_push_nothing_that_rolls(shape, rolls):
    """It is brought nearer until they are said to touch it: a can that lies at once, a box a millimetre deep."""
    q = np.array(solve_ik(Pose((0.05, 0.2, 0.03), DOWN), HOME))
    for y in np.arange(0.3, 0.27, -0.0002):
        thing = Object("red", shape, Pose.from_rpy((0.05, y, 0.03), (0.0, np.pi / 2, 0.0)))
        scene, state = Scene.of(Task("open", (thing,))), State({"red": thing.pose.matrix}, q)
        if found := finger_touches(scene, state, 0.05, OPEN, {}, DEFAULT):
            assert (found[0].depth < 0.0005) == rolls
            return
    pytest.fail("no finger touches it")


@pytest.mark.parametrize(("lower", "jams"), [(0.0, False), (0.0007, True)])
def test_fingers_that_swing_as_they_close_do_not_press_on_the_table(lower, jams):
    """A 2F-85's tips come down by 13 mm as they close: in PyBullet they stuck there, and the object stayed behind."""
    pytest.importorskip("airo_models", reason="the extra 'ur5e' is missing")
    spec = load_robot("ur5e_2f85")
    shelf = Task("swing", (Object("red", Box((0.02, 0.05, 0.03)), Pose((0.4, 0.3, 0.015))),), robot=spec.name)
    scene = Scene.of(shelf)
    q, stroke = np.array(spec.home), spec.gripper.stroke
    fingers = [solid for solid in scene.links.solids if solid.name in scene.links.gripper]

    def lowest(opening: float) -> float:
        placed = scene.links.tree.forward(q[None], opening)
        return min((s.hull.part.vertices @ placed[s.name][0, 2, :3] + placed[s.name][0, 2, 3]).min() for s in fingers)

    low = min(map(lowest, np.linspace(0.0, stroke, 100)))
    assert lowest(stroke) > low + 0.01
    table = np.eye(4)
    table[:3, 3] = (*shelf.table.center, low + lower - shelf.table.thickness / 2)
    scene = replace(scene, T_world_table=table)
    state = State({"red": shelf.objects[0].pose.matrix}, q, stroke)
    touched = {touch.bodies[0] for touch in finger_touches(scene, state, stroke, 0.0, {}, DEFAULT)}
    assert touched == ({"table"} if jams else set())


@pytest.mark.parametrize("put_there", [False, True])
def test_the_base_pushes_nothing_that_has_leant_on_it_all_the_while(put_there):
    """What comes to rest against the base is a little in it; no plan began from there."""
    ball = Object("red", Sphere(0.03), Pose((0.0, 0.0, 0.03)))
    links = Scene.of(Task("base", (ball,))).links
    (base,) = (solid for solid in links.solids if solid.name == "panda_link0")
    body, T_base = Solid.of("red", parts(ball.shape)), links.tree.spec.T_world_base.matrix
    near, far = T_base[0, 3], 0.0
    for _ in range(30):
        x = (near + far) / 2
        T = Pose((x, 0.0, 0.03)).matrix
        near, far = (x, far) if clearance(base, body, inverse(T_base) @ T, 0.0) < -0.0005 else (near, x)
    task = Task("base", (replace(ball, pose=Pose((x, 0.0, 0.03))),))
    start = {"red": task.objects[0].pose}
    way = Hand(HOME).free(Pose((0.2, 0.2, 0.3), DOWN))
    plan = Plan("base", "panda", 0, start, HOME, {}, (Action("move", (), (Move("transit", way, OPEN),)),))
    state = begin(task, start, ())
    verdict = check(task, plan, start=start, after=replace(state, began={}) if put_there else state)
    assert any("panda_link0 pushes red" in problem.sentence for problem in verdict.problems) == put_there
