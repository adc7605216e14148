"""From a parsed JSON document to a plan: every value checked, every error naming file and field."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tamp.errors import PlanError
from tamp.task.plan import Action, Attachment, Fall, Grip, Move, Plan, Release, Step, Trajectory
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

FORMAT = "tamp-plan"
VERSION = 1
LARGEST = 1e6
"""No number of a plan is larger, whatever its unit: beyond, squares overflow."""


class PlanReader:
    """Turns a parsed JSON document into a plan, refusing whatever does not fit.

    In its methods `field` says where in the document a value stands, for the error that may have to name it.

    Args:
        path: the file, to be named in errors.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def plan(self, document: Any) -> Plan:
        """The plan of a whole document; PlanError where there is none in it."""
        head = self.mapping(document, "document")
        if head.get("format") != FORMAT:
            raise self.error("format", f'must be "{FORMAT}"')
        if type(head.get("version")) is not int or head["version"] != VERSION:
            raise self.error("version", f"must be {VERSION}, the version that this program reads")
        keys = ("format", "version", "task", "robot", "seed", "start", "home", "goals", "actions", "report")
        given = self.record({"report": {}, **head}, "document", keys)
        actions = self.sequence(given["actions"], "actions")
        return Plan(
            task=self.text(given["task"], "task"),
            robot=self.text(given["robot"], "robot"),
            seed=self.integer(given["seed"], "seed"),
            start=self.poses(given["start"], "start"),
            home=tuple(self.numbers(given["home"], "home")),
            goals=self.poses(given["goals"], "goals"),
            actions=tuple(self.action(a, f"actions[{i}]") for i, a in enumerate(actions)),
            report=self.mapping(given["report"], "report"),
        )

    def action(self, value: Any, field: str) -> Action:
        """One action."""
        given = self.record(value, field, ("name", "arguments", "steps"))
        arguments = self.sequence(given["arguments"], f"{field}.arguments")
        steps = self.sequence(given["steps"], f"{field}.steps")
        return Action(
            name=self.text(given["name"], f"{field}.name"),
            arguments=tuple(self.text(a, f"{field}.arguments[{i}]") for i, a in enumerate(arguments)),
            steps=tuple(self.step(step, f"{field}.steps[{i}]") for i, step in enumerate(steps)),
        )

    def step(self, value: Any, field: str) -> Step:
        """One step: a mapping with a single key that says which."""
        given = self.mapping(value, field)
        if len(given) != 1 or next(iter(given)) not in ("move", "grip", "release", "fall"):
            raise self.error(field, 'must have exactly one key, "move", "grip", "release" or "fall"')
        if "move" in given:
            return self.move(given["move"], f"{field}.move")
        if "grip" in given:
            return self._grip(given["grip"], f"{field}.grip")
        if "fall" in given:
            fall = self.record(given["fall"], f"{field}.fall", ("object", "pose"))
            return Fall(
                self.text(fall["object"], f"{field}.fall.object"), self.pose(fall["pose"], f"{field}.fall.pose")
            )
        release = self.record(given["release"], f"{field}.release", ("object", "pose", "opening"))
        return Release(
            object=self.text(release["object"], f"{field}.release.object"),
            pose=self.pose(release["pose"], f"{field}.release.pose"),
            opening=self.number(release["opening"], f"{field}.release.opening"),
        )

    def move(self, value: Any, field: str) -> Move:
        """A motion."""
        keys = ("phase", "opening", "held", "contacts", "times", "positions", "velocities", "pushed")
        given = self.record({"pushed": None, **self.mapping(value, field)}, field, keys)
        pairs = [
            self.sequence(p, f"{field}.contacts[{i}]") for i, p in enumerate(self.sequence(given["contacts"], field))
        ]
        if any(len(pair) != 2 or not all(isinstance(b, str) and b.isprintable() for b in pair) for pair in pairs):
            raise self.error(f"{field}.contacts", "must hold pairs of names")
        times = self.array(given["times"], f"{field}.times", 1)
        positions, velocities = (self.array(given[key], f"{field}.{key}", 2) for key in ("positions", "velocities"))
        if positions.shape != velocities.shape or len(positions) != len(times):
            raise self.error(field, "times, positions and velocities must have one row for each sample")
        return Move(
            phase=self.text(given["phase"], f"{field}.phase"),
            trajectory=Trajectory(times, positions, velocities),
            opening=self.number(given["opening"], f"{field}.opening"),
            held=None if given["held"] is None else self.attachment(given["held"], f"{field}.held"),
            contacts=frozenset((pair[0], pair[1]) for pair in pairs),
            pushed=None if given["pushed"] is None else self.attachment(given["pushed"], f"{field}.pushed"),
        )

    def _grip(self, value: Any, field: str) -> Grip:
        """A closing of the fingers."""
        given = self.record(value, field, ("object", "T_tool_object", "width"), ("force",))
        attachment = self.attachment({key: given[key] for key in ("object", "T_tool_object")}, field)
        force = self.number(given["force"], f"{field}.force") if "force" in given else None
        return Grip(attachment, self.number(given["width"], f"{field}.width"), force)

    def attachment(self, value: Any, field: str) -> Attachment:
        """An object in the tool frame."""
        given = self.record(value, field, ("object", "T_tool_object"))
        return Attachment(
            self.text(given["object"], f"{field}.object"), self.pose(given["T_tool_object"], f"{field}.T_tool_object")
        )

    def poses(self, value: Any, field: str) -> dict[str, Pose]:
        """Poses by name."""
        given = {self.text(name, f"{field}, a name in it,"): pose for name, pose in self.mapping(value, field).items()}
        return {name: self.pose(pose, f"{field}.{name}") for name, pose in given.items()}

    def pose(self, value: Any, field: str) -> Pose:
        """A pose."""
        given = self.record(value, field, ("xyz", "quat"))
        xyz, quat = self.numbers(given["xyz"], f"{field}.xyz"), self.numbers(given["quat"], f"{field}.quat")
        if len(xyz) != 3 or len(quat) != 4:
            raise self.error(field, "needs three numbers for xyz and four for quat")
        try:
            return Pose((xyz[0], xyz[1], xyz[2]), (quat[0], quat[1], quat[2], quat[3]))
        except ValueError as error:
            raise self.error(field, str(error)) from error

    def array(self, value: Any, field: str, dimensions: int) -> NDArray[np.float64]:
        """A list of numbers, or of equally long lists of them."""
        import numpy as np

        try:
            array = np.array(value)
        except ValueError as error:
            raise self.error(field, "must be a table of numbers, its rows equally long") from error
        if array.ndim != dimensions or array.dtype.kind not in "if" or not array.size or _has_truth_values(value):
            what = "a list of numbers" if dimensions == 1 else "a list of equally long lists of numbers"
            raise self.error(field, f"must be {what}")
        if not (np.abs(array) <= LARGEST).all():
            raise self.error(field, f"must be finite and within {LARGEST:,.0f}")
        return array.astype(np.float64)

    def record(self, value: Any, field: str, keys: tuple[str, ...], optional: tuple[str, ...] = ()) -> dict[str, Any]:
        """A mapping with exactly these keys, and perhaps the optional ones."""
        given = self.mapping(value, field)
        if missing := [key for key in keys if key not in given]:
            raise self.error(field, f"lacks {', '.join(missing)}")
        if unknown := sorted(set(given) - {*keys, *optional}):
            raise self.error(field, f"has unknown {', '.join(unknown)}; valid are {', '.join((*keys, *optional))}")
        return given

    def mapping(self, value: Any, field: str) -> dict[str, Any]:
        """A mapping."""
        if not isinstance(value, dict):
            raise self.error(field, "must be a mapping")
        return value

    def sequence(self, value: Any, field: str) -> list[Any]:
        """A list."""
        if not isinstance(value, list):
            raise self.error(field, "must be a list")
        return value

    def numbers(self, value: Any, field: str) -> list[float]:
        """A list of numbers."""
        return [self.number(v, f"{field}[{i}]") for i, v in enumerate(self.sequence(value, field))]

    def number(self, value: Any, field: str) -> float:
        """A number within `LARGEST`."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(field, "must be a number")
        if not abs(value) <= LARGEST:
            raise self.error(field, f"must be finite and within {LARGEST:,.0f}")
        return float(value)

    def integer(self, value: Any, field: str) -> int:
        """A whole number."""
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(field, "must be a whole number")
        return value

    def text(self, value: Any, field: str) -> str:
        """A string of printable characters: others could make a terminal show what nobody said."""
        if not isinstance(value, str):
            raise self.error(field, "must be text")
        if not value.isprintable():
            raise self.error(field, f"must be printable text, not {value[:40]!r}")
        return value

    def error(self, field: str, sentence: str) -> PlanError:
        """The error that names file and field."""
        return PlanError(f"{self.path}: {field} {sentence}")


def _has_truth_values(value: Any) -> bool:
    """Whether `true` or `false` stands among numbers, in lists however deep: an array would have it as 1 or 0."""
    return any(map(_has_truth_values, value)) if isinstance(value, list) else isinstance(value, bool)
