"""The schema of task.yaml: strict pydantic models. Unknown fields are refused, numbers are finite."""

from __future__ import annotations

import json
import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator
from typing_extensions import Self

from tamp.task.robot import DEFAULT_ROBOT

Number = Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]
Pair = tuple[Number, Number]
PositivePair = tuple[Positive, Positive]
Triple = tuple[Number, Number, Number]
Quadruple = tuple[Number, Number, Number, Number]
Fold = Literal[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 360]
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

    xyz: Triple
    rpy: Triple | None = None
    quat: Quadruple | None = None

    @model_validator(mode="after")
    def _one_orientation(self) -> Self:
        if self.rpy is not None and self.quat is not None:
            raise ValueError("has both rpy and quat; give one orientation")
        if self.quat is not None and math.hypot(*self.quat) < 1e-6:
            raise ValueError("quat has length zero; no turn is [0, 0, 0, 1]")
        return self


class CylinderModel(_Model):
    """Along z, centred at the origin [m]."""

    radius: Positive
    height: Positive


class SphereModel(_Model):
    """Centred at the origin [m]."""

    radius: Positive


class ShapeModel(_Model):
    """One of box, cylinder, sphere, capsule, mesh [m]; a mesh's path is relative to the task file.

    A mesh that stands in for another, by its size alone, may overlap with what should lie in it.
    """

    box: tuple[Positive, Positive, Positive] | None = None
    cylinder: CylinderModel | None = None
    sphere: SphereModel | None = None
    capsule: CylinderModel | None = None
    mesh: Annotated[str, Field(min_length=1)] | None = None
    scale: Positive | None = None
    stand_in: bool | None = None

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        self._require_one("box", "cylinder", "sphere", "capsule", "mesh")
        for name in ("scale", "stand_in"):
            if getattr(self, name) is not None and self.mesh is None:
                raise ValueError(f"{name} belongs to a mesh only")
        return self


class GoalModel(_Model):
    """One of: a pose, on a region or object, in an object."""

    pose: PoseModel | None = None
    on: Name | None = None
    in_: Name | None = Field(default=None, alias="in")

    @model_validator(mode="after")
    def _one_goal(self) -> Self:
        self._require_one("pose", "on", "in")
        return self


class SymmetryModel(_Model):
    """How many turns about each axis of its frame leave an object looking the same: 1 is none, 360 any."""

    x: Fold = 1
    y: Fold = 1
    z: Fold = 1


class InertiaModel(_Model):
    """Centre of mass and principal axes in the object's frame, and the moments about them [kg m^2]."""

    frame: PoseModel
    moments: tuple[Positive, Positive, Positive]


class ObjectModel(_Model):
    """A rigid object; mass [kg]."""

    name: Name
    shape: ShapeModel
    pose: PoseModel
    goal: GoalModel | None = None
    mass: Positive = 0.1
    friction: Positive = 0.5
    symmetry: SymmetryModel = SymmetryModel()
    category: Name | None = None
    inertia: InertiaModel | None = None


class RectangleModel(_Model):
    """A rectangle on the table top [m]."""

    center: Pair
    size: PositivePair


class RegionModel(_Model):
    """A named rectangle that goals may refer to."""

    name: Name
    box: RectangleModel


class TableModel(_Model):
    """The table top, its upper face at z = 0 [m]."""

    center: Pair = (-0.12, 0.0)
    size: PositivePair = (0.84, 1.2)
    thickness: Positive = 0.05


class LimitsModel(_Model):
    """Budgets: planning [wall s], execution [simulated s]."""

    planning_s: Positive = 60.0
    execution_sim_s: Positive = 600.0


class TaskModel(_Model):
    """A task.yaml: metres, radians, kilograms; world frame at the table's top, x away from the robot, z up."""

    name: Name | None = Field(default=None, description="what results are filed under; the file's name where absent")
    robot: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        default=DEFAULT_ROBOT, description="an installed robot, or the path of a robot.yaml"
    )
    base: PoseModel | None = Field(default=None, description="where the robot stands, if not where its data says")
    objects: Annotated[tuple[ObjectModel, ...], Field(min_length=1, max_length=500)]
    regions: tuple[RegionModel, ...] = ()
    table: TableModel = TableModel()
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
    samplers: dict[str, Function] = {}
    limits: LimitsModel = LimitsModel()
    level: Annotated[int, Field(ge=0, le=1000)] | None = Field(
        default=None, description="how difficult it is said to be"
    )


def main() -> None:
    """Print the JSON Schema of task.yaml."""
    print(json.dumps(TaskModel.model_json_schema(), indent=2))


if __name__ == "__main__":
    main()
