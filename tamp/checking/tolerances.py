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
        grasp: distance between where an object lies and where a grip says it lies.
        grasp_angle: the same for its orientation.
        pad: how far from a pad's final place the surface it touches may be.
        drop: how far a released object may fall or shift until it stands (displacement of the score's cube).
        fall: how far an object may fall straight down after it was let go.
        tilt: largest turn of an object that falls flat after it was let go.
        topple: the same after it was pushed over.
        level: how far the axis of that turn may be from level.
        push: angle between a push and the way in which fingers press; the cone of their friction is wider.
        nudge: angle between a nudge and the way in which a fingertip presses on a flank that may be round.
        nudged: longest nudge: what one finger pushes leaves its line the farther it goes.
        lever: how far the contacts of a push reach on both sides of the centre of mass.
        beyond: how far beyond the edge that it turns about the hand pushes a toppled object's centre of mass.
        edge: how far inside what carries it the centre of mass of a pushed object stays.
        standing: largest gap between a body and what it stands on.
        balance: how far inside its support polygon a centre of mass must lie.
        reached: displacement between a final pose and the goal it stands for.
        settling: displacement between a task's pose and the settled pose that the plan takes for it.
        falling: the same where the scene as it is written cannot stay as it is.
        velocity: share by which joint velocities may exceed their limits at the samples.
        between: the same between samples, where the cubic curve is only near the motion that was timed.
        acceleration: share by which accelerations may exceed their limits.
        joint: error of joint positions, at limits and where two motions meet.
        rest: joint velocity that counts as standing still.
    """

    step: float = 0.005
    collision: float = 0.001
    contact: float = 0.004
    grasp: float = 0.002
    grasp_angle: float = 0.02
    pad: float = 0.004
    drop: float = 0.015
    fall: float = 0.17
    tilt: float = 1.2
    topple: float = 1.7
    level: float = 0.05
    push: float = 0.4
    nudge: float = 1.1
    nudged: float = 0.05
    lever: float = 0.005
    beyond: float = 0.02
    edge: float = 0.01
    standing: float = 0.003
    balance: float = 0.001
    reached: float = 0.005
    settling: float = 0.03
    falling: float = 0.25
    velocity: float = 0.001
    between: float = 0.02
    acceleration: float = 0.005
    joint: float = 1e-4
    rest: float = 1e-3


DEFAULT = Tolerances()
