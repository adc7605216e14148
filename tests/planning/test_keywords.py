"""PDDLStream's way of asking: its problems, planners, algorithms, keywords and constraints, and what solve returns."""

from __future__ import annotations

import warnings
from inspect import signature

import pytest

import tamp.planning
from tamp.errors import DomainError, DomainWarning
from tamp.planning import Constraints, Problem, SearchResult, pddlstream
from tamp.planning.keywords import (
    ALGORITHMS,
    MEANINGFUL,
    OWN,
    PLANNERS,
    PLANNERS_OF_OTHER_KINDS,
    WITHOUT_MEANING,
    constraints_of,
    search_of,
)
from tamp.planning.pddlstream import (
    INF,
    WILD,
    FunctionInfo,
    PartialInputs,
    PDDLProblem,
    PlanConstraints,
    StreamInfo,
    defer_shared,
    from_gen_fn,
    from_test,
    get_defer_all_unbound,
    get_defer_any_unbound,
    never_defer,
    print_solution,
    solve,
    solve_focused,
    solve_incremental,
    solve_restart,
    solve_serialized,
)
from tamp.planning.search.best_first import BuiltinSearch
from tamp.planning.search.fast_downward import CONFIGURATIONS

DOMAIN = """(define (domain d) (:predicates (Thing ?x) (Grasp ?x ?g) (Good ?g) (Held ?x) (Clean ?x))
  (:functions (total-cost))
  (:action wash :parameters (?x) :precondition (Thing ?x) :effect (and (Clean ?x) (increase (total-cost) 2)))
  (:action pick :parameters (?x ?g) :precondition (and (Grasp ?x ?g) (Good ?g) (Clean ?x))
    :effect (and (Held ?x) (increase (total-cost) 1))))"""
STREAMS = """(define (stream s)
  (:stream sample :inputs (?x) :domain (Thing ?x) :outputs (?g) :certified (Grasp ?x ?g))
  (:stream test-good :inputs (?x ?g) :domain (Grasp ?x ?g) :certified (Good ?g)))"""
STREAM_MAP = {
    "sample": from_gen_fn(lambda x: ((i,) for i in range(4))),
    "test-good": from_test(lambda x, g: g == 2),
}
PROBLEM = PDDLProblem(DOMAIN, {}, STREAMS, STREAM_MAP, [("Thing", "cup"), ("=", ("total-cost",), 0)], ("Held", "cup"))


@pytest.fixture(autouse=True)
def _no_other_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def test_a_problem_is_six_values_and_a_solution_three(capsys):
    for problem in (PROBLEM, tuple(PROBLEM)):
        solution = solve(problem, max_time=20)
        plan, cost, evaluations = solution
        assert [(name, args) for name, args in plan] == [("wash", ("cup",)), ("pick", ("cup", 2))]
        assert (cost, solution.status) == (3.0, "solved")
        assert ("grasp", "cup", 2) in evaluations
    print_solution(solution)
    assert capsys.readouterr().out.splitlines()[-1] == " 2) pick cup 2"
    with pytest.raises(DomainError, match=r"expected a Problem, or a PDDLProblem of \(domain_pddl, constant_map.* str"):
        solve("domain.pddl")


def test_no_plan_is_none_and_infinite():
    plan, cost, _ = solve(PROBLEM._replace(goal=("Held", "pan")), max_time=20.0)
    assert (plan, cost) == (None, INF)


@pytest.mark.parametrize("planner", [*PLANNERS, *CONFIGURATIONS])
def test_every_planner_has_a_search(planner):
    assert search_of(planner) in CONFIGURATIONS
    assert solve(PROBLEM, planner=planner, max_time=20).solved


@pytest.mark.parametrize("algorithm", [*ALGORITHMS, "abstract-focused", "serialized"])
def test_every_algorithm_has_one_here(algorithm):
    assert solve(PROBLEM, algorithm=algorithm, max_time=20).solved


@pytest.mark.parametrize("solver", [solve_focused, solve_incremental, solve_serialized])
def test_each_solver_has_its_name(solver):
    solution = solver(PROBLEM, max_time=20)
    assert solution.solved
    assert solver.__name__ in {
        f"solve_{name}" for name in (solution.report.algorithm, solution.report.strategy["name"])
    }


def test_what_asks_for_nothing_is_accepted_in_silence():
    usual = {name: values[0] for name, (values, _) in WITHOUT_MEANING.items() if values}
    assert solve(PROBLEM, **usual, replan_actions=set(), hierarchy=[], stream_info={}, max_time=20).solved


@pytest.mark.parametrize("name", [name for name, (values, _) in WITHOUT_MEANING.items() if True not in values[:1]])
def test_what_has_no_meaning_here_is_accepted_with_a_warning(name):
    with pytest.warns(DomainWarning, match=f"{name}='other' has no effect here: .+"):
        assert solve(PROBLEM, **{name: "other"}, max_time=20).solved


def test_a_keyword_that_nobody_has_is_refused():
    with pytest.raises(TypeError, match="unexpected keyword 'max_tim'; did you mean 'max_time'"):
        solve(PROBLEM, max_tim=3)


def test_a_keyword_that_is_like_none_gets_all_and_no_guess():
    with pytest.raises(
        TypeError, match=r"'depths'; there are: algorithm, .*; of PDDLStream's: planner, .*initial_comp"
    ):
        solve(PROBLEM, depths=3)


def test_a_planner_that_nobody_has_is_refused_with_the_names_of_both():
    with pytest.raises(DomainError, match=r"'ff-wastar9'; did you mean 'ff-wastar\d'\? there are: builtin, ff, .*symk"):
        solve(PROBLEM, planner="ff-wastar9")


@pytest.mark.parametrize("planner", PLANNERS_OF_OTHER_KINDS)
def test_planners_of_other_kinds_are_searches_with_a_warning(planner):
    with pytest.warns(DomainWarning, match=f"planner='{planner}' is '.+' here: .+") as said:
        assert solve(PROBLEM, planner=planner, max_time=20).solved
    assert len(said) == 1 and said[0].filename == __file__


def test_a_warning_names_the_line_that_calls_solve():
    for keywords in ({"layers": 3}, {"stream_info": {"x": StreamInfo()}}, {"constraints": PlanConstraints(hint=True)}):
        with pytest.warns(DomainWarning) as said:
            solve(PROBLEM, max_time=20, **keywords)
        assert [warning.filename for warning in said] == [__file__]


def test_the_keywords_are_those_of_solve():
    named = [p.name for p in signature(tamp.planning.solve).parameters.values() if p.kind == p.KEYWORD_ONLY]
    assert tuple(named) == OWN
    assert not {*MEANINGFUL, *WITHOUT_MEANING} & {*OWN}


def test_each_search_has_no_more_time_than_the_planner_is_given():
    given = []

    def search(task, timeout, bound=None, effort=INF):
        given.append(timeout)
        return BuiltinSearch()(task, timeout, bound, effort) if len(given) > 2 else SearchResult(None, timed_out=True)

    assert solve(PROBLEM, planner=search, max_planner_time=0.5, max_time=20).solved
    assert set(given) == {0.5}


def test_verbose_prints_the_report(capsys):
    assert str(solve(PROBLEM, verbose=True, max_time=20).report) in capsys.readouterr().out


def test_what_is_known_of_streams_may_be_given_to_solve():
    info = {"sample": StreamInfo(p_success=None, overhead=2.0), "test-good": StreamInfo(eager=True)}
    assert solve(PROBLEM, stream_info=info, max_time=20).solved
    with pytest.warns(DomainWarning, match=r"stream_info names 'sampel', which is no stream and is ignored; did you m"):
        assert solve(PROBLEM, stream_info={"sampel": StreamInfo()}, max_time=20).solved


def test_options_of_streams_without_effect_are_said_once():
    with pytest.warns(DomainWarning, match="without effect here: opt_gen_fn, effort_fn;") as said:
        StreamInfo(opt_gen_fn=PartialInputs("?x", unique=True), effort_fn=len, negate=True, verbose=False)
    assert len(said) == 1
    with pytest.warns(DomainWarning, match="opt_gen_fn"):
        FunctionInfo(opt_fn=lambda *args: 1.0)
    FunctionInfo(eager=False, defer_fn=get_defer_any_unbound())  # nothing is put off there either, by itself
    for defer in (defer_shared, never_defer, get_defer_any_unbound(), get_defer_all_unbound(inputs="?x")):
        assert StreamInfo(defer_fn=defer, estimate=True).defer is None


@pytest.mark.parametrize("exact", [True, False])
def test_skeletons_are_followed(exact):
    skeletons = [[("wash", ["?x"]), ("wash", ["cup"]), ("pick", ["?x", WILD])]]
    solution = solve(PROBLEM, constraints=PlanConstraints(skeletons, exact=exact, max_cost=6.0), max_time=20)
    assert [name for name, _ in solution.plan] == ["wash", "wash", "pick"]
    assert solve(PROBLEM, constraints=PlanConstraints(skeletons, max_cost=4.0), max_time=20).plan is None


def test_other_actions_may_stand_between_where_a_skeleton_is_not_exact():
    skeletons = [[("pick", [WILD, "?g"])]]
    loose = solve(PROBLEM, constraints=PlanConstraints(skeletons, exact=False), max_time=20)
    assert [name for name, _ in loose.plan] == ["wash", "pick"]
    assert solve(PROBLEM, constraints=PlanConstraints(skeletons), max_time=20).plan is None


def test_one_of_several_skeletons_and_objects_of_groups():
    skeletons = [[("wash", ["?x"])], [("wash", ["item"]), ("pick", ["item", WILD])]]
    constraints = PlanConstraints(skeletons, groups={"item": ["cup"]})
    assert [name for name, _ in solve(PROBLEM, constraints=constraints, max_time=20).plan] == ["wash", "pick"]


def test_constraints_that_are_not_supported_are_said():
    assert constraints_of(Constraints()) == (Constraints(), INF)
    assert constraints_of(PlanConstraints(max_cost=3.0)) == (None, 3.0)
    with pytest.warns(DomainWarning, match="hint has no effect"):
        constraints_of(PlanConstraints([[("wash", ["?x"])]], hint=True))


def test_ours_are_taken_with_those_of_there():
    problem = Problem(DOMAIN, STREAMS, STREAM_MAP, PROBLEM.init, PROBLEM.goal)
    assert solve(
        problem, planner="max-astar", success_cost=3.0, max_time=20, stream_info={"sample": StreamInfo()}
    ).solved


@pytest.mark.parametrize("groups", [["cup"], {"item": 3}])
def test_groups_that_are_none(groups):
    with pytest.raises(DomainError, match="expected groups such as"):
        constraints_of(PlanConstraints([[("pick", ["item"])]], groups=groups))


def test_what_scripts_do_with_plans_and_formulas(capsys):
    plan, cost, evaluations = solve_restart(PROBLEM, max_time=20, max_restarts=0, statistics=False, fail_fast=True)
    pddlstream.print_solution((plan, cost, evaluations))
    assert "1) wash cup" in capsys.readouterr().out
    pddlstream.print_solution((None, INF, []))
    assert capsys.readouterr().out == "Solved: False\nCost: inf\n"
    assert not pddlstream.is_plan(pddlstream.INFEASIBLE) and not pddlstream.is_plan(pddlstream.FAILED)
    assert pddlstream.get_length(pddlstream.INFEASIBLE) == INF
    assert list(map(pddlstream.str_from_action, plan)) == ["wash(cup)", "pick(cup, 2)"]
    assert pddlstream.concatenate([1], (2, 3)) == (1, 2, 3)
    assert list(map(pddlstream.get_parameter_name, ("?x", "x", 3))) == ["x", "x", 3]
    assert pddlstream.Type("?x", "block") == ("?x", "-", "block")
    goal = (pddlstream.AND, (pddlstream.EXISTS, ("?x",), ("Held", "?x")))
    assert solve(PROBLEM._replace(goal=goal), max_time=20).solved


def test_what_asks_for_statistics_is_told_where_they_are():
    with pytest.warns(DomainWarning, match="solution.report.streams"):
        solve(PROBLEM, max_time=20, statistics=True)
