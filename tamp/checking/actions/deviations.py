"""Deviations of where a plan says that things are from where they are: each within tolerance, and all of a plan too."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.actions.arm_motion import Report
    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]


def check_strayed(
    scene: Scene, state: State, name: str, actual: Array, said: Array, allow: Tolerances, report: Report
) -> None:
    """Shifts aside, and turns, that each are within tolerance do not add up over a plan to more than it."""
    state.turned[name] = state.turned.get(name, 0.0) + angle_between(actual, said)
    if state.turned[name] > allow.turned:
        degrees = np.degrees(state.turned[name])
        report("release", f"turns of {name} that nothing explains add up to {degrees:.1f} degrees", (name,))
    way = scene.center_of_mass(name, said) - scene.center_of_mass(name, actual)
    check_shifted(state, name, float(np.hypot(way[0], way[1])), allow, report)


def check_shifted(state: State, name: str, by: float, allow: Tolerances, report: Report) -> None:
    """Another shift aside of an object [m], added to those before."""
    state.strayed[name] = state.strayed.get(name, 0.0) + by
    if state.strayed[name] > allow.strayed:
        far = state.strayed[name]
        report("release", f"shifts of {name} that nothing explains add up to {1000 * far:.1f} mm", (name,), far)


def angle_between(A: Array, B: Array) -> float:
    """Angle between the orientations of two poses [rad], by the chord, which is exact for small ones."""
    chord = float(np.linalg.norm(A[:3, :3] - B[:3, :3])) / np.sqrt(8.0)
    return 2.0 * float(np.arcsin(min(chord, 1.0)))


def check_attachment(scene: Scene, name: str, actual: Array, claimed: Array, allow: Tolerances, report: Report) -> None:
    """An object lies in the tool frame, T_tool_object of shape (4, 4), where a step claims that it does."""
    center = np.append((scene.solids[name].lower + scene.solids[name].upper) / 2, 1.0)
    shift = float(np.linalg.norm(((actual - claimed) @ center)[:3]))
    angle = angle_between(actual, claimed)
    if shift > allow.grasp or angle > allow.grasp_angle:
        sentence = f"{name} lies {1000 * shift:.1f} mm and {np.degrees(angle):.1f} degrees from where the plan says"
        report("grasp", sentence, bodies=(name,), depth=shift)
