"""How a task is planned and carried out: every option that decides what comes of a run, in one frozen object."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from numbers import Integral
from typing import TYPE_CHECKING, Any, get_args

from typing_extensions import TypedDict

from tamp.clock import Clock
from tamp.errors import TampError, TaskError, meant
from tamp.execution.simulators import DEFAULT, require
from tamp.frozen import FrozenDict
from tamp.pipeline.options.own import load_search, load_strategy
from tamp.pipeline.options.tuning import DEFAULT_TUNING, Tuning

if TYPE_CHECKING:
    from tamp.task import Task

Samplers = Mapping[str, "str | Callable[..., Any]"]


SEARCHES = ("ff", "ff-greedy", "ff-eager", "add", "cea", "astar", "astar-max", "astar-lmcut", "builtin")
MOTION_PLANNERS = (
    "portfolio", "rrtconnect", "rrt", "kpiece", "bkpiece", "lbkpiece", "rrtstar", "informed-rrtstar", "fmt", "bfmt",
    "bitstar", "aorrtc",
)  # fmt: skip
UNSAID = {"search": "ff", "motion_planner": "portfolio", "simulator": DEFAULT}
"""What a task may say too -> what holds where neither it nor the user says anything."""


STRATEGIES = ("all-at-once", "serialized", "net-benefit")


def option(
    text: str, choices: tuple[str, ...] = (), bare: str | None = None, *, own: bool = False
) -> Mapping[str, Any]:
    """The metadata of a field that is an option of the command line too.

    Args:
        text: what `--help` says of it.
        choices: its valid values; none where they are not known before the run.
        bare: its value where the option is given without one; None where it needs one.
        own: whether it may name one of the user's own as well, by "package.module:NAME".
    """
    return {"help": text, "choices": choices, "bare": bare, "own": own}


@dataclass(frozen=True)
class Settings:
    """Recorded with each run, so that a result says how it came about; a field with `option` metadata is a flag.

    Attributes:
        domain: what tasks are planned with; None is each task's own.
        strategy: which part of a task the planner is asked next: "serialized" goals, "all-at-once", or "net-benefit",
            which reaches what it can; or "package.module:NAME" of one of your own, see `tamp.pipeline.options.own`;
            None is the domain's own.
        samplers: stream name -> function or "package.module:function", in place of the domain's and the task's own.
        algorithm: of the stream planner: "adaptive", "binding", "focused" or "incremental".
        search: the classical search behind it: a configuration of Fast Downward, "builtin", or "package.module:NAME" of
            one of your own; None is the task's own, as for motion_planner and simulator, or the default.
        motion_planner: of OMPL's, by name; "portfolio" takes turns between two that complement each other.
        clock: on which the time limit for planning is kept: "wall", or "processor" time of the process.
        trust_task_code: whether code that a task's file names is imported and run: its samplers, a domain from outside.
        tuning: numbers that a user may change: a `Tuning`, or a mapping of some of its fields.
        simulator: in which plans are carried out: its name, or "package.module:Class".
        threads: how many processor cores a run may use at the same time: what it finds is the same, in less time.
        perceive: by which perceiver poses are estimated from cameras: its name, or "package.module:function"; None is
            being told them.
        cameras: the file of the cameras' set-up; None is OCRTOC's of 2021.
        settling: in which planning lets scenes come to rest, likewise; what it is also stands in each plan's report.
    """

    domain: str | None = field(
        default=None, metadata=option("an installed domain, or package.module, in place of each task's own")
    )
    strategy: str | None = field(
        default=None,
        metadata=option("which part of a task the planner is asked next", STRATEGIES, own=True),
    )
    samplers: Samplers = field(default_factory=dict)
    algorithm: str = field(
        default="adaptive", metadata=option("of the stream planner", ("adaptive", "binding", "focused", "incremental"))
    )
    search: str | None = field(
        default=None, metadata=option("the classical search behind it; default ff", SEARCHES, own=True)
    )
    motion_planner: str | None = field(
        default=None, metadata=option("of OMPL's, for paths between configurations; default portfolio", MOTION_PLANNERS)
    )
    clock: Clock = field(
        default="wall",
        metadata=option(
            "on which --timeout is kept: time that passes, or time that the task's process computes", get_args(Clock)
        ),
    )
    simulator: str | None = field(
        default=None,
        metadata=option(f"in which plans are carried out: its name, or package.module:Class; default {DEFAULT}"),
    )
    perceive: str | None = field(
        default=None,
        metadata=option(
            "estimate poses from cameras instead of being told them, by a perceiver's name or package.module:function; "
            "alone: fit",
            bare="fit",
        ),
    )
    cameras: str | None = field(
        default=None, metadata=option("file of the cameras that --perceive looks through; default OCRTOC 2021's")
    )
    threads: int = field(
        default=1,
        metadata=option("processor cores that planning a task may use at the same time; it finds the same, sooner"),
    )
    settling: str = field(default=DEFAULT, metadata=option("in which planning lets scenes come to rest, likewise"))
    tuning: Tuning = DEFAULT_TUNING
    trust_task_code: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.samplers, Mapping):
            valid = 'valid is a mapping such as {"sample-grasp": my_grasps}'
            raise TampError(f"samplers is {reprlib.repr(self.samplers)}; {valid}, of streams to what serves them")
        object.__setattr__(self, "samplers", FrozenDict(self.samplers))
        if isinstance(self.tuning, Mapping):  # as the command line and records have it
            object.__setattr__(self, "tuning", Tuning.of(self.tuning))
        for f in fields(self):
            valid, value = f.metadata.get("choices", ()), getattr(self, f.name)
            if valid and value is not None and value not in valid and not f.metadata["own"]:
                raise TampError(f"unknown {f.name} {value!r}; {meant(value, valid)}valid are {', '.join(valid)}")
        if not isinstance(self.threads, Integral) or self.threads < 1:
            raise TampError(f"threads is {self.threads!r}; valid are 1, 2, 3, ...")
        if self.strategy is not None and self.strategy not in STRATEGIES:
            load_strategy(self.strategy, STRATEGIES)
        if self.search is not None and self.search not in SEARCHES:
            load_search(self.search, SEARCHES)
        require(self.simulator or DEFAULT)
        require(self.settling)
        if self.perceive is not None:
            from tamp.perception.perceiver import load_perceiver

            load_perceiver(self.perceive)

    def for_task(self, task: Task) -> Settings:
        """The same with what the task says where the user says nothing, and the defaults where neither does.

        Raises:
            TaskError: where the task names what there is not; says file and line.
        """
        said = self
        for name in ("strategy", "perceive", *UNSAID):
            value = getattr(self, name) or getattr(task, name) or UNSAID.get(name)
            changed: dict[str, Any] = {name: value}
            try:
                said = replace(said, **changed)
            except TampError as error:
                from tamp.task.files.yaml_document import read_document

                at_hand = task.path is not None and task.path.is_file()
                where = read_document(task.path).where((name,)) if at_hand and task.path else f"task {task.name}"
                raise TaskError(f"{where}: {error}") from None
        return said

    def chosen(self, name: str) -> str:
        """The value of a field that a task may say too, or its default."""
        value: str = getattr(self, name) or UNSAID[name]
        return value

    def recorded(self) -> dict[str, Any]:
        """JSON-like values by name; a function is recorded by the address it would be named with."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        samplers = {stream: _address(sampler) for stream, sampler in self.samplers.items()}
        return values | {"samplers": samplers, "tuning": self.tuning.recorded()}


DEFAULT_SETTINGS = Settings()


class Options(TypedDict, total=False):
    """The fields of `Settings` as keyword arguments of `tamp.plan` and `tamp.solve`; see there what they mean."""

    domain: str | None
    strategy: str | None
    samplers: Samplers
    algorithm: str
    search: str | None
    motion_planner: str | None
    clock: Clock
    tuning: Tuning | Mapping[str, Any]
    simulator: str | None
    perceive: str | None
    cameras: str | None
    threads: int
    settling: str
    trust_task_code: bool


def settings_of(options: Options) -> Settings:
    """The settings that keyword arguments ask for; None stands for what goes without saying."""
    values: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    if unknown := sorted(values.keys() - Options.__annotations__.keys()):
        hint = meant(unknown[0], Options.__annotations__)
        raise TypeError(f"unknown option {unknown[0]!r}; {hint}there are {', '.join(Options.__annotations__)}")
    return Settings(**values)


def _address(sampler: str | Callable[..., Any]) -> str:
    if isinstance(sampler, str):
        return sampler
    module, name = getattr(sampler, "__module__", None), getattr(sampler, "__qualname__", None)
    return f"{module}:{name}" if module and name else repr(type(sampler))
