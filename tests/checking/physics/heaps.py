"""Heaps in which something is put, or from which something is taken, and that do not stay as they are then.

Random search has found them (`benchmarks.stacks`): PyBullet and MuJoCo both let them rest until the change, and then
let something go by 2 cm at least, or for ever. What is put or taken is called "it". What the checker says of each
is the same when all bodies stand 10 micrometres elsewhere.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Cylinder, Object, Pose, Shape, Sphere, Task

Triple = tuple[float, float, float]


def body(name: str, shape: Shape, at: Triple, turn: Triple, mass: float, friction: float) -> Object:
    return Object(name, shape, Pose.from_rpy(at, turn), mass=mass, friction=friction)


def turned(objects: tuple[Object, ...], yaw: float) -> tuple[Object, ...]:
    """All of it turned about the vertical."""
    turn = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, yaw))
    return tuple(replace(o, pose=turn @ o.pose) for o in objects)


def scene_of(objects: tuple[Object, ...]) -> tuple[Scene, State]:
    return Scene.of(Task("heap", objects)), State({o.name: o.pose.matrix for o in objects}, np.zeros(7))


def said(check, objects: tuple[Object, ...]) -> list[str]:
    """What the checker says when "it" has come to its place, or is taken away."""
    (scene, state), sentences = scene_of(objects), list[str]()
    check(scene, state, "it", DEFAULT, lambda kind, sentence, **_: sentences.append(sentence))
    return sentences


PUT_ON_LITTLE = {
    "domino over the edge of a column, which it sinks beside by a third of a millimetre": (
        body("column", Cylinder(0.0185, 0.1133), (-0.02553, -0.10302, 0.05665), (0.0, 0.0, 0.0), 0.4, 1.0),
        body("it", Box((0.0095, 0.06, 0.1466)), (-0.00252, -0.10395, 0.18674), (0.0, 0.0, 0.0), 0.14, 0.8),
    ),
    "can on the edge of a cube that leans": (
        body("a", Box((0.0515, 0.0532, 0.0256)), (-0.02738, 0.08765, 0.01281), (0.0, 0.0, 1.512), 0.61, 0.5),
        body("b", Box((0.0444, 0.0483, 0.0545)), (-0.04166, 0.04173, 0.03897), (-0.466, -0.205, 0.071), 0.21, 0.8),
        body("it", Cylinder(0.0242, 0.1008), (-0.04416, 0.04959, 0.12843), (0.0, 0.0, 0.0), 0.08, 1.0),
    ),
    "domino on the edge of a leaning slab": (
        body("slab", Box((0.169, 0.0849, 0.0096)), (0.00319, 0.01263, 0.01833), (-0.208, -0.058, 0.007), 0.04, 1.0),
        body("column", Cylinder(0.0238, 0.0669), (-0.02016, -0.05645, 0.03343), (0.0, 0.0, 0.0), 0.12, 1.0),
        body("it", Box((0.022, 0.0492, 0.1403)), (0.04037, -0.01124, 0.10487), (0.0, 0.0, 0.0), 0.08, 1.0),
    ),
    "slab on a can that lies, beside another that it does not touch": (
        body("a", Cylinder(0.0208, 0.0663), (0.06099, -0.10692, 0.02082), (1.571, 0.0, 0.0), 0.2, 1.0),
        body("b", Cylinder(0.0298, 0.053), (0.07959, 0.01453, 0.02974), (1.571, -1.29, 0.282), 0.28, 0.8),
        body("it", Box((0.1602, 0.0553, 0.0222)), (0.05211, -0.09712, 0.06519), (0.0, 0.443, 1.571), 0.11, 1.0),
    ),
    "ball on the corner of a board that leans": (
        body("can", Cylinder(0.0222, 0.0571), (0.07294, -0.06903, 0.02853), (0.0, 0.0, 0.0), 0.91, 1.0),
        body("board", Box((0.0078, 0.0604, 0.1549)), (-0.0003, -0.10022, 0.03611), (-2.939, -1.162, -2.809), 0.33, 1.0),
        body("it", Sphere(0.0251), (0.09314, -0.09636, 0.08681), (0.0, 0.0, 0.0), 0.11, 1.0),
    ),
}
"""What it first touches does not hold it."""
TAKEN_FROM_LITTLE = {
    "cube that leans against a slab": (
        body("block", Box((0.0377, 0.042, 0.0312)), (0.05203, 0.00168, 0.01559), (0.0, 0.0, 1.571), 0.09, 0.5),
        body("it", Box((0.215, 0.1066, 0.0104)), (0.06768, -0.09394, 0.02136), (0.0, 0.151, 0.0), 0.1, 0.3),
        body("cube", Box((0.0433, 0.024, 0.0407)), (0.06111, -0.02462, 0.04104), (-0.696, 0.094, -0.076), 0.05, 1.0),
    ),
    "plank with its end on a slab": (
        body("a", Box((0.0185, 0.0787, 0.0631)), (0.10083, -0.10806, 0.00924), (-1.539, 1.571, -1.539), 1.02, 0.3),
        body("it", Box((0.1998, 0.0726, 0.0155)), (0.02624, 0.02583, 0.01375), (-0.169, 0.0, 0.002), 0.1, 1.0),
        body("plank", Box((0.2202, 0.0422, 0.02)), (0.08736, -0.06717, 0.03374), (0.011, -0.064, 1.398), 0.04, 0.3),
    ),
    "two that lean on each other, one of them over a card": (
        body("it", Box((0.0848, 0.0735, 0.0085)), (0.08527, -0.10392, 0.00421), (0.0, 0.0, 0.0), 0.06, 0.8),
        body("a", Box((0.0209, 0.0549, 0.0722)), (0.09166, -0.05009, 0.0454), (-0.534, 0.041, -0.037), 0.07, 0.8),
        body("b", Box((0.0491, 0.0225, 0.0666)), (0.11451, -0.10484, 0.04259), (0.561, 0.0, 2.776), 0.2, 0.5),
    ),
}
"""What is left leans on too little."""
PUT_ON_LEANING = {
    "a can on a slab that slopes by a degree": (
        body(
            "o0", Box((0.19373, 0.11352, 0.01093)), (0.05038, -0.06146, 0.00544), (-0.0001, 0.0001, 1.5704), 0.049, 0.8
        ),
        body("o1", Box((0.01733, 0.07119, 0.1439)), (0.13393, -0.08686, 0.01661), (3.1399, 1.4593, 3.1401), 0.049, 0.3),
        body("o2", Cylinder(0.02367, 0.09626), (-0.02489, -0.15143, 0.0315), (1.8187, -0.7842, -1.7588), 0.041, 0.3),
        body(
            "o4", Box((0.0125, 0.05981, 0.19287)), (-0.04645, 0.07318, 0.00624), (-0.8117, 1.5708, 0.8669), 0.216, 0.8
        ),
        body("o5", Box((0.12313, 0.06032, 0.02721)), (0.01259, -0.02271, 0.0255), (0.0336, -0.0001, 0.975), 0.077, 0.3),
        body("it", Cylinder(0.02828, 0.0998), (-0.00638, -0.03004, 0.06849), (1.5708, 0.0, 1.5708), 0.121, 0.8),
    ),
    "a column on the top of a ball": (
        body("o0", Box((0.0497, 0.05436, 0.05747)), (-0.02119, -0.08383, 0.02873), (0.0, 0.0, 1.573), 0.031, 1.0),
        body("o1", Box((0.16932, 0.06404, 0.01022)), (-0.115, -0.08167, 0.0051), (3.1416, 0.0, 1.5723), 0.241, 0.3),
        body("o2", Box((0.02262, 0.04194, 0.15585)), (0.022, 0.03394, 0.02096), (-1.5708, 0.0005, -0.1366), 0.217, 0.8),
        body("o3", Sphere(0.03204), (0.10403, 0.06858, 0.03203), (0.0, 0.0, 1.5708), 0.1, 1.0),
        body("o4", Box((0.03822, 0.02868, 0.04677)), (0.03137, 0.08344, 0.0653), (0.0003, -0.0003, 2.3532), 0.437, 0.3),
        body("o5", Box((0.00855, 0.05484, 0.13371)), (-0.02845, 0.12184, 0.06683), (0.0, 0.0003, 1.5708), 0.081, 0.5),
        body("it", Cylinder(0.01514, 0.09364), (0.07192, 0.07356, 0.10577), (0.0, 0.0, 2.4244), 0.281, 0.3),
    ),
    "a box that tips against a domino, which leans on the slab under it": (
        body("a", Box((0.012, 0.06, 0.0145)), (0.0666, -0.1729, 0.00725), (0.0, 0.0, 1.5708), 2.0, 1.0),
        body("b", Box((0.012, 0.06, 0.0326)), (0.0667, -0.0823, 0.0163), (0.0, 0.0, 1.5708), 2.0, 1.0),
        body("slab", Box((0.1324, 0.0837, 0.0195)), (0.06685, -0.12952, 0.03386), (0.0199, -0.1969, 1.5701), 1.4, 0.5),
        body(
            "domino", Box((0.0172, 0.0673, 0.0747)), (0.14075, -0.14507, 0.03065), (3.1398, 0.8708, 3.1292), 0.095, 0.3
        ),
        body("it", Box((0.08, 0.06, 0.018)), (0.07426, -0.083, 0.0661), (0.0, 0.0, 0.0), 0.2, 1.5),
    ),
}
"""What it is put on is in balance by itself, on a slope or on something round."""
TAKEN_FROM_LEANING = {
    "slab that leans on a ball, and by its edge on a rod that it does not touch": (
        body("it", Sphere(0.0189), (0.10278, 0.01811, 0.01889), (0.2003, -0.029, 0.6772), 0.091, 0.5),
        body("a", Box((0.0288, 0.0221, 0.0528)), (0.18139, -0.01122, 0.02666), (0.0012, -0.0173, 1.5711), 0.576, 0.8),
        body("b", Box((0.0989, 0.0602, 0.0261)), (0.13538, 0.04241, 0.03117), (0.6919, 0.0392, 1.6411), 1.182, 1.5),
        body("c", Box((0.2315, 0.0729, 0.0219)), (0.10623, 0.06035, 0.06513), (-0.0059, -0.4981, 0.0106), 0.121, 0.8),
        body("d", Box((0.2087, 0.0084, 0.0124)), (0.1394, -0.01633, 0.04451), (1.5723, -0.4004, 0.0188), 0.037, 1.5),
    ),
    "two slabs that lie on each other and on what is taken": (
        body("it", Box((0.04574, 0.02024, 0.02619)), (-0.02079, -0.09574, 0.01308), (0.0, 0.0001, -0.0185), 0.328, 0.5),
        body(
            "o1", Box((0.21923, 0.06677, 0.02589)), (-0.06787, -0.07671, 0.03651), (0.0009, 0.2199, 1.7651), 0.031, 1.0
        ),
        body("o2", Box((0.235, 0.11768, 0.01951)), (0.04469, 0.06215, 0.02768), (-0.2239, 0.0437, 0.1123), 0.111, 0.3),
        body(
            "o3",
            Box((0.03983, 0.04764, 0.05371)),
            (-0.14308, -0.06663, 0.01991),
            (-0.0149, -1.5708, -0.1065),
            0.216,
            1.0,
        ),
        body(
            "o4", Box((0.227, 0.09135, 0.01505)), (0.02354, 0.05972, 0.04635), (-0.2279, -0.0094, -0.1179), 0.039, 1.0
        ),
        body("o5", Box((0.13494, 0.06746, 0.01214)), (-0.21368, -0.13805, 0.00605), (3.1414, 0.0, 2.2572), 0.649, 0.5),
    ),
    "two slabs that lean on each other": (
        body("it", Box((0.02494, 0.04237, 0.02641)), (0.06366, 0.04105, 0.01319), (0.0001, 0.0, 1.4306), 0.096, 0.3),
        body("o1", Box((0.04224, 0.04943, 0.02026)), (0.00277, 0.08986, 0.01012), (-0.0001, 0.0, 0.0), 0.4, 0.3),
        body("o3", Box((0.24135, 0.05128, 0.02459)), (0.09787, -0.04299, 0.0238), (-0.5454, 0.0, 2.5247), 0.055, 1.0),
        body(
            "o4", Box((0.11259, 0.09946, 0.01142)), (0.00809, -0.06195, 0.02235), (-0.2049, -0.1205, 2.3239), 0.057, 0.3
        ),
        body("o5", Cylinder(0.02849, 0.06529), (-0.00076, 0.09873, 0.05288), (0.0003, 0.0, 2.774), 0.412, 0.5),
    ),
    "a slab that stands against a can": (
        body("it", Cylinder(0.0249, 0.0582), (-0.02131, 0.06615, 0.02489), (1.5708, 0.6786, 1.5672), 0.396, 0.3),
        body("o1", Box((0.04639, 0.0444, 0.04205)), (-0.025, 0.11857, 0.02101), (0.0, 0.0, 1.712), 0.819, 1.0),
        body(
            "o2", Box((0.10784, 0.08752, 0.01714)), (0.00358, 0.01194, 0.03686), (-0.008, -0.5766, 2.2572), 0.142, 0.8
        ),
        body("o3", Cylinder(0.03154, 0.04008), (0.08729, 0.03616, 0.03153), (1.5708, -0.4761, -0.0073), 1.446, 0.8),
    ),
    "a card that stands, held by a can that lies": (
        body("it", Cylinder(0.02937, 0.09911), (-0.00015, 0.09836, 0.02936), (1.5708, -0.1687, -0.0008), 0.192, 1.0),
        body("o1", Cylinder(0.01664, 0.11795), (0.15269, 0.12605, 0.01657), (1.5743, 1.2542, -1.4431), 0.034, 0.5),
        body("o2", Box((0.00671, 0.06477, 0.08912)), (0.07379, 0.14743, 0.02593), (1.585, 0.7749, 2.1925), 0.152, 0.8),
        body("o3", Box((0.04208, 0.05734, 0.03447)), (-0.01366, -0.06228, 0.01723), (0.0, 0.0, 0.0247), 0.528, 0.5),
        body("o4", Box((0.22363, 0.04268, 0.01213)), (0.14856, 0.1654, 0.03092), (-0.0294, 0.22, 1.5656), 0.665, 0.3),
    ),
}
"""What is left leans on each other and slumps."""
