"""How far a plan may stray before the checker calls it wrong. Every number a verdict rests on stands here."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Tolerances:
    """Bounds of the checker; metres, radians, seconds, shares.

    Attributes:
        step: largest motion of any point of robot or held object between two collision samples.
        collision: penetration that counts as numerical noise.
        contact: penetration allowed between bodies that may touch: geometry is convex pieces, and objects settle.
        sunk: the same of what stands beside or on one another and is convex, or stands on the table.
        pieces: the same of what stands beside or on one another and is of several convex pieces, such as thin walls.
        grasp: distance between where an object lies and where a grip says it lies.
        grasp_angle: the same for its orientation.
        pad: how far from a pad's final place the surface it touches may be.
        flush: displacement by which pads turn what they close on, until it lies flush between them.
        bulging: the same of what is of several pieces, which bulge beyond the surface that they stand for.
        drop: how far down a released object may go until it stands.
        slump: how far an object may tilt when something it leaned on leaves (displacement of the score's cube).
        strayed: how far shifts within tolerance, at grips, releases and pushes, may take an object aside in a plan.
        turned: how far turns within tolerance may turn an object in a plan.
        opened: least distance by which the fingers open to let go.
        fall: how far an object may fall straight down after it was let go.
        skid: how much farther than friction or ice explain the edge may slide that something falls over.
        tilt: largest turn of an object that falls flat after it was let go.
        leaving: how long the fingers may take to leave what falls as they do [s].
        topple: the same turn after it was pushed over.
        level: how far the axis of that turn may be from level.
        twist: the same of what falls over a corner, as far as its centre of mass is beside that (vertical share).
        corner: how much farther than over an edge it may slide then, and no farther than its centre of mass is beside.
        push: angle between a push and the way in which fingers press; the cone of their friction is wider.
        nudge: angle between a nudge and the way in which a fingertip presses on a flank that may be round.
        nudged: farthest that an object is nudged between two grips: what one finger pushes leaves its line the farther
            it goes.
        lever: how far the contacts of a push reach on both sides of the centre of mass.
        beyond: how far beyond the edge that it turns about the hand pushes a toppled object's centre of mass.
        edge: how far inside what carries it the centre of mass of a pushed object stays.
        standing: largest gap between a body and what it stands on.
        sagging: how far a stack may come down in all until each of its bodies touches what it stands on.
        sinking: how far the bodies of a stack may be in each other in all, from the topmost to the table.
        slack: how far a stack may give until something more carries it.
        balance: how far inside its support polygon a centre of mass must lie.
        reached: displacement between a final pose and the goal it stands for.
        placed: displacement between where an object stays in the task, and where it is said to stand.
        veered: turn about the vertical of what stays in the task.
        sagged: how far a stack may give way when something that it leaned on leaves.
        touching: gap between a body that has come to a place and what it certainly touches there.
        firm: the same gap as `standing` of what is certain to stand where the task has it.
        leaning: how far off upright that must stay in balance [rad].
        settling: the same of what does not stay, or touches what does not.
        jostling: the same of what touches objects that do not stay and are said to move.
        dropped: a fall from which an object stays wherever it is in balance.
        steady: how far inside what carries it the centre of mass is of what has fallen and stays there, as a share of
            its radius; half of that is enough for what did not fall.
        bounce: share of a fall that may tip or roll on what has come down.
        rolling: share of a fall that certainly does, where nothing holds it.
        rocking: the same as a share of the height of its centre of mass; the lesser of both counts.
        falling: the farthest that settling takes what falls, tips or rolls.
        velocity: share by which joint velocities may exceed their limits.
        acceleration: the same of accelerations; positions in a plan file are rounded.
        jerk: the same of jerks.
        period: between two commands to the arm [s]; accelerations jump no further in one than the limit of jerk allows.
        joint: error of joint positions, at limits and, in all, where two motions meet.
        rest: joint velocity that counts as standing still.
    """

    step: float = 0.005
    collision: float = 0.001
    contact: float = 0.004
    sunk: float = 0.002
    pieces: float = 0.003
    grasp: float = 0.002
    grasp_angle: float = 0.02
    pad: float = 0.002
    flush: float = 0.012
    bulging: float = 0.018
    drop: float = 0.015
    slump: float = 0.015
    strayed: float = 0.005
    turned: float = 0.03
    opened: float = 0.001
    fall: float = 0.17
    skid: float = 0.005
    tilt: float = 1.2
    leaving: float = 3.0
    topple: float = 1.7
    level: float = 0.05
    twist: float = 0.5
    corner: float = 0.02
    push: float = 0.4
    nudge: float = 1.1
    nudged: float = 0.05
    lever: float = 0.005
    beyond: float = 0.02
    edge: float = 0.01
    standing: float = 0.003
    sagging: float = 0.006
    sinking: float = 0.003
    slack: float = 0.003
    balance: float = 0.001
    reached: float = 0.005
    placed: float = 0.006
    veered: float = 0.05
    sagged: float = 0.02
    touching: float = 0.0003
    firm: float = 0.001
    leaning: float = 0.05
    settling: float = 0.015
    jostling: float = 0.03
    dropped: float = 0.002
    steady: float = 0.2
    bounce: float = 0.1
    rolling: float = 0.002
    rocking: float = 0.01
    falling: float = 0.25
    velocity: float = 0.001
    acceleration: float = 0.02
    jerk: float = 0.02
    period: float = 0.001
    joint: float = 1e-4
    rest: float = 1e-3


DEFAULT = Tolerances()
