"""The schema of robot.yaml: strict pydantic models. Unknown fields are refused, numbers are finite."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator
from typing_extensions import Self

from tamp.task.files.schema import Number, Positive, Triple

LEAST_STROKE = 0.002
"""Pads that part by less hold nothing [m]."""

Text = Annotated[str, Field(min_length=1, max_length=1000)]
Names = Annotated[tuple[Text, ...], Field(min_length=1, max_length=100)]
Numbers = tuple[Number, ...]
Limit = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]
Limits = Annotated[
    Annotated[Limit, Tag("[one]")] | Annotated[tuple[Limit, ...], Tag("[each]")],
    Discriminator(lambda value: "[each]" if isinstance(value, tuple) else "[one]"),
]
"""A value a joint, or one for all; what is wrong with it is then said of the one that was given."""


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class BaseFrameModel(_Model):
    """Where the robot stands unless a task says otherwise [m, rad], and the room it takes round its axis [m]."""

    xyz: Triple
    rpy: Triple = (0.0, 0.0, 0.0)
    radius: Positive


class ArmModel(_Model):
    """The arm's joints from the base outwards; limits that are left out are the URDF's."""

    joints: Names
    lower: Numbers | None = None
    upper: Numbers | None = None
    velocity: Limits | None = None
    effort: Limits | None = None
    acceleration: Limits
    jerk: Limits
    reach: tuple[Annotated[float, Field(ge=0, le=100)], Positive]
    home: Numbers

    @model_validator(mode="after")
    def _one_value_a_joint(self) -> Self:
        for name in ("lower", "upper", "velocity", "effort", "acceleration", "jerk", "home"):
            values = getattr(self, name)
            if isinstance(values, tuple) and len(values) != len(self.joints):
                raise ValueError(f"{name} has {len(values)} values for {len(self.joints)} joints")
        if self.reach[0] >= self.reach[1]:
            raise ValueError(f"reach is {list(self.reach)}; give two distances, the smaller one first")
        return self


class ToolModel(_Model):
    """The tool frame in the link that carries it [m, rad]: z approaches."""

    parent: Text
    xyz: Triple
    rpy: Triple = (0.0, 0.0, 0.0)


class AttachmentModel(_Model):
    """A gripper that has a URDF of its own: which link of the arm carries it, and where [m, rad]."""

    urdf: Text
    parent: Text
    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)
    prefix: Annotated[str, Field(max_length=64, pattern=r"^[A-Za-z0-9_./-]*$")] = ""


class GripperModel(_Model):
    """The gripper; joints that mimic one of `joints` are found in the URDF."""

    attach: AttachmentModel | None = None
    joints: Names
    fingers: Annotated[tuple[Text, ...], Field(min_length=2, max_length=2)]
    pads: Annotated[tuple[Triple, ...], Field(min_length=2, max_length=2)] | None = None
    limits: tuple[Number, Number] | None = None
    stroke: Positive
    force: Positive
    axis: Triple
    pad: tuple[Positive, Positive, Positive]
    depths: Annotated[tuple[Positive, ...], Field(min_length=1, max_length=10)] | None = None
    fingertip: Positive | None = None

    @model_validator(mode="before")
    @classmethod
    def _two_fingers(cls, value: Any) -> Any:
        fingers = value.get("fingers", ()) if isinstance(value, Mapping) else None
        if isinstance(fingers, Sequence) and not isinstance(fingers, str) and len(fingers) != 2:
            told = f"{len(fingers)} fingers" if fingers else "no fingers"
            raise ValueError(
                f"has {told}; name the two links between whose pads it grips. Suction cups, one moving jaw, and hands "
                "that grip with more than two fingers are not supported"
            )
        return value

    @model_validator(mode="after")
    def _pads_that_part(self) -> Self:
        if self.stroke < LEAST_STROKE:
            raise ValueError(f"stroke is {self.stroke:g}; pads that part by less than {LEAST_STROKE:g} m hold nothing")
        return self


class RobotModel(_Model):
    """A robot.yaml: metres, radians, newtons."""

    urdf: Text
    meshes: tuple[Text, ...] = ()
    base: BaseFrameModel
    arm: ArmModel
    tool: ToolModel
    gripper: GripperModel
    posture: dict[Text, Number] = {}
    disable_collisions: Annotated[tuple[tuple[Text, Text], ...], Field(max_length=1000)] = ()

    @model_validator(mode="after")
    def _room_to_work(self) -> Self:
        if self.base.radius >= self.arm.reach[1]:
            reach = list(self.arm.reach)
            raise ValueError(f"base.radius is {self.base.radius:g}: nothing would be left of arm.reach, {reach}")
        return self
