"""Every algorithm on problems such as PDDLStream's users have, with no hints: what it solves, and in what time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from statistics import median

from benchmarks.parts.harness import Row, main
from benchmarks.pddlstream.belief import hidden
from benchmarks.pddlstream.features import cash, counting, cutting, floors, latent, modes, pushing
from benchmarks.pddlstream.known import doors, guards, jugs, meeting, tray
from benchmarks.pddlstream.roads import logistics, visits
from benchmarks.pddlstream.shapes import field, shelf, states, tea
from benchmarks.pddlstream.shelf import carrying, optimised
from benchmarks.pddlstream.small import cooking, filling, packing, pushes, roadmap, searching, teams
from benchmarks.pddlstream.trips import alley, survey
from tamp import clock
from tamp.planning import Problem, solve
from tests.planning.problems import banks, clearing, continuous, fluents

FAR = {"left": (-1.0, 5.5), "right": (2.5, 30.0)}

LINE = {"floor": (-10.0, 10.0), "goal": (5.0, 10.0), "slit": (-10.0, -8.5), "stove": (5.0, 10.0), "middle": (-2.0, 2.0)}

EITHER = ["slit", "goal"]

HOMES, POINTS = (0.0, 4.0, 10.0, 7.0), (1.0, 9.0, 5.0, 4.5, 3.0)

KNOWN: dict[str, Callable[[], tuple[Problem, float]]] = {
    "guards watch cells, 2 of them": lambda: guards(6, ((2, 1), (4, 0))),
    "guards watch cells, one to be lured": lambda: guards(8, ((2, 0), (4, 0), (4, 1))),
    "doors that are discovered, 5 rooms": lambda: doors(5),
    "meeting, 3 robots": lambda: meeting(HOMES[:3], POINTS),
    "meeting, 4 robots": lambda: meeting(HOMES, POINTS),
    "meeting, where one is at home": lambda: meeting(HOMES[:3], POINTS, at_home=(0,)),
    "jugs of 5 and 3 litres, 4 wanted": lambda: jugs((5.0, 3.0), 4.0),
    "eggs on a tray, 2 by the rough road": lambda: tray(2),
    "eggs on a tray, 5 by the long one": lambda: tray(5),
}
"""Problems with the cost of their cheapest plans."""

PROBLEMS: dict[str, Callable[[], Problem]] = {
    "pick and place, 3 blocks": lambda: packing(3, (8.0, 1.0)),
    "tight shelf, 4 blocks on 5.5": lambda: packing(4, (5.5, 1.0)),
    "tight box, 4 blocks in 3 x 3": lambda: packing(4, (3.0, 3.0)),
    "two arms, 2 blocks handed over": lambda: packing(2, (4.0, 1.0), FAR),
    "inverse kinematics fails 9 in 10, 5 blocks": lambda: packing(5, (9.0, 2.0), reached=0.1),
    "costs by distance, 2 blocks": lambda: packing(2, (6.0, 1.0), costs=True),
    "cooking, 2 foods": lambda: cooking(2),
    "cooking, 5 foods": lambda: cooking(5),
    "roadmap, 60 vertices": lambda: roadmap(60),
    "wild pushes, 3 away": lambda: pushes(3),
    "wild pushes, 6 away": lambda: pushes(6),
    "belief, 3 places": lambda: searching(3),
    "belief, 2 things in 3 places": hidden,
    "filling, 3 litres": lambda: filling(3.0),
    "filling, 50 litres": lambda: filling(50.0),
    "rovers, 3 tasks, 2 rovers": lambda: teams(3, 2),
    "rovers, 6 tasks, 3 rovers": lambda: teams(6, 3),
    "line, 2 blocks into 5 cells": lambda: shelf([0.0, -3.0], {"A": "goal", "B": "goal"}, LINE),
    "line, region blocked by one of 3": lambda: shelf([0.0, 7.5, -9.0], {"A": "goal"}, LINE),
    "line, region blocked by 2, one too many": lambda: shelf([0.0, 6.5, 8.5], {"A": "goal"}, LINE),
    "line, 2 arms, 2 blocks mirrored": lambda: shelf([-2.0, -5.0], {"A": 2.0, "B": 5.0}, LINE, arms=2),
    "line, one of two regions is too narrow": lambda: shelf([0.0, -3.0], {"A": EITHER, "B": EITHER}, LINE),
    "line, cooked and put elsewhere": lambda: shelf([-7.0, 0.3], {"A": ["stove", "middle"]}, LINE),
    "states as values": lambda: states(5.0),
    "field, lines of 0.25 to an area": lambda: field(0.25),
    "field, lines of 0.25 to a corner": lambda: field(0.25, area=False),
    "field, lines of 0.5 to an area": lambda: field(0.5),
    "tea, 3 cups, no samplers": lambda: tea(3),
    "row, 4 things lifted out of the way": lambda: clearing.row(4),
    "washing, 4 foods, tests told the state": lambda: fluents.washing(4),
    "line, 3 blocks, effects that wreck": lambda: continuous.line(3, continuous.wrecking_effects()),
    "line, 2 blocks, an optimizer": lambda: optimised([-4.0, 0.0], {"A": "goal", "B": "goal"}, LINE),
    "line, 1 block past a tall one": lambda: carrying([-4.0, 0.0], {"A": "goal"}, LINE),
    "line, 1 block past 2 tall ones": lambda: carrying([-4.0, 0.0, 2.0], {"A": "goal"}, LINE),
    "line, 1 block past a tall one, by paths": lambda: carrying([-4.0, 0.0], {"A": "goal"}, LINE, paths=True),
    "counting to 10": lambda: counting(10),
    "counting to 5 and to -5": lambda: counting(5, both=True),
    "cutting a rope, 3 places": lambda: cutting(3),
    "cash, 40 from machines of 30": lambda: cash(40.0),
    "latent values, 3 blocks": lambda: latent(3),
    "pushing 3 blocks on a grid": lambda: pushing(3),
    "modes, beyond 5": lambda: modes(5.0),
    "floors, 4 boxes, no streams": lambda: floors(4),
    "roads that may be closed, 4 packages": lambda: logistics(20, 4, 2),
    "roads that may be closed, 12 packages": lambda: logistics(50, 12, 2),
    "wild roadmaps, 2 regions": lambda: visits(2),
    "alley, 3 crates": lambda: alley({"a": 0.0, "b": 2.0, "c": -2.0}, {"a": "bay", "b": "oven", "c": "bay"}),
    "alley, bay taken": lambda: alley({"a": 0.0, "b": 6.5}, {"a": "bay"}, bays={"bay": (5.5, 7.5)}),
    "alley, a high crate in the way": lambda: alley({"a": 0.0, "b": 2.5}, {"a": "bay"}, high=("b",)),
    "alley, 2 cranes": lambda: alley({"a": -3.0, "b": 3.0}, {"a": "bay", "b": "bay"}, cranes=2),
    "survey, 1 drone": lambda: survey(1, 1, 1),
    "survey, 2 drones": lambda: survey(2, 3, 2),
    "garden, spots that are looked for in vain": lambda: banks.garden(2),
    "garden, spots that are seldom found, or never": lambda: banks.garden(2, 0.1),
    "garden, a parameter of which nothing is said": lambda: banks.garden(3, idle=True),
    **{name: lambda make=make: make()[0] for name, make in KNOWN.items()},  # type: ignore[misc]
}
ALGORITHMS = ("adaptive", "binding", "focused", "incremental")
SEEDS = range(5)
LIMIT_S = 20.0


def rows(quick: bool) -> Iterator[Row]:
    """One row for each problem and algorithm."""
    for name, make in PROBLEMS.items():
        for algorithm in ("adaptive",) if quick else ALGORITHMS:
            yield _row(name, make(), algorithm, range(1) if quick else SEEDS, 5.0 if quick else LIMIT_S)


def _row(name: str, problem: Problem, algorithm: str, seeds: range, limit: float) -> Row:
    solutions, wall, processor = [], [], []
    for seed in seeds:
        began = time.perf_counter()
        with clock.limits_in("processor"):
            before = clock.now()
            solutions.append(solve(problem, algorithm=algorithm, timeout=limit, seed=seed))
            processor.append(clock.now() - before)
        wall.append(time.perf_counter() - began)
    solved = [solution for solution in solutions if solution.plan is not None]
    return {
        "problem": name,
        "algorithm": algorithm,
        "solved": f"{len(solved)} of {len(solutions)}",
        "processor_s": median(processor),
        "wall_s": median(wall),
        "actions": median(len(s.plan or ()) for s in solved) if solved else "",
        "cost": median(s.cost for s in solved) if solved else "",
        "unsolved": "; ".join(sorted({s.status for s in solutions if s.plan is None})),
    }


if __name__ == "__main__":
    main("pddlstream_like", lambda quick: list(rows(quick)))
