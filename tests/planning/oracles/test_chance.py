"""Random problems: the algorithms agree with exhaustive search on what can be solved, and plans are valid."""

from dataclasses import replace

import numpy as np
import pytest

from tamp.planning import Constraints, solve
from tests.planning.oracles.exhaustive import search, wander
from tests.planning.problems import chance
from tests.planning.test_problems import ALGORITHMS, check
from tests.planning.turns import in_turn


def agree(problem, algorithm):
    solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=0)
    if solution.plan is not None:
        assert solution.status == "solved"
        check(problem, solution)
        return
    plan, final = search(problem, rounds=5, calls=3, limit=300)
    assert plan is None, f"{solution.status}, but there is a plan: {plan}"
    assert solution.status == "infeasible" or not final, solution.status


@in_turn(15)
def test_without_streams(seed, algorithm):
    agree(chance.problem(seed), algorithm)


@in_turn(15)
def test_with_finite_streams(seed, algorithm):
    agree(chance.problem(seed, streams=True), algorithm)


@in_turn(4)
@pytest.mark.parametrize("feature", chance.FEATURES)
def test_with_one_more_feature(feature, seed, algorithm):
    agree(chance.problem(seed, streams=True, features={feature}), algorithm)


@in_turn(5)
@pytest.mark.parametrize("features", [*({feature} for feature in chance.FEATURES), set(chance.FEATURES)])
def test_goals_that_can_be_reached(features, seed, algorithm):
    """Random actions lead from the start to what is then the goal, so that most of these problems have a plan."""
    problem = chance.problem(seed, streams=True, features=features)
    goal = wander(problem, 4, seed)
    agree(replace(problem, goal=goal), algorithm)


def outline(plan, rng):
    """A skeleton that a plan follows, with actions left out, and arguments left open or named by variables."""
    skeleton, names = [], {}
    for name, args in plan:
        if rng.random() < 0.25:
            skeleton.append(...)
            continue
        terms = [rng.choice(3, p=(0.2, 0.6, 0.2)) for _ in args]
        choices = [(..., names.setdefault(arg, f"?v{len(names)}"), arg) for arg in args]
        skeleton.append((name, *(choice[term] for choice, term in zip(choices, terms, strict=True))))
    return tuple(skeleton)


def follows(plan, skeleton, values=()):
    """Whether a plan has the actions of a skeleton, in order and no others but where there is a gap."""
    if not skeleton:
        return not plan
    if skeleton[0] is ...:
        return any(follows(plan[i:], skeleton[1:], values) for i in range(len(plan) + 1))
    if not plan or plan[0][0] != skeleton[0][0]:
        return False
    known = dict(values)
    for term, arg in zip(skeleton[0][1:], plan[0][1], strict=True):
        value = known.setdefault(term, arg) if isinstance(term, str) and term.startswith("?") else term
        if value is not ... and value != arg:
            return False
    return follows(plan[1:], skeleton[1:], tuple(known.items()))


@in_turn(8)
@pytest.mark.parametrize(
    "features", [set(), {"transit", "late"}, {"moody", "exogenous"}, {"wild", "negated", "effects"}]
)
def test_skeletons_of_plans_are_followed(features, seed, algorithm):
    problem = chance.problem(seed, streams=True, features=features)
    problem = replace(problem, goal=wander(problem, 4, seed))
    plan, _ = search(problem, rounds=6, calls=9, limit=300)
    if plan is None:
        return
    skeleton = outline(plan, np.random.default_rng(seed))
    constraints = Constraints(skeleton=skeleton, exact=True)
    solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=0, constraints=constraints)
    assert solution.status == "solved", f"{plan} follows {skeleton}"
    check(problem, solution)
    assert follows([(action.name, action.args) for action in solution.plan], skeleton)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(
    ("seed", "features"),
    [(627550836, {"inputless", "effects", "functions"}), (631442558, {"exogenous", "functions", "transit"})],
)
def test_what_is_simplified_in_the_search_does_not_bar_a_proof(seed, features, algorithm):
    """Atoms that no test can be asked about, and moves to what nothing leads to, were planned with again and again."""
    solution = solve(chance.problem(seed, streams=True, features=features), algorithm=algorithm, timeout=20.0, seed=0)
    assert (solution.plan, solution.status) == (None, "infeasible")


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(
    ("seed", "features"),
    [(7700358, {"told"}), (7720303, {"effects", "functions", "told"}), (7710994, {"exogenous", "functions"})],
)
def test_what_is_proven_of_tests_told_the_state_and_of_goals_that_follow_from_what_must_not_be(
    seed, features, algorithm
):
    """A test that names no reason was taken to fail wherever more holds than it was told, and nothing was proven then.

    In the last of them the goal wants `(e tc)` and not `(e ta)`, which are defined alike.
    """
    solution = solve(chance.problem(seed, streams=True, features=features), algorithm=algorithm, timeout=20.0, seed=0)
    assert (solution.plan, solution.status) == (None, "infeasible")


@in_turn(4)
@pytest.mark.parametrize("features", [set(), {"transit"}, {"robots", "transit"}, {"effects", "told"}, {"exogenous"}])
def test_no_better_plan_is_said_of_cheapest_plans(features, seed, algorithm):
    """Each action costs 1, so that a shortest plan of the second opinion is a cheapest one of what it has sampled."""
    problem = chance.problem(seed, streams=True, features=features)
    problem = replace(problem, goal=wander(problem, 4, seed))
    plan, _ = search(problem, rounds=5, calls=3, limit=300)
    for bound in ("max_cost", "success_cost") if plan is not None else ():
        solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=0, **{bound: len(plan)})
        assert (solution.status, solution.cost <= len(plan)) == ("solved", True), str(solution.report)
        check(problem, solution)


@pytest.mark.parametrize("algorithm", ["adaptive", "incremental"])
def test_what_streams_say_of_the_start_after_a_plan_was_found_is_no_part_of_it(algorithm):
    problem = chance.problem(70015, streams=True, features={"wild"})
    problem = replace(problem, goal=("and", ("q", "ta-0"), ("q", "tc-0")))
    solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=0, success_cost=0.0)
    assert solution.cost == 2.0
    check(problem, solution)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_the_same_actions_may_rest_on_other_facts(algorithm):
    """An action that some object made possible, whichever it was, was tried with the first one only."""
    problem = chance.problem(7700615, streams=True, features={"effects", "exogenous", "wild"})
    agree(replace(problem, goal=("s",)), algorithm)


@pytest.mark.parametrize("algorithm", ["adaptive", "focused"])
def test_hopes_do_not_run_ahead_where_the_goal_names_what_only_a_stream_can_bring(algorithm):
    """Chains of hopes that could never be that object were grounded first, by the hundred."""
    problem = chance.problem(7700878, streams=True, features={"exogenous", "transit"})
    problem = replace(problem, goal=("and", ("at", "spot-tb-0"), ("q", "spot-ta-1"), ("s",)))
    solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=0)
    check(problem, solution)
    assert solution.report.counts["instances"] < 100


@pytest.mark.parametrize("algorithm", ["adaptive", "focused"])
def test_conditional_effects_that_rest_on_hopes_crowd_the_search(algorithm):
    """Only a value that is no new object does; 100,000 effects were grounded for one that is."""
    problem = chance.problem(42541887, streams=True, features={"exogenous", "inputless"})
    problem = replace(problem, goal=("and", ("not", ("q", "tb")), ("s",)))
    solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=0)
    check(problem, solution)
    assert solution.report.counts["operators"] < 2500
