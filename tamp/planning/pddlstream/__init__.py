"""What scripts written for PDDLStream import: its problems, solvers, wrappers of samplers and constructors of formulas.

from tamp.planning.pddlstream import PDDLProblem, StreamInfo, from_fn, from_gen_fn, from_test, print_solution, solve

solution = solve(PDDLProblem(domain, {}, streams, stream_map, init, goal), algorithm="adaptive", max_time=60)
plan, cost, evaluations = solution
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import count
from math import inf
from typing import Any

from tamp.errors import DomainError
from tamp.language import PDDL, parse_domain, parse_problem
from tamp.planning.keywords import WILD, PDDLProblem, PlanConstraints, problem_of
from tamp.planning.pddlstream.not_ported import NOT_PORTED
from tamp.planning.pddlstream.positions import by_position
from tamp.planning.pddlstream.satisfaction import (
    Minimize,
    SatisfactionProblem,
    constraint_satisfaction,
    dump_assignment,
    solve_pddlstream_satisfaction,
)
from tamp.planning.pddlstream.scripts import (
    AND,
    EQ,
    EXISTS,
    FAILED,
    FOCUSED_ALGORITHMS,
    FORALL,
    IMPLY,
    INFEASIBLE,
    MAX_FD_COST,
    MINIMIZE,
    NOT,
    OBJECT,
    OR,
    SEPARATOR,
    VISUALIZATIONS_DIR,
    WHEN,
    DurativeAction,
    Profiler,
    StreamAction,
    clear_dir,
    compute_duration,
    concatenate,
    create_parser,
    dump_pddlstream,
    elapsed_time,
    ensure_dir,
    find,
    find_unique,
    flatten,
    get_args,
    get_constraints,
    get_cost_scale,
    get_costs,
    get_end,
    get_file_path,
    get_function,
    get_length,
    get_mapping,
    get_parameter_name,
    get_prefix,
    implies,
    inclusive_range,
    irange,
    is_parameter,
    is_plan,
    list_from_conjunction,
    partition_facts,
    randomize,
    read,
    read_pddl,
    read_pddl_pair,
    read_pddlstream_pair,
    retime_plan,
    safe_rm_dir,
    safe_zip,
    set_cost_scale,
    sorted_str_from_list,
    str_eq,
    str_from_action,
    str_from_object,
    str_from_plan,
    user_input,
    value_or_id,
    write,
)
from tamp.planning.problem import Certificate, Problem, Solution, StreamInfo
from tamp.planning.wrappers import (
    DEBUG,
    SHARED_DEBUG,
    TOTAL_COST,
    And,
    DebugValue,
    Equal,
    Exists,
    Fact,
    ForAll,
    Imply,
    Not,
    OptimizerOutput,
    Or,
    Output,
    Type,
    WildOutput,
    accelerate_list_gen_fn,
    debug_samplers,
    empty_gen,
    empty_test,
    fn_from_constant,
    from_constant,
    from_fn,
    from_gen,
    from_gen_fn,
    from_list_fn,
    from_list_gen_fn,
    from_sampler,
    from_stream_map,
    from_test,
    negate_test,
    outputs_from_boolean,
    universe_test,
)

__all__ = [
    "ALGORITHMS", "AND", "DEBUG", "EQ", "EXISTS", "FAILED", "FOCUSED_ALGORITHMS", "FORALL", "IMPLY", "INF",
    "INFEASIBLE", "MAX_FD_COST", "MINIMIZE", "NOT", "OBJECT", "OR", "SEPARATOR", "SHARED_DEBUG", "TOTAL_COST",
    "VISUALIZATIONS_DIR", "WHEN", "WILD", "ABSTRIPSLayer", "ActionInfo", "And", "Certificate", "DebugValue",
    "DurativeAction", "Equal", "Exists", "Fact", "ForAll", "FunctionInfo", "Imply", "Minimize", "Not", "OptimizerInfo",
    "OptimizerOutput", "Or", "Output", "PDDLProblem", "PartialInputs", "PlanConstraints", "Profiler",
    "SatisfactionProblem", "SharedOptValue", "StreamAction", "StreamInfo", "StreamSynthesizer", "Type",
    "UniqueOptValue", "WildOutput", "accelerate_list_gen_fn", "add_opt_function", "classical_problem", "clear_dir",
    "compute_duration", "concatenate", "constraint_satisfaction", "create_parser", "debug_samplers", "defer_shared",
    "defer_unique", "dump_assignment", "dump_pddlstream", "elapsed_time", "empty_gen", "empty_test", "ensure_dir",
    "find", "find_unique", "flatten", "fn_from_constant", "from_constant", "from_fn", "from_gen", "from_gen_fn",
    "from_list_fn", "from_list_gen_fn", "from_sampler", "from_stream_map", "from_test", "get_args", "get_constraints",
    "get_cost_scale", "get_costs", "get_defer_all_unbound", "get_defer_any_unbound", "get_end", "get_file_path",
    "get_function", "get_length", "get_mapping", "get_parameter_name", "get_prefix", "implies", "inclusive_range",
    "inf_generator", "irange", "is_parameter", "is_plan", "list_from_conjunction", "negate_test", "never_defer",
    "outputs_from_boolean", "partition_facts", "print_solution", "randomize", "read", "read_pddl", "read_pddl_pair",
    "read_pddlstream_pair", "retime_plan", "safe_rm_dir", "safe_zip", "set_cost_scale", "set_unique", "solve",
    "solve_abstract", "solve_adaptive", "solve_binding", "solve_current", "solve_exhaustive", "solve_focused",
    "solve_from_pddl", "solve_immediate", "solve_incremental", "solve_pddlstream_satisfaction", "solve_restart",
    "solve_serialized", "sorted_str_from_list", "str_eq", "str_from_action", "str_from_object", "str_from_plan",
    "universe_test", "user_input", "value_or_id", "write",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Say of a name of PDDLStream that is not there why, where a script imports it."""
    if name in NOT_PORTED:
        raise ImportError(f"{__name__} has no {name}: {NOT_PORTED[name]}", name=__name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


INF = inf

ALGORITHMS = ["incremental", *FOCUSED_ALGORITHMS]

_FOCUSED = ("constraints", "stream_info", "replan_actions")
_INCREMENTAL = ("constraints", "unit_costs", "success_cost", "max_iterations", "max_time", "max_memory")
_ANY = ("algorithm", *_FOCUSED, "unit_costs", "success_cost", "max_time", "max_iterations", "max_memory")

solve = by_position("solve", _ANY)
solve_adaptive = by_position("solve_adaptive", _FOCUSED, algorithm="adaptive")
solve_binding = by_position("solve_binding", _FOCUSED, algorithm="binding")
solve_focused = by_position("solve_focused", _FOCUSED, algorithm="focused")
solve_abstract = by_position("solve_abstract", _FOCUSED, algorithm="abstract")
solve_incremental = by_position("solve_incremental", _INCREMENTAL, algorithm="incremental")
solve_exhaustive = by_position("solve_exhaustive", _INCREMENTAL, algorithm="incremental")
solve_serialized = by_position("solve_serialized", _FOCUSED, algorithm="serialized")


def classical_problem(domain: PDDL, problem: PDDL) -> Problem:
    """A domain file and a problem file as a problem without streams; its objects are their names, in lower case.

    Raises:
        DomainError: with file, line and column of what cannot be read.
    """
    found = parse_problem(problem, parse_domain(domain))
    return Problem(domain, None, {}, found.init, found.goal)


def solve_from_pddl(domain: PDDL, problem: PDDL, **options: Any) -> tuple[Any, float]:
    """The plan of a domain file and a problem file, None where there is none, and its cost; `options` as for `solve`.

    Raises:
        DomainError: with file, line and column of what cannot be read.
    """
    solution = solve(classical_problem(domain, problem), **options)
    return solution.plan, solution.cost


def never_defer(result: Any, *more: Any, **options: Any) -> bool:
    """For `StreamInfo(defer_fn=)`: has no effect, as the others."""
    return False


def defer_unique(result: Any, *more: Any, **options: Any) -> bool:
    """For `StreamInfo(defer_fn=)`: has no effect, as a plan is bound as a whole; so with `defer_shared`.

    PDDLStream puts off nothing either but what comes after one of its `replan_actions`.
    """
    return True


defer_shared = defer_unique


def get_defer_any_unbound(unique: bool = False) -> Callable[..., bool]:
    """For `StreamInfo(defer_fn=)`: has no effect, as `defer_unique`."""
    return defer_unique


def get_defer_all_unbound(inputs: str = "", unique: bool = False) -> Callable[..., bool]:
    """For `StreamInfo(defer_fn=)`: has no effect, as `defer_unique`, whatever the `inputs`, such as "?p ?g"."""
    return defer_unique


def FunctionInfo(
    opt_fn: Any = None, eager: bool = False, p_success: Any = None, overhead: Any = None, **options: Any
) -> StreamInfo:
    """What the planner may know of a function; `opt_fn` has no effect, give `StreamInfo(bound=)` a lower bound.

    `options`, such as `defer_fn` and `effort`, have no effect: a function is asked as soon as its arguments are known.

    Raises:
        DomainError: where a value cannot be used.
    """
    return StreamInfo(eager=eager, p_success=p_success, overhead=overhead, opt_gen_fn=opt_fn)


def OptimizerInfo(planable: bool = False, p_success: Any = None, overhead: Any = None) -> StreamInfo:
    """What the planner may know of an optimizer's streams; `planable` has no effect, as there.

    Raises:
        DomainError: where a value cannot be used.
    """
    return StreamInfo(p_success=p_success, overhead=overhead)


class OptValue:
    """A placeholder, of which PDDLStream asks functions of costs; here they are asked of real values."""


UniqueOptValue = SharedOptValue = OptValue


def add_opt_function(
    name: str,
    base_fn: Callable[..., float],
    stream_map: Mapping[str, Any],
    stream_info: Mapping[str, StreamInfo],
    constant: float = 0.0,
    coefficient: float = 1.0,
    **options: Any,
) -> tuple[dict[str, Any], dict[str, StreamInfo]]:
    """A stream map with the function `constant + coefficient * base_fn(...)`, and infos with its lower bound.

    `options` have no effect here.
    """
    made = {**stream_map, name: lambda *inputs: constant + coefficient * base_fn(*inputs)}
    return made, {**stream_info, name: StreamInfo(bound=constant)}


def inf_generator() -> Iterator[int]:
    """0, 1, 2 and so on."""
    return count()


class PartialInputs:
    """How PDDLStream makes placeholders; accepted for `StreamInfo(opt_gen_fn=)`, which has no effect here."""

    def __init__(self, *inputs: Any, **options: Any) -> None:
        """Nothing of it is kept."""


class ActionInfo(PartialInputs):
    """What PDDLStream's older versions may know of an action; for `action_info=`, which has no effect here."""


class StreamSynthesizer(PartialInputs):
    """Several streams as one, in PDDLStream's older versions; for `synthesizers=`, which has no effect here."""


class ABSTRIPSLayer(PartialInputs):
    """What a level of PDDLStream's hierarchies leaves out; for `hierarchy=`, which has no effect here."""


def solve_current(problem: Any, stream_info: Any = None, **options: Any) -> Solution:
    """The plan without any call of a stream: with the facts alone that the problem gives; `options` as for `solve`.

    `stream_info` has no effect.
    """
    return solve(replace(problem_of(problem), streams=None, samplers={}, info={}), **options)


solve_immediate = solve_current


def solve_restart(problem: Any, **options: Any) -> Solution:
    """As `solve`: a run does not end before its time, so that there is nothing to restart."""
    return solve(problem, **options)


def set_unique(externals: Any) -> None:
    """Has no effect: each stream instance has placeholders of its own."""


def print_solution(solution: Any) -> None:
    """Print a plan, its cost, and one line for each of its actions; `solution`: of `solve`, or its three parts.

    Raises:
        DomainError: where something else is given.
    """
    if not isinstance(solution, Solution) and not (isinstance(solution, tuple | list) and len(solution) == 3):
        raise DomainError(f"print_solution: expected what solve returns, found {type(solution).__name__}")
    plan, cost, _ = solution
    print(f"Solved: {is_plan(plan)}\nCost: {cost:.3f}")
    if is_plan(plan):
        print(f"Length: {len(plan)}")
    for number, (name, args) in enumerate(plan or (), start=1):
        print(f"{number:>2}) {name} {' '.join(map(str, args))}".rstrip())
