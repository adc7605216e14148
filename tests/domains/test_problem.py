import pytest

from tamp.domains.samplers import resolve_samplers
from tamp.domains.skill import Question
from tamp.domains.tabletop import DOMAIN
from tamp.formats.obj import box_obj
from tamp.planning import solve
from tamp.streams import collisions
from tamp.streams.values import Configuration, Grasp, Placement
from tamp.streams.workspace import Workspace
from tamp.task import At, Box, Cylinder, In, Mesh, Object, On, Pose, Region
from tests.streams.tables import CRATE, CUBE, RED, SLAB, workspace_of

HOME = Configuration((0.0,) * 7, 0.08)
SAMPLERS = dict.fromkeys(DOMAIN.samplers, print)


@pytest.fixture(scope="module")
def table():
    return workspace_of(RED, SLAB, CUBE)


def problem_of(workspace, held=None):
    return DOMAIN.problem(workspace, SAMPLERS, Question(HOME, held))


def facts(workspace, predicate, held=None):
    return [fact[1:] for fact in problem_of(workspace, held).init if fact[0] == predicate]


def wanting(obj, goal):
    return Object(obj.name, obj.shape, obj.pose, goal)


def test_every_object_may_move_and_stands_where_it_stands(table):
    assert facts(table, "Movable") == [("red",), ("slab",), ("cube",)]
    assert facts(table, "AtPose") == [(name, table.start[name]) for name in ("red", "slab", "cube")]
    assert {(name, "table") for name in table.start} <= set(facts(table, "Placeable"))


def test_only_what_may_move_in_a_question_is_said_to_and_has_a_goal_placement(table):
    asked = DOMAIN.problem(table, SAMPLERS, Question(HOME, movable={"cube"}))
    assert [fact for fact in asked.init if fact[0] == "MayMove"] == [("MayMove", "cube")]
    assert ("Placement", "red", table.goals["red"]) not in asked.init
    assert {fact[1] for fact in asked.init if fact[0] == "Placement"} == {"red", "slab", "cube"}


def test_no_test_is_called_about_two_objects_that_stay(table):
    asked, samplers = [], {**resolve_samplers(DOMAIN.samplers)}

    def cfree(context, *inputs):
        asked.append(inputs[0])
        return collisions.test_cfree_placements(context, *inputs)

    samplers["test-cfree-placements"] = cfree
    home = Configuration(tuple(table.world.robot.spec.home), 0.08)
    problem = DOMAIN.problem(table, samplers, Question(home, movable={"red"}))
    solution = solve(problem, seed=0, timeout=600.0)
    assert [action.name for action in solution.plan] == ["move-free", "pick", "move-holding", "place"]
    assert set(asked) == {"red"}


def test_what_stands_on_the_table_rests_on_nothing_that_moves(table):
    assert ("slab", table.start["slab"]) in facts(table, "OnTable")
    assert facts(table, "RestsOn") == []


def test_what_stands_on_an_object_rests_on_it_where_it_is():
    workspace = workspace_of(SLAB, CUBE, on={"cube": ("slab",)})
    start = workspace.start
    assert facts(workspace, "RestsOn") == [("cube", start["cube"], "slab", start["slab"])]
    assert facts(workspace, "OnTable") == [("slab", start["slab"])]


def test_what_stands_on_two_rests_on_both():
    workspace = workspace_of(SLAB, RED, CUBE, on={"cube": ("red", "slab")})
    assert [(fact[0], fact[2]) for fact in facts(workspace, "RestsOn")] == [("cube", "red"), ("cube", "slab")]


def test_what_touches_another_and_needs_it_not_does_not_cover_it():
    blocks = [
        Object(n, Box((0.05, 0.05, 0.06)), Pose((x, 0.0, 0.03))) for n, x in (("p", -0.1), ("q", 0.0), ("r", 0.1))
    ]
    plank = Object("plank", Box((0.3, 0.05, 0.02)), Pose((0.0, 0.0, 0.07)))
    on = {"plank": ("p", "q", "r")}
    assert [fact[2] for fact in facts(workspace_of(*blocks, plank, on=on), "RestsOn")] == ["q"]
    shall = wanting(plank, On("p"))  # it is on that, whether or not it needs it
    assert [fact[2] for fact in facts(workspace_of(*blocks, shall, on=on), "RestsOn")] == ["p", "r"]


def test_a_goal_pose_is_a_placement_to_be_reached(table):
    goal = table.goals["red"]
    assert ("red", goal) in facts(table, "Placement")
    assert ("red", goal) in facts(table, "OnTable")
    assert ("AtPose", "red", goal) not in problem_of(table).init
    assert problem_of(table).goal == ("and", ("AtPose", "red", goal), ("HandEmpty",))


def test_a_goal_on_another_goal_rests_on_the_goal_and_not_on_the_start():
    slab = wanting(SLAB, At(Pose((0.1, 0.3, 0.015))))
    workspace = workspace_of(slab, wanting(CUBE, At(Pose((0.1, 0.3, 0.05)))))
    goals = {**workspace.goals, "cube": Placement(Pose((0.1, 0.3, 0.05)), ("slab",))}
    stacked = Workspace(workspace.task, workspace.world, workspace.start, goals)
    assert facts(stacked, "RestsOn") == [("cube", goals["cube"], "slab", goals["slab"])]


def test_a_goal_that_is_reached_already_is_the_start_and_no_second_placement(table):
    there = Workspace(table.task, table.world, table.start, {"red": table.start["red"]})
    assert facts(there, "Placement").count(("red", table.start["red"])) == 1
    assert problem_of(there).goal[1] == ("AtPose", "red", table.start["red"])
    assert ("AtPose", "red", table.start["red"]) in problem_of(there).init


@pytest.mark.parametrize(
    ("goal", "certified", "wanted"),
    [
        (On("shelf"), ("Placeable", "cube", "shelf"), ("On", "cube", "shelf")),
        (On("slab"), ("Stackable", "cube", "slab"), ("On", "cube", "slab")),
        (In("crate"), ("Insertable", "cube", "crate"), ("In", "cube", "crate")),
    ],
)
def test_a_symbolic_goal_says_what_may_be_put_where(goal, certified, wanted):
    shelf = Region("shelf", (0.1, 0.4), (0.2, 0.2))
    workspace = workspace_of(SLAB, CRATE, wanting(CUBE, goal), regions=(shelf,))
    problem = problem_of(workspace)
    assert certified in problem.init
    others = {fact[0] for fact in problem.init if fact[0] in ("Stackable", "Insertable")} - {certified[0]}
    assert not others
    assert problem.goal == ("and", wanted, ("HandEmpty",))


@pytest.mark.parametrize(("x", "inside"), [(-0.15, True), (-0.06, True), (-0.04, False)])
def test_what_stands_with_its_middle_on_a_region_is_in_it(x, inside):
    here = Region("here", (-0.15, 0.15), (0.2, 0.2))
    workspace = workspace_of(Object("cube", CUBE.shape, Pose((x, 0.15, 0.02))), regions=(here,))
    assert facts(workspace, "Region") == [("table",), ("here",)]
    assert facts(workspace, "InRegion") == ([("cube", workspace.start["cube"], "here")] if inside else [])


def test_what_is_on_a_region_is_told_by_the_middle_of_its_box_and_not_by_its_origin(tmp_path):
    path = tmp_path / "far.obj"
    path.write_text(box_obj("far", (0.4, 0.0, 0.0), (0.44, 0.04, 0.04)))
    here = Region("here", (-0.15, 0.15), (0.2, 0.2))
    workspace = workspace_of(Object("far", Mesh(path), Pose((-0.57, 0.13, 0.0))), regions=(here,))
    assert facts(workspace, "InRegion") == [("far", workspace.start["far"], "here")]


def test_the_hand_is_empty_or_holds_something(table):
    assert ("HandEmpty",) in problem_of(table).init
    grasp = Grasp(Pose(), 0.04)
    assert facts(table, "AtGrasp", held=("cube", grasp)) == [("cube", grasp)]
    assert facts(table, "Grasp", held=("cube", grasp)) == [("cube", grasp)]
    assert facts(table, "HandEmpty", held=("cube", grasp)) == []


def test_the_arm_is_where_it_is(table):
    assert facts(table, "AtConf") == facts(table, "Conf") == [(HOME,)]


def test_what_lies_flat_on_every_face_is_only_laid_on_the_table():
    disc = Object("disc", Cylinder(0.08, 0.02), Pose((0.0, 0.2, 0.131)), At(Pose((0.0, -0.2, 0.011))))
    workspace = workspace_of(CUBE, disc)
    start, goal = workspace.start["disc"], workspace.goals["disc"]
    init = problem_of(workspace).init
    assert ("LiesFlat", "disc", start) in init
    assert ("Placeable", "disc", "table") not in init
    assert ("LaidOnTable", "disc", goal) in init
    assert not {("OnTable", "disc", goal), ("PutOnTable", "disc", goal)} & set(init)


def test_what_lies_flat_on_some_face_is_put_aside_with_care_as_well():
    book = Object("book", Box((0.04, 0.17, 0.26)), Pose((0.0, 0.2, 0.13)))
    workspace = workspace_of(CUBE, book)
    own = problem_of(workspace).init
    assert ("LiesFlat", "book", workspace.start["book"]) in own
    assert ("Placeable", "book", "table") not in own
    assert ("Placeable", "cube", "table") in own
