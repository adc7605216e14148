"""One candidate for each object: together they explain most, and do not share space."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.perception.estimation import selection
from tamp.perception.estimation.candidates import Candidate
from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.models.object_model import ObjectModel, object_model
from tamp.perception.estimation.selection import Selection
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box
from tamp.task.mesh.parts import Part, convex_hull

pytest.importorskip("embreex", reason="the extra perception is not installed")

BIG, SMALL = (object_model(plain(Box(size))) for size in ((0.2, 0.2, 0.1), (0.06, 0.06, 0.06)))
CLOUD = Cloud(np.zeros((300, 3)), np.zeros((300, 3)), np.zeros((300, 3)))


def _candidate(x: float, first: int, last: int, weight: float = 1.0, free: float = 0.0) -> Candidate:
    pose = np.eye(4)
    pose[0, 3] = x
    points = np.arange(first, last)
    return Candidate(pose, points, np.full(len(points), weight), 0.5, 0.0, free)


def _chosen(*found: list[Candidate], models: tuple[object, ...] = (BIG, SMALL)) -> Selection:
    choice = Selection(CLOUD, models, found)  # type: ignore[arg-type]
    choice.solve()
    return choice


def test_the_small_one_leaves_the_big_ones_surface() -> None:
    big = [_candidate(0.0, 0, 200)]
    small = [_candidate(0.0, 0, 60), _candidate(0.5, 200, 250)]
    assert _chosen(big, small).chosen == [0, 1]


def test_what_explains_nothing_more_is_not_there() -> None:
    assert _chosen([_candidate(0.0, 0, 200)], [_candidate(0.5, 0, 60)]).chosen == [0, -1]


def test_a_little_better_on_what_another_explains_is_less_than_what_none_explains() -> None:
    """Three tenths of 200 points are gained on a surface that is explained by half, for 50 whole points elsewhere."""
    shaded = [_candidate(0.0, 0, 200, weight=0.5)]
    assert _chosen(shaded, [_candidate(0.3, 0, 200, weight=0.8), _candidate(0.5, 200, 250)]).chosen == [0, 1]


def test_free_space_costs() -> None:
    assert _chosen([_candidate(0.0, 0, 200, free=250.0)], []).chosen == [-1, -1]


def test_two_do_not_stand_in_one_place() -> None:
    big = [_candidate(0.0, 0, 200)]
    small = [_candidate(0.01, 200, 240)]  # well inside the big one
    assert _chosen(big, small).chosen == [0, -1]


def test_what_masks_show_is_there_even_inside_another() -> None:
    found = [[_candidate(0.0, 0, 200)], [_candidate(0.01, 200, 240)]]
    choice = Selection(CLOUD, (BIG, SMALL), found, present=True)
    choice.solve()
    assert choice.chosen == [0, 0]


def test_a_better_exchange_is_found() -> None:
    twins = (SMALL, SMALL)
    first = [_candidate(0.0, 0, 100), _candidate(0.5, 100, 190)]
    second = [_candidate(0.0, 0, 95)]
    assert _chosen(first, second, models=twins).chosen == [1, 0]


def test_what_two_others_stand_in_the_way_of_is_put_in_where_all_gain_by_it() -> None:
    """What explains 90 shares space with both others, one of which explains hardly less elsewhere."""
    wide = [_candidate(0.12, 100, 290), _candidate(0.5, 100, 288)]
    choice = _chosen([_candidate(0.0, 0, 90)], [_candidate(-0.04, 0, 60)], wide, models=(SMALL, SMALL, BIG))
    assert choice.chosen == [0, -1, 1]


def test_two_of_a_kind_are_not_in_one_place() -> None:
    chosen = _chosen([_candidate(0.0, 0, 100)], [_candidate(0.001, 0, 103)], models=(SMALL, SMALL)).chosen
    assert sorted(chosen) == [-1, 0]


def test_twins_of_other_meshes_are_uncertain_and_different_things_are_not() -> None:
    other = object_model(plain(Box((0.061, 0.06, 0.06))))
    alike = _chosen(
        [_candidate(0.0, 0, 100), _candidate(0.5, 100, 198)],
        [_candidate(0.5, 100, 200), _candidate(0.0, 0, 99)],
        models=(SMALL, other),
    )
    assert alike.chosen == [0, 0]
    assert alike.lead_over_exchange(0) == pytest.approx(3.0)
    apart = _chosen([_candidate(0.0, 0, 100)], [_candidate(0.5, 100, 200)], models=(SMALL, other))
    assert apart.lead_over_exchange(0) == float("inf")


def _holder() -> Surface:
    """An open box of walls that are 3 mm thick, 0.3 m long: its points lie farther apart than that."""
    walls = [((0.3, 0.003, 0.2), (0.0, y, 0.1)) for y in (-0.03, 0.03)]
    walls += [((0.003, 0.06, 0.2), (x, 0.0, 0.1)) for x in (-0.15, 0.15)] + [((0.3, 0.06, 0.003), (0.0, 0.0, 0.0015))]
    pieces = [(plain(Box(size)), shift) for size, shift in walls]
    first = np.cumsum([0, *(len(piece.vertices) for piece, _ in pieces)])
    return Surface(
        np.concatenate([piece.vertices + shift for piece, shift in pieces]),
        np.concatenate([piece.faces + start for (piece, _), start in zip(pieces, first, strict=False)]),
        np.concatenate([piece.colors for piece, _ in pieces]),
    )


@pytest.mark.parametrize(("y", "kept"), [(0.0, True), (0.0255, True), (0.05, False)])
def test_what_stands_between_thin_walls_shares_no_space_with_them(y: float, kept: bool) -> None:
    holder, book = object_model(_holder()), object_model(plain(Box((0.26, 0.004, 0.16))))
    thick = object_model(plain(Box((0.26, 0.05, 0.16))))
    model = book if kept else thick
    standing = _candidate(0.0, 200, 260)
    standing.pose[1:3, 3] = y, 0.1
    assert _chosen([_candidate(0.0, 0, 200)], [standing], models=(holder, model)).chosen == [0, 0 if kept else -1]


def _scanned(parts: tuple[Part, ...]) -> ObjectModel:
    """A holder of two walls, whose scan shows a block."""
    look = plain(Box((0.2, 0.1, 0.15)))
    return object_model(Surface(look.vertices, look.faces, look.colors, parts))


def test_what_stands_in_a_hollow_that_a_scan_shows_as_filled_is_kept() -> None:
    walls = [np.add(plain(Box((0.2, 0.01, 0.15))).vertices, (0.0, side * 0.045, 0.0)) for side in (1, -1)]
    book = object_model(plain(Box((0.15, 0.05, 0.15))))
    found = [[_candidate(0.0, 0, 200)], [_candidate(0.0, 200, 240)]]
    assert _chosen(*found, models=(_scanned(tuple(convex_hull(wall) for wall in walls)), book)).chosen == [0, 0]
    assert _chosen(*found, models=(_scanned(()), book)).chosen == [0, -1]


def test_what_shares_space_with_something_is_told() -> None:
    selection = _chosen([_candidate(0.0, 0, 200)], [_candidate(0.5, 200, 240), _candidate(0.09, 240, 300)])
    selection.chosen = [0, 1]
    assert selection.meeting(0) == [1]
    assert selection.meeting(1) == [0]
    selection.chosen = [0, 0]
    assert selection.meeting(0) == []


def test_what_is_known_of_shared_space_stays_so_among_more_candidates_and_for_all_of_a_mesh(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []
    monkeypatch.setattr(selection, "shared", lambda *pair: asked.append(pair) or 0.0)
    big, small = [_candidate(0.0, 0, 200)], [_candidate(0.05, 200, 250)]
    before = _chosen(big, small, small, models=(BIG, SMALL, SMALL))
    assert len(asked) == 2  # either in the other, for both small ones at once
    more = _candidate(-0.05, 250, 290)
    after = Selection(CLOUD, (BIG, SMALL, SMALL), [big, [*small, more], [*small, more]], before=before)
    assert after.chosen == before.chosen
    after.solve()
    assert len(after.chosen) == 3 and min(after.chosen) >= 0
    assert len(asked) == 2 + 2 + 2  # what came, with the big one and with the other small one


def test_what_cannot_be_chosen_is_not_asked_what_space_it_shares(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    clash = Selection.clash

    def counted(choice: Selection, i: int, k: int) -> float:
        asked.append(k)
        return clash(choice, i, k)

    monkeypatch.setattr(Selection, "clash", counted)
    found = [_candidate(0.1 * x, 0, 100 + x) for x in range(24)]
    choice = Selection(CLOUD, (BIG,), [found])
    choice.solve()
    assert choice.chosen == [23]
    assert set(asked) <= {22, 23}


@pytest.mark.parametrize("present", [False, True])
def test_the_choice_is_the_first_of_the_greatest_gains(present: bool) -> None:
    rng = np.random.default_rng(0)
    for _ in range(40):
        found = [
            [
                _candidate(
                    float(rng.integers(0, 4)) / 10,
                    int(a),
                    int(a) + int(rng.integers(0, 60)),
                    free=float(rng.integers(60)),
                )
                for a in rng.integers(0, 240, size=8)
            ]
            for _ in range(2)
        ]
        choice = Selection(CLOUD, (BIG, SMALL), found, present=present)
        choice.chosen = [int(rng.integers(8)), -1]
        gains = choice.gains(1)
        choice._choose(1)
        assert choice.chosen[1] == (int(gains.argmax()) if present or gains.max() > 0 else -1)


def test_what_stands_nowhere_and_could_stand_there_makes_a_choice_uncertain() -> None:
    big, small = [_candidate(0.0, 0, 200)], [_candidate(0.0, 0, 190)]
    choice = _chosen(big, small)
    assert choice.lead_over_absent(0) == pytest.approx(10.0)
    assert choice.chosen == [0, -1]
    assert _chosen(big, small, models=(BIG, BIG)).lead_over_absent(0) == float("inf"), "nobody tells twins apart"
    elsewhere = _chosen(big, [*small, _candidate(0.5, 200, 250)])
    assert elsewhere.chosen == [0, 1] and elsewhere.lead_over_absent(0) == float("inf")
    assert _chosen(big, [_candidate(0.0, 0, 190, free=300.0)]).lead_over_absent(0) == float("inf"), "it is seen through"
