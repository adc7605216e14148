"""The tabletop's form at size: order, clutter and buffers; constraints, reuse, determinism and the report."""

import dataclasses
import json
import math
import os
import subprocess
import sys

import pytest

from tamp.errors import DomainError
from tamp.planning import Constraints, Reuse, solve
from tests.planning.oracles.validator import validate
from tests.planning.problems import tabletop

ANY = ...


def check(problem, solution):
    assert solution.status == "solved", str(solution.report)
    plan = [(action.name, action.args) for action in solution.plan]
    facts = [*problem.init, *solution.certified]
    assert solution.cost == validate(problem.parsed_domain, facts, plan, problem.goal, None, problem.samplers)


def moved(solution):
    return [action.args[0] for action in solution.plan if action.name == "place"]


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(("family", "n"), [("sort", 6), ("clutter", 9), ("permutation", 6)])
def test_families(family, n, seed):
    problem = getattr(tabletop, family)(n)
    check(problem, solve(problem, seed=seed, timeout=20.0))


def test_a_cycle_takes_one_buffer():
    assert len(moved(solve(tabletop.permutation(8), timeout=20.0))) <= 10


def test_forty_objects_take_few_searches():
    solution = solve(tabletop.permutation(40), timeout=30.0)
    assert solution.status == "solved"
    assert solution.report.counts["iterations"] <= 12


def test_moves_stay_out_of_the_search():
    report = solve(tabletop.sort(4), timeout=20.0).report
    assert not any("move" in action for skeleton in report.skeletons for action in skeleton.actions)


def test_a_skeleton_is_followed():
    problem = tabletop.sort(3)
    pick = lambda obj: ("pick", obj, ANY, ANY, ANY, ANY, ANY)  # noqa: E731
    solution = solve(problem, timeout=20.0, constraints=Constraints(skeleton=(pick("o2"), ("place",), pick("o0"), ANY)))
    check(problem, solution)
    assert moved(solution) == ["o2", "o0", "o1"]


def test_forbidden_actions_do_not_occur():
    problem = tabletop.permutation(3)
    place = ("place", "o0", (-0.3, -0.4), ANY, ANY, ANY, ANY)
    constraints = Constraints(forbidden=(place, ("pick", "o1", ANY, 0.0, ANY, ANY, ANY)))
    solution = solve(problem, timeout=20.0, constraints=constraints)
    check(problem, solution)
    assert not any(a.name == "pick" and a.args[0] == "o1" and a.args[2] == 0.0 for a in solution.plan)


def test_constraints_about_unknown_actions_are_refused():
    with pytest.raises(DomainError, match="did you mean 'pick'"):
        solve(tabletop.sort(1), constraints=Constraints(forbidden=(("pik", ANY),)))
    with pytest.raises(DomainError, match="takes 6 arguments"):
        solve(tabletop.sort(1), constraints=Constraints(forbidden=(("pick", ANY),)))


def after(problem, solution, count):
    """The problem as it is once the first actions of the plan are done."""
    init = dict.fromkeys(problem.init)
    for action in solution.plan[:count]:
        match action.name, action.args:
            case "move-free" | "move-holding", (*_, q1, q2, _):
                init.pop(("AtConf", q1))
                init[("AtConf", q2)] = None
            case "pick", (o, p, g, a, l, _):
                del init[("AtPose", o, p)], init[("HandEmpty",)], init[("AtConf", a)]
                init |= dict.fromkeys([("AtGrasp", o, g), ("AtConf", l)])
            case "place", (o, p, g, a, l, _):
                del init[("AtGrasp", o, g)], init[("AtConf", l)]
                init |= dict.fromkeys([("AtPose", o, p), ("HandEmpty",), ("AtConf", a)])
    return dataclasses.replace(problem, init=list(init))


@pytest.mark.parametrize("executed", [2, 4])
def test_the_rest_of_a_plan_is_kept_while_it_is_valid(executed):
    problem = tabletop.sort(3)
    first = solve(problem, timeout=20.0)
    again = solve(after(problem, first, executed), timeout=20.0, reuse=Reuse.after(first, executed))
    symbolic = [a for a in first.plan[executed:] if not a.name.startswith("move")]
    assert [a for a in again.plan if not a.name.startswith("move")] == symbolic
    assert again.report.counts["iterations"] == 0


def test_a_new_plan_is_made_where_the_old_one_is_barred():
    problem = tabletop.sort(2)
    first = solve(problem, timeout=20.0)
    later = after(problem, first, 4)
    place = next(action for action in first.plan[4:] if action.name == "place")
    stranger = [
        ("Movable", "x"),
        ("Placement", "x", place.args[1]),
        ("OnTable", "x", place.args[1]),
        ("AtPose", "x", place.args[1]),
    ]
    barred = dataclasses.replace(later, init=[*later.init, *stranger])
    again = solve(barred, timeout=20.0, reuse=Reuse.after(first, 4))
    check(barred, again)


def test_the_report_is_json_and_a_table_and_the_picture_is_graphviz():
    solution = solve(tabletop.clutter(9), timeout=20.0)
    data = json.loads(json.dumps(solution.report.as_dict()))
    assert data["status"] == "solved"
    assert {"grounding", "search", "binding", "sampling"} == set(data["seconds"])
    assert data["skeletons"][-1]["bound"]
    assert "inverse-kinematics" in str(solution.report)
    assert solution.picture.startswith("digraph plan {")
    assert solution.picture.count("shape=box") == len(solution.plan)


def test_the_same_seed_gives_the_same_plan_in_every_process():
    code = (
        "from tests.planning.problems import tabletop; from tamp.planning import solve;"
        "print([(a.name, a.args) for a in solve(tabletop.permutation(5), seed=3).plan])"
    )
    outputs = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "PYTHONHASHSEED": hash_seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for hash_seed in ("1", "2")
    }
    assert len(outputs) == 1
    assert outputs.pop().strip() != "None"


def test_an_interrupt_keeps_the_best_plan():
    class Interrupting:
        def __init__(self, inner):
            self.inner, self.calls = inner, 0

        def __call__(self, task, timeout, bound=None, effort=math.inf):
            self.calls += 1
            if bound is not None:
                raise KeyboardInterrupt
            return self.inner(task, timeout, bound, effort)

    from tamp.planning.search.fast_downward import FastDownward

    solution = solve(tabletop.sort(2), timeout=20.0, success_cost=1.0, search=Interrupting(FastDownward("ff")))
    assert solution.status == "interrupted"
    assert solution.plan is not None
