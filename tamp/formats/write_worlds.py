"""Tasks -> OCRTOC 2020's pairs of SDF 1.4 worlds, element for element as its own are."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from tamp.formats.angles import roll_pitch_yaw
from tamp.formats.models import INNER, ROW, metric_name
from tamp.task.mesh.parts import bounds
from tamp.task.model import At, Mesh, Object, Symmetry, Task
from tamp.task.pose import Pose

# A world as nested pairs (tag, content): content is text, or more pairs. A tag may carry attributes: `tag name=value`.
_LIGHTS = tuple(
    (f"light name={name} type=point", (("pose", pose), ("diffuse", color), ("specular", color)))
    for name, pose, color in (
        ("light1", "0 0 1 0 0 0", "3 3 3 1"),
        ("light2", "0 0.5 2 0 0 0", "1 1 1 1"),
        ("light3", "0 0.5 2 0 0 0", "3 3 3 1"),
    )
)
_SCENE = ("scene", (("ambient", "0.7 0.7 0.7"),))
_CONTACT = ("contact", (("ode", (("max_vel", "0"), ("min_depth", "0.0001"), ("kp", "1e8"))),))
_PHYSICS = ("physics type=ode", (
    ("max_contacts", "50"),
    ("ode", (
        ("solver", (("type", "quick"), ("iters", "75"))),
        ("constraints", (("contact_max_correcting_vel", "0"), ("contact_surface_layer", "0"))),
    )),
))  # fmt: skip


def write_worlds(task: Task, models: Mapping[str, str], folder: Path) -> Path:
    """Write `folder`/tasks/NAME/input.world and target.world, and return the first.

    Args:
        task: its goals are poses or none.
        models: object -> model.
        folder: made where absent.
    """
    path = folder / "tasks" / task.name / "input.world"
    path.parent.mkdir(parents=True, exist_ok=True)
    starts = [(o, o.pose) for o in task.objects]
    goals = [(o, o.goal.pose) for o in task.objects if isinstance(o.goal, At)]
    for name, placed, simulated in ((path, starts, True), (path.with_name("target.world"), goals, False)):
        bodies = [_body(o, models[o.name], pose, simulated) for o, pose in placed]
        world = ("world name=default", (*_LIGHTS, _SCENE, *bodies, *([_PHYSICS] if simulated else [])))
        root = _element(("sdf version=1.4", (world,)))
        ElementTree.indent(root)
        name.write_bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n")
    return path


def objects_csv(models: Mapping[str, Object]) -> str:
    """The text of objects.csv, from each model's name to some object of it at its true size; scales are undone."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(ROW)
    for name, o in models.items():
        shape = Mesh(o.shape.path) if isinstance(o.shape, Mesh) else o.shape
        lower, upper = (corner.tolist() for corner in bounds(shape))
        metric = metric_name(o.symmetry) or metric_name(Symmetry())
        spans = [value for ends in zip(lower, upper, strict=True) for value in ends]
        sizes = [high - low for low, high in zip(lower, upper, strict=True)]
        table.writerow([name, o.category or "", "", f"models/{name}", metric, *spans, *sizes])
    return text.getvalue()


def _body(o: Object, model: str, pose: Pose, simulated: bool) -> tuple[str, Any]:
    scale = o.shape.scale if isinstance(o.shape, Mesh) else 1.0
    friction = ("friction", (("ode", (("mu", repr(o.friction)), ("mu2", repr(o.friction)))),))
    inertia: tuple[Any, ...] = ()
    if o.inertia is not None:
        moments = zip(("ixx", "iyy", "izz"), map(repr, o.inertia.moments), strict=True)
        inertia = (
            ("pose", _numbers(o.inertia.frame)),
            ("inertia", (*moments, ("ixy", "0"), ("ixz", "0"), ("iyz", "0"))),
        )
    return (f"model name={o.name}", (
        (f"link name=link_{o.name}", (
            ("collision name=default", (
                _geometry(f"model://{model}/{INNER}/collision.obj", scale),
                ("surface", (friction, _CONTACT) if simulated else (friction,)),
            )),
            ("visual name=default", (_geometry(f"model://{model}/visual_meshes/visual.dae", scale),)),
            ("inertial", (("mass", repr(o.mass)), *inertia)),
        )),
        ("pose", _numbers(pose)),
    ))  # fmt: skip


def _geometry(address: str, scale: float) -> tuple[str, Any]:
    return ("geometry", (("mesh", (("uri", address), ("scale", " ".join([repr(scale)] * 3)))),))


def _numbers(pose: Pose) -> str:
    return " ".join(map(repr, (*pose.xyz, *roll_pitch_yaw(pose))))


def _element(pair: tuple[str, Any]) -> ElementTree.Element:
    head, content = pair
    tag, *attributes = head.split()
    element = ElementTree.Element(tag, dict(a.split("=", 1) for a in attributes))
    if isinstance(content, str):
        element.text = content
    else:
        element.extend(map(_element, content))
    return element
