"""What PDDLStream's scripts use around a call of solve: facts and formulas, files, and names that only must exist."""

from __future__ import annotations

import math
import warnings

import pytest

from tamp.errors import DomainError, DomainWarning
from tamp.planning import pddlstream
from tamp.planning.pddlstream import (
    And,
    DebugValue,
    Equal,
    Minimize,
    Not,
    Or,
    PDDLProblem,
    PlanConstraints,
    StreamInfo,
    from_fn,
    list_from_conjunction,
    solve_current,
    solve_exhaustive,
    solve_immediate,
)
from tamp.planning.pddlstream.not_ported import NOT_PORTED

DOMAIN = """
(define (domain shelf)
  (:predicates (Thing ?x) (Grasp ?x ?g) (Held ?x))
  (:action pick :parameters (?x ?g) :precondition (Grasp ?x ?g) :effect (Held ?x)))
"""
STREAMS = """
(define (stream shelf)
  (:stream sample :inputs (?x) :domain (Thing ?x) :outputs (?g) :certified (Grasp ?x ?g)))
"""


@pytest.mark.parametrize(
    ("formula", "facts"),
    [
        (None, []),
        (("On", "a", "b"), [("On", "a", "b")]),
        (And(("On", "a", "b"), And(("Clear", "a"), Or(("Free",)))), [("On", "a", "b"), ("Clear", "a"), ("Free",)]),
        (And(), []),
    ],
)
def test_the_facts_of_a_conjunction(formula, facts):
    assert list_from_conjunction(formula) == facts


@pytest.mark.parametrize("formula", [Or(("Free",), ("Clear", "a")), And(Not(("Free",))), Or()])
def test_other_formulas_are_no_conjunctions(formula):
    with pytest.raises(ValueError, match="expected a conjunction of facts"):
        list_from_conjunction(formula)


def test_terms_by_what_they_say():
    cost, distance = Minimize(("Far", "?q")), Equal(("Far", "q"), 2.0)
    facts = [("On", "a", "b"), Not(("Free",)), cost, distance]
    assert pddlstream.partition_facts(facts) == ([("On", "a", "b")], [("Free",)], [("Far", "?q"), ("Far", "q")])
    assert pddlstream.get_costs(facts) == [cost]
    assert pddlstream.get_constraints(facts) == [("On", "a", "b"), Not(("Free",)), distance]


def test_values_as_keys():
    value = [1]
    assert pddlstream.value_or_id((1, 2)) == (1, 2)
    assert pddlstream.value_or_id(value) == id(value) != pddlstream.value_or_id([1])


def test_files_beside_a_script_and_an_empty_folder(tmp_path):
    for name in ("domain", "problem"):
        pddlstream.write(tmp_path / f"{name}.pddl", f"({name})")
    assert pddlstream.read_pddl_pair(tmp_path / "run.py") == ["(domain)", "(problem)"]
    folder = tmp_path / "new" / "pictures"
    for _ in range(2):
        pddlstream.clear_dir(folder)
        assert list(folder.iterdir()) == []
        pddlstream.write(folder / "a.txt", "a")


def test_without_streams_and_with_all_of_them():
    stream_map, given = {"sample": from_fn(lambda x: (1,))}, [("Thing", "cup")]
    problem = PDDLProblem(DOMAIN, {}, STREAMS, stream_map, given, ("Held", "cup"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        info = {"sample": StreamInfo(eager=True)}
        assert solve_current(problem, stream_info=info, max_time=20).status == "infeasible"
        known = problem._replace(init=[*given, ("Grasp", "cup", 3)])
        plan, *_ = solve_current(known, max_time=20)
        assert [(name, args) for name, args in plan] == [("pick", ("cup", 3))]
        assert solve_immediate(known, max_time=20).plan == plan
        plan, *_ = solve_exhaustive(problem, stream_info=info, max_time=20)
        assert [(name, args) for name, args in plan] == [("pick", ("cup", 1))]


def test_solutions_and_actions_are_taken_apart_by_index_too():
    """`name, args = action[:2]`, as scripts have it that know actions with durations, was a TypeError."""
    problem = PDDLProblem(DOMAIN, {}, STREAMS, {"sample": from_fn(lambda x: (1,))}, [("Thing", "cup")], ("Held", "cup"))
    solution = pddlstream.solve(problem, max_time=20)
    plan, cost = solution[:2]
    assert (len(solution), cost) == (3, 1.0)
    assert [(action[0], *action[1], len(action)) for action in plan] == [("pick", "cup", 1, 2)]
    name, args = plan[-1][:2]
    assert f"{name}{args}" == "pick('cup', 1)"
    assert solution[2] == solution.certificate == solution.facts == solution.certified


@pytest.mark.parametrize(
    ("solver", "given"),
    [
        ("solve", ["focused", PlanConstraints(), {}, set(), True, math.inf, 20]),
        ("solve_focused", [PlanConstraints(), {}, set()]),
        ("solve_adaptive", [PlanConstraints()]),
        ("solve_incremental", [PlanConstraints(), True, math.inf, math.inf, 20]),
        ("solve_exhaustive", []),
    ],
)
def test_solvers_take_arguments_in_their_order_of_there(solver, given):
    problem = PDDLProblem(DOMAIN, {}, STREAMS, {"sample": from_fn(lambda x: (1,))}, [("Thing", "cup")], ("Held", "cup"))
    solve = getattr(pddlstream, solver)
    plan, cost, _ = solve(problem, *given)
    assert len(plan) == cost == 1
    with pytest.raises(TypeError, match=f"{solver}: constraints: given by position and by name"):
        solve(problem, *given, *[None] * (2 - len(given)), constraints=None)
    with pytest.raises(TypeError, match=f"{solver}: by position there are: problem, .*; found 21 arguments"):
        solve(problem, *range(20))


@pytest.mark.parametrize("option", ["p_success", "overhead"])
def test_what_is_known_of_streams_are_numbers(option):
    with pytest.warns(DomainWarning, match="without effect here: (p_success|cost) as a function"):
        info = StreamInfo(**{option: lambda *inputs: 0.5})
    assert (info.p_success, info.cost) == (1.0, 1.0)
    with pytest.raises(DomainError, match=r"StreamInfo: (p_success|cost) must be a number, found 'often'"):
        StreamInfo(**{option: "often"})


def test_names_that_only_must_exist():
    problem = PDDLProblem(DOMAIN, {}, STREAMS, "debug", [("Thing", "cup")], ("Held", "cup"))
    plan, *_ = pddlstream.solve(problem, max_time=20)
    value = plan[0].args[1]
    assert isinstance(value, DebugValue)
    assert (value.stream, value.input_values, value.output_parameter) == ("sample", ("cup",), "?g")
    assert not any(isinstance(action, pddlstream.StreamAction) for action in plan)
    options = {
        "action_info": {"pick": pddlstream.ActionInfo(terminal=True, p_success=0.5)},
        "synthesizers": [pddlstream.StreamSynthesizer("both", {"sample": 2}, None)],
        "hierarchy": [pddlstream.ABSTRIPSLayer(pos_pre=["Thing"])],
    }
    for name, value in options.items():
        with pytest.warns(DomainWarning, match=f"^{name}=.* has no effect here: ") as said:
            assert pddlstream.solve(problem, max_time=20, **{name: value}).solved
        assert len(said) == 1


@pytest.mark.parametrize("name", list(NOT_PORTED))
def test_names_that_are_not_there_are_told_with_what_to_do_instead(name):
    with pytest.raises(ImportError, match=f"^tamp.planning.pddlstream has no {name}: .+"):
        exec(f"from tamp.planning.pddlstream import {name}")  # as a script imports it
    assert name not in pddlstream.__all__


def test_other_names_are_missing_as_in_any_module():
    assert not hasattr(pddlstream, "solve_quickly")
    assert not any(name in vars(pddlstream) for name in NOT_PORTED)
