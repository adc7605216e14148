"""What PDDLStream's scripts use around a call of `solve`: command line, files, profiles, words for plans."""

from __future__ import annotations

import argparse
import cProfile
import pstats
import random
import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from tamp.planning.keywords import ALGORITHMS, SERIALIZED

T = TypeVar("T")

FOCUSED_ALGORITHMS = ["focused", "binding", "adaptive"]
"""The algorithms that search over optimistic facts."""

NAMES = ("adaptive", "binding", "focused", "incremental", SERIALIZED, *ALGORITHMS)
"""What `--algorithm` may say."""


def create_parser(default_algorithm: str = "adaptive") -> argparse.ArgumentParser:
    """A command line with `--algorithm` and `--unit`, for unit costs; what a script adds comes before these."""
    parser = argparse.ArgumentParser(conflict_handler="resolve")
    parser.add_argument("-a", "--algorithm", default=default_algorithm, choices=NAMES, help="how to plan")
    parser.add_argument("-u", "--unit", action="store_true", help="let each action cost 1")
    return parser


def read(filename: Any) -> str:
    """The text of a file."""
    return Path(filename).read_text(encoding="utf-8")


def read_pddl(file: Any, filename: Any) -> str:
    """The text of what lies beside a file."""
    return read(get_file_path(file, filename))


def read_pddlstream_pair(file: Any) -> list[str]:
    """The texts of domain.pddl and stream.pddl beside a file."""
    return [read_pddl(file, name) for name in ("domain.pddl", "stream.pddl")]


def read_pddl_pair(file: Any) -> list[str]:
    """The texts of domain.pddl and problem.pddl beside a file."""
    return [read_pddl(file, name) for name in ("domain.pddl", "problem.pddl")]


def write(filename: Any, string: str) -> None:
    """Write a text to a file."""
    Path(filename).write_text(string, encoding="utf-8")


def ensure_dir(file: Any) -> None:
    """Make the folder that a file lies in; of "folder/", that folder."""
    path = str(file)
    (Path(path) if path.endswith("/") else Path(path).parent).mkdir(parents=True, exist_ok=True)


def safe_rm_dir(folder: Any) -> None:
    """Remove a folder with all that is in it, where there is one."""
    if Path(folder).exists():
        shutil.rmtree(folder)


def clear_dir(folder: Any) -> None:
    """Make a folder, or remove all that is in it."""
    safe_rm_dir(folder)
    Path(folder).mkdir(parents=True)


VISUALIZATIONS_DIR = "visualizations/"
"""Where scripts put their pictures."""

user_input = input


def get_file_path(file: Any, rel_path: Any) -> str:
    """The path of what lies beside a file."""
    return str(Path(file).absolute().parent / rel_path)


class Profiler:
    """Prints where the time of its `with` block went: the `num` calls that took the most by `field`."""

    def __init__(self, field: str = "tottime", num: int = 10, **options: Any) -> None:
        """`options` have no effect here."""
        self._field = field
        self._num = num
        self._profile = cProfile.Profile()

    def __enter__(self) -> Profiler:
        """Begin to measure."""
        self._profile.enable()
        return self

    def __exit__(self, *error: Any) -> None:
        """Print what was measured."""
        self._profile.disable()
        if self._field is not None:
            pstats.Stats(self._profile).sort_stats(self._field).print_stats(self._num)


AND, OR, NOT, IMPLY, EXISTS, FORALL, WHEN, EQ = "and", "or", "not", "imply", "exists", "forall", "when", "="
"""First words of formulas."""

MINIMIZE, OBJECT = "minimize", "object"
"""The first word of an objective, and the type of everything."""

FAILED, INFEASIBLE = None, False
"""What stands for a plan where there is none; `solve` returns the first of them in any case."""


def is_plan(plan: Any) -> bool:
    """Whether there is a plan."""
    return plan is not FAILED and plan is not INFEASIBLE


def get_length(plan: Any) -> float:
    """How many actions a plan has; infinite where there is none."""
    return len(plan) if is_plan(plan) else float("inf")


def str_from_plan(plan: Any) -> str:
    """A plan in one line."""
    if not is_plan(plan):
        return str(plan)
    return f"[{', '.join(map(str_from_action, plan))}]"


def str_from_action(action: Any) -> str:
    """An action with its arguments."""
    name, args = action
    return f"{name}({', '.join(map(str, args))})"


def concatenate(*parts: Iterable[Any]) -> tuple[Any, ...]:
    """The elements of all parts, in a row."""
    return tuple(element for part in parts for element in part)


def is_parameter(term: Any) -> bool:
    """Whether a term is a variable, such as "?x"."""
    return isinstance(term, str) and term.startswith("?")


def get_parameter_name(term: Any) -> Any:
    """The name of a variable without its mark; anything else as it is."""
    return term[1:] if is_parameter(term) else term


def get_prefix(formula: Any) -> str:
    """The first word of a fact or formula, in lower case."""
    return str(formula[0]).lower()


def get_args(formula: Any) -> Any:
    """What follows the first word of a fact or formula."""
    return formula[1:]


def list_from_conjunction(formula: Any) -> list[Any]:
    """The facts of which a formula is the conjunction; none of None.

    Raises:
        ValueError: where there is anything but conjunctions and facts.
    """
    if formula is None:
        return []
    prefix = get_prefix(formula)
    if prefix == AND:
        return flatten(map(list_from_conjunction, get_args(formula)))
    if prefix == OR and len(formula) == 2:
        return list_from_conjunction(formula[1])
    if prefix in (OR, NOT, IMPLY, EXISTS, FORALL, WHEN, EQ):
        raise ValueError(f"expected a conjunction of facts, found {formula!r}")
    return [tuple(formula)]


def get_function(term: Any) -> Any:
    """What a negation, an objective or the value of a function is about; a fact as it is."""
    return term[1] if get_prefix(term) in (EQ, MINIMIZE, NOT) else term


def partition_facts(facts: Iterable[Any]) -> tuple[list[Any], list[Any], list[Any]]:
    """Of facts those that hold, those that do not, and the functions that have values or shall be small."""
    positive: list[Any] = []
    negated: list[Any] = []
    functions: list[Any] = []
    for fact in facts:
        kinds = {EQ: functions, MINIMIZE: functions, NOT: negated}
        kinds.get(get_prefix(fact), positive).append(get_function(fact))
    return positive, negated, functions


def get_costs(terms: Iterable[Any]) -> list[Any]:
    """The terms that shall be small, `Minimize(...)`, among those of a satisfaction problem or an optimizer."""
    return [term for term in terms if get_prefix(term) == MINIMIZE]


def get_constraints(terms: Iterable[Any]) -> list[Any]:
    """The terms that shall hold, among those of a satisfaction problem or an optimizer."""
    return [term for term in terms if get_prefix(term) != MINIMIZE]


def value_or_id(value: Any) -> Any:
    """A value as a key: itself, or a number of its own where it has no hash."""
    try:
        hash(value)
    except TypeError:
        return id(value)
    return value


SEPARATOR = "\n" + 80 * "-" + "\n"


def flatten(lists: Any) -> list[Any]:
    """The elements of lists, in a row."""
    return [element for each in lists for element in each]


def find_unique(test: Callable[[T], bool], sequence: Iterable[T]) -> T:
    """The one element that a test holds for.

    Raises:
        RuntimeError: where there is none, or more than one.
    """
    found = [element for element in sequence if test(element)]
    if len(found) != 1:
        raise RuntimeError(f"the test holds for {len(found)} elements, not for one: {', '.join(map(str, found))}")
    return found[0]


def irange(start: float, end: float | None = None, step: float = 1) -> Iterator[float]:
    """Numbers from `start`, each a step after the one before, below `end`; with one bound those from 0 below it."""
    number, below = (0, start) if end is None else (start, end)
    while number < below:
        yield number
        number += step


def inclusive_range(start: float, stop: float, step: float = 1) -> list[float]:
    """Numbers from `start`, each a step after the one before, below `stop`, and that."""
    return [*irange(start, stop, step), stop] if start < stop else []


def implies(first: Any, second: Any) -> bool:
    """Whether the second holds where the first does."""
    return not first or bool(second)


def elapsed_time(start_time: float) -> float:
    """How long ago a time of `time.time()` was [s]."""
    return time.time() - start_time


def randomize(iterable: Iterable[T]) -> list[T]:
    """The elements in a random order, drawn by Python's own generator; a sampler better draws from `context.rng`."""
    elements = list(iterable)
    random.shuffle(elements)
    return elements


class StreamAction(NamedTuple):
    """A call of a stream as an action, which PDDLStream's plans may have; those of `solve` have none."""

    name: str
    inputs: tuple[Any, ...]
    outputs: tuple[Any, ...]


class DurativeAction(NamedTuple):
    """An action of a plan with the time that it begins, and how long it takes [s]."""

    name: str
    args: tuple[Any, ...]
    start: float
    duration: float


def retime_plan(plan: Any, duration: float = 1.0) -> list[DurativeAction] | None:
    """A plan whose actions take equally long [s], one after the other; None where there is no plan."""
    if not is_plan(plan):
        return None
    return [DurativeAction(name, tuple(args), i * duration, duration) for i, (name, args) in enumerate(plan)]


def get_end(action: DurativeAction) -> float:
    """When an action ends [s]."""
    return action.start + action.duration


def compute_duration(plan: Iterable[DurativeAction] | None) -> float:
    """When the last action of a plan ends [s]; 0 where there is none."""
    return max(map(get_end, plan or ()), default=0.0)


MAX_FD_COST = 1e8
"""The most that an action may cost in PDDLStream's search, which knows whole numbers only."""


def get_cost_scale() -> float:
    """What costs are multiplied by before PDDLStream rounds them; here they are not rounded."""
    return 1e3


def set_cost_scale(cost_scale: float = 1e3) -> None:
    """Has no effect: costs are not rounded."""


def safe_zip(first: Sequence[Any], second: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
    """Pairs of two sequences.

    Raises:
        ValueError: where one is longer.
    """
    return zip(first, second, strict=True)


def get_mapping(first: Sequence[Any], second: Sequence[Any]) -> dict[Any, Any]:
    """A dictionary from the elements of one sequence to those of another.

    Raises:
        ValueError: where one is longer.
    """
    return dict(safe_zip(first, second))


def find(test: Callable[[T], bool], sequence: Iterable[T]) -> T | None:
    """The first element that a test holds for; None where there is none."""
    return next(filter(test, sequence), None)


def str_eq(first: str, second: str, ignore_case: bool = True) -> bool:
    """Whether two strings are equal."""
    return first.lower() == second.lower() if ignore_case else first == second


def sorted_str_from_list(values: Iterable[Any]) -> str:
    """Values for people to read, in order."""
    return f"[{', '.join(sorted(map(str, values)))}]"


def str_from_object(value: Any) -> str:
    """A value for people to read."""
    return str(value)


def dump_pddlstream(problem: Any) -> None:
    """Print the initial state and the goal of a problem, as a `PDDLProblem` or six values have them."""
    *_, init, goal = problem
    print("Initial:", *sorted(map(str, init)), sep="\n  ")
    print("Goal:", goal)
