"""Every algorithm on every family: solvable problems get a plan that the validator accepts, others an honest status."""

import pytest

from tamp.planning import solve
from tests.planning.oracles.validator import validate
from tests.planning.problems import (
    blocksworld,
    clearing,
    continuous,
    costs,
    fluents,
    guarded,
    kitchen,
    negation,
    ported,
    quantified,
    recursive,
    unsolvable,
)

ALGORITHMS = ("incremental", "focused", "binding", "adaptive")

SOLVABLE = {
    "blocksworld 3": lambda: blocksworld.inversion(3),
    "blocksworld 6": lambda: blocksworld.inversion(6),
    "line 1": lambda: continuous.line(1),
    "line 2": lambda: continuous.line(2),
    "line 2, forall": lambda: continuous.line(2, continuous.DOMAIN.replace(continuous.UNSAFE, continuous.FORALL)),
    "line 2, effects": lambda: continuous.line(2, continuous.conditional_effects()),
    "line 2, wrecking effects": lambda: continuous.line(2, continuous.wrecking_effects()),
    "guarded 1": lambda: guarded.line(1),
    "guarded 2": lambda: guarded.line(2),
    "plane 1": lambda: continuous.plane(1),
    "plane 2": lambda: continuous.plane(2),
    "occupied 2": lambda: continuous.occupied(2),
    "kitchen 1": lambda: kitchen.cook(1),
    "kitchen 2": lambda: kitchen.cook(2),
    "corridor 1": lambda: fluents.corridor(1),
    "corridor 2": lambda: fluents.corridor(2),
    "blocked": lambda: fluents.blocked(),
    "told 1": lambda: fluents.told_corridor(1),
    "told 2": lambda: fluents.told_corridor(2),
    "washing 3": lambda: fluents.washing(3),
    "clearing 2": lambda: clearing.row(2),
    "clearing 4": lambda: clearing.row(4),
    "delivery": costs.delivery,
    "rooms 3": lambda: recursive.rooms(3),
    "painted tower 3": lambda: recursive.painted_tower(3),
    "parking 1": lambda: negation.parking(1),
    "parking 3": lambda: negation.parking(3),
    "inspection 4": lambda: negation.inspection(4),
    "trays 1": lambda: quantified.trays(1),
    "trays 2": lambda: quantified.trays(2),
    "grid 2": lambda: ported.grid(2),
    "belief 2": lambda: ported.belief(2),
    "spawn 1": lambda: ported.spawn(1),
    "spawn 2": lambda: ported.spawn(2),
}

INFEASIBLE = {
    "exhausted": unsolvable.exhausted,
    "impossible goal": unsolvable.impossible_goal,
    "unknown thing": unsolvable.unknown_thing,
    "no streams": unsolvable.no_streams,
    "contradicting": unsolvable.contradicting,
    "never undone": unsolvable.never_undone,
    "never undone, though told": unsolvable.never_undone_though_told,
}

UNDECIDED = {"endless": unsolvable.endless, "undecided": unsolvable.undecided}


def check(problem, solution, observe=None):
    """The plan of a solution is carried out by the validator; its cost is the one that was reported."""
    plan = [(action.name, action.args) for action in solution.plan]
    facts = [*problem.init, *solution.certified]
    streams, samplers = problem.parsed_streams, problem.samplers
    cost = validate(problem.parsed_domain, facts, plan, problem.goal, streams, samplers, observe, problem.init)
    assert solution.cost == pytest.approx(cost)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("name", SOLVABLE)
def test_solvable(name, algorithm):
    problem = SOLVABLE[name]()
    solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=1)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("name", INFEASIBLE)
def test_infeasible(name, algorithm):
    solution = solve(INFEASIBLE[name](), algorithm=algorithm, timeout=20.0)
    assert (solution.plan, solution.status) == (None, "infeasible")


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("name", UNDECIDED)
def test_undecided_is_not_infeasible(name, algorithm):
    solution = solve(UNDECIDED[name](), algorithm=algorithm, timeout=0.7)
    assert (solution.plan, solution.status) == (None, "timeout")


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("make", [lambda: continuous.line(2), lambda: continuous.plane(2)])
def test_blocks_never_overlap(make, algorithm):
    problem = make()
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution, observe=lambda name, args, facts: overlap_free(facts))


def overlap_free(facts):
    assert continuous.overlaps(facts) == []


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(
    ("make", "capacity"), [(lambda: fluents.corridor(2), 1), (lambda: fluents.corridor(3), 1), (fluents.blocked, 2)]
)
def test_fluent_streams_were_told_the_state(make, capacity, algorithm):
    problem = make()
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution, observe=lambda *step: fluents.check(*step, capacity={2: capacity}))


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_what_a_test_says_in_one_state_does_not_hold_in_another(algorithm):
    """What is cooked is dirty, and cannot be washed in any state in which it is."""
    solution = solve(fluents.washing(2, clean=True), algorithm=algorithm, timeout=20.0)
    assert (solution.plan, solution.status) == (None, "infeasible")


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_cheaper_plans_are_found_where_they_are_asked_for(algorithm):
    solution = solve(costs.delivery(), algorithm=algorithm, timeout=20.0, success_cost=costs.BEST_COST)
    assert solution.cost == costs.BEST_COST
    check(costs.delivery(), solution)
    assert [action.name for action in solution.plan] == ["drive", "drive", "drive", "deliver"]


def test_blocksworld_of_40_blocks():
    problem = blocksworld.inversion(40)
    solution = solve(problem, timeout=30.0)
    assert solution.status == "solved"
    check(problem, solution)


@pytest.mark.parametrize("n", [4, 8])
def test_more_blocks_on_the_line(n):
    problem = continuous.line(n)
    solution = solve(problem, timeout=20.0)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution, observe=lambda name, args, facts: overlap_free(facts))


def test_moves_past_obstacles_take_the_free_path():
    problem = guarded.line(3)
    solution = solve(problem, timeout=20.0, seed=1)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution, observe=lambda name, args, facts: overlap_free(facts))
    assert {action.args[1][1][-1] for action in solution.plan if action.name == "move"} == {1.0, 2.0}


def test_the_same_seed_gives_the_same_plan():
    plans = [[(a.name, str(a.args)) for a in solve(continuous.plane(3), seed=7, timeout=20.0).plan] for _ in range(2)]
    assert plans[0] == plans[1]
