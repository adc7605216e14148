"""The schema of task.yaml: strict pydantic models. Unknown fields are refused, numbers are finite."""

from __future__ import annotations

import json
import math
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from typing_extensions import Self

from tamp.task.robot import DEFAULT_ROBOT

Number = Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]
Pair = tuple[Number, Number]
PositivePair = tuple[Positive, Positive]
Triple = tuple[Number, Number, Number]
Quadruple = tuple[Number, Number, Number, Number]


def _no_truth_value(value: object) -> object:
    """What is given, unless it is `true`, which equals 1 in Python."""
    if isinstance(value, bool):
        raise ValueError(f"{value} is not valid; it must be a number 1 to 12, or 360")
    return value


Fold = Annotated[Literal[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 360], BeforeValidator(_no_truth_value)]
Name = Annotated[str, Field(max_length=64, pattern=r"^[A-Za-z0-9_][A-Za-z0-9_.-]*$")]
FactModel = Annotated[tuple[Name, ...], Field(min_length=1, description="a predicate and the names it is about")]
Function = Annotated[str, Field(pattern=r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$", description="package.module:function")]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    def _require_one(self, *names: str) -> None:
        """Refuse unless exactly one of the fields, called as the file calls them, is given."""
        fields = {field.alias or name: name for name, field in type(self).model_fields.items()}
        given = [name for name in names if getattr(self, fields[name]) is not None]
        if len(given) != 1:
            raise ValueError(f"needs exactly one of {', '.join(names)}; it has {' and '.join(given) or 'none'}")


class PoseModel(_Model):
    """Position [m] and orientation in the world frame: `rpy` [rad, fixed axes] or `quat` (x, y, z, w)."""

    xyz: Triple = Field(description="position [m]")
    rpy: Triple | None = Field(default=None, description="roll, pitch, yaw about the fixed axes x, y, z [rad]")
    quat: Quadruple | None = Field(default=None, description="in place of rpy: (x, y, z, w), of any length but zero")

    @model_validator(mode="after")
    def _one_orientation(self) -> Self:
        if self.rpy is not None and self.quat is not None:
            raise ValueError("has both rpy and quat; give one orientation")
        for angle in self.rpy or ():
            if abs(angle) > 2 * math.pi:
                raise ValueError(
                    f"rpy is in radians, up to one turn each; {angle:g} degrees are {math.radians(angle):.4f}"
                )
        if self.quat is not None and math.hypot(*self.quat) < 1e-6:
            raise ValueError("quat has length zero; no turn is [0, 0, 0, 1]")
        return self


class CylinderModel(_Model):
    """Along z, centred at the origin [m]."""

    radius: Positive = Field(description="[m]")
    height: Positive = Field(description="of a cylinder, or between the centres of a capsule's caps [m]")


class SphereModel(_Model):
    """Centred at the origin [m]."""

    radius: Positive = Field(description="[m]")


class ShapeModel(_Model):
    """One of box, cylinder, sphere, capsule, mesh [m]; a mesh's path is relative to the task file.

    A mesh that stands in for another, by its size alone, may overlap with what should lie in it.
    """

    box: tuple[Positive, Positive, Positive] | None = Field(
        default=None, description="its size along x, y, z, centred at the origin [m]"
    )
    cylinder: CylinderModel | None = Field(default=None, description="its radius and height")
    sphere: SphereModel | None = Field(default=None, description="its radius")
    capsule: CylinderModel | None = Field(default=None, description="a cylinder with half a sphere on each end")
    mesh: Annotated[str, Field(min_length=1)] | None = Field(
        default=None, description="file of a mesh (OBJ, STL, PLY, DAE); an OBJ's groups are its convex parts"
    )
    scale: Positive | None = Field(
        default=None, description="of a mesh: what its numbers are multiplied by to be metres; 1 where absent"
    )
    stand_in: bool | None = Field(
        default=None, description="of a mesh: whether it has no more than the size of one that is missing"
    )

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        self._require_one("box", "cylinder", "sphere", "capsule", "mesh")
        for name in ("scale", "stand_in"):
            if getattr(self, name) is not None and self.mesh is None:
                raise ValueError(f"{name} belongs to a mesh only")
        return self


class GoalModel(_Model):
    """One of: a pose, on a region or object, in an object."""

    pose: PoseModel | None = Field(default=None, description="where it shall stand")
    on: Name | None = Field(default=None, description="the region or object on which it shall stand, anywhere")
    in_: Name | None = Field(default=None, alias="in", description="the object in which it shall lie")

    @model_validator(mode="after")
    def _one_goal(self) -> Self:
        self._require_one("pose", "on", "in")
        return self


class SymmetryModel(_Model):
    """How many turns about each axis of its frame leave an object looking the same: 1 is none, 360 any."""

    x: Fold = Field(default=1, description="turns about x")
    y: Fold = Field(default=1, description="turns about y")
    z: Fold = Field(default=1, description="turns about z")


class InertiaModel(_Model):
    """Centre of mass and principal axes in the object's frame, and the moments about them [kg m^2]."""

    frame: PoseModel = Field(description="centre of mass and principal axes, in the object's frame")
    moments: tuple[Positive, Positive, Positive] = Field(description="principal moments about these axes [kg m^2]")


class ObjectModel(_Model):
    """A rigid object."""

    name: Name = Field(description="unique among objects and regions")
    shape: ShapeModel = Field(description="its geometry, in its own frame")
    pose: PoseModel = Field(description="where it stands at the start; it settles from there")
    goal: GoalModel | None = Field(default=None, description="where it shall be; without one it may be moved aside")
    mass: Positive = Field(default=0.1, description="[kg]")
    friction: Positive = Field(
        default=0.5, description="coefficient of lateral friction; a contact has the product of its two bodies'"
    )
    symmetry: SymmetryModel = Field(
        default=SymmetryModel(), description="what scores that know of symmetry forgive; the default score does not"
    )
    category: Name | None = Field(default=None, description="what kind of thing it is, such as cup; for statistics")
    inertia: InertiaModel | None = Field(
        default=None, description="how its mass is spread; evenly over its volume where absent"
    )


class RectangleModel(_Model):
    """A rectangle on the table top [m]."""

    center: Pair = Field(description="its middle, x and y [m]")
    size: PositivePair = Field(description="its sides along x and y [m]")


class RegionModel(_Model):
    """A named rectangle that goals may refer to."""

    name: Name = Field(description="what goals call it; unique among objects and regions")
    box: RectangleModel = Field(description="where it is; it lies within the table")


class TableModel(_Model):
    """The table top, its upper face at z = 0 [m]."""

    center: Pair = Field(default=(-0.12, 0.0), description="middle of its top, x and y [m]")
    size: PositivePair = Field(default=(0.84, 1.2), description="sides of its top along x and y [m]")
    thickness: Positive = Field(default=0.05, description="how far it reaches down from z = 0 [m]")


class LimitsModel(_Model):
    """How long planning and execution may take, where `--timeout` says nothing else."""

    planning_s: Positive = Field(
        default=60.0, description="all planning of a run [s of the clock]; tamp.plan in Python has its own timeout"
    )
    execution_sim_s: Positive = Field(default=600.0, description="all execution of a run [simulated s]")


class TaskModel(_Model):
    """A task.yaml: metres, radians, kilograms; world frame at the table's top, x away from the robot, z up."""

    name: Name | None = Field(default=None, description="what results are filed under; the file's name where absent")
    robot: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        default=DEFAULT_ROBOT, description="an installed robot, or the path of a robot.yaml"
    )
    base: PoseModel | None = Field(default=None, description="where the robot stands, if not where its data says")
    home: Annotated[tuple[Number, ...], Field(min_length=1, max_length=100)] | None = Field(
        default=None, description="joint positions that the arm starts from, if not its data's [rad]"
    )
    objects: Annotated[tuple[ObjectModel, ...], Field(min_length=1, max_length=500)] = Field(
        description="what lies on the table"
    )
    regions: tuple[RegionModel, ...] = Field(default=(), description="places on the table that goals may name")
    table: TableModel = Field(default=TableModel(), description="its top; OCRTOC 2021's where absent")
    domain: Annotated[str, Field(pattern=r"^[A-Za-z_][\w.]*(:[A-Za-z_]\w*)?$")] = Field(
        default="tabletop", description="what it is planned with: an installed domain, or package.module"
    )
    init: tuple[FactModel, ...] = Field(default=(), description="symbolic facts of the domain that hold at the start")
    goal: tuple[FactModel, ...] = Field(default=(), description="symbolic facts that shall hold at the end")
    strategy: str | None = Field(default=None, description="as --strategy")
    search: str | None = Field(default=None, description="as --search")
    motion_planner: str | None = Field(default=None, description="as --motion-planner")
    simulator: str | None = Field(default=None, description="as --simulator")
    perceive: str | None = Field(default=None, description="as --perceive: by which perceiver poses are estimated")
    samplers: dict[str, Function] = Field(
        default={}, description="stream -> package.module:function that serves it in place of the domain's own"
    )
    limits: LimitsModel = Field(default=LimitsModel(), description="how long planning and execution may take")
    level: Annotated[int, Field(ge=0, le=1000)] | None = Field(
        default=None, description="how difficult it is said to be"
    )


def main() -> None:
    """Print the JSON Schema of task.yaml."""
    print(json.dumps(TaskModel.model_json_schema(), indent=2))


if __name__ == "__main__":
    main()
