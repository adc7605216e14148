"""Corruptions of valid plans, each with the kind of problem that the checker must find in it.

A mutation takes a task, a valid plan and a random generator and returns the corrupted pair, or None where the plan
gives it nothing to corrupt. `MUTATIONS` names them all with the kinds of problem that are the right reason for
rejecting them: the checker must name at least one of those. `PUSHES`, `FALLS`, `TOPPLES` and `STACKS` are more of them,
for plans that push something along the table, let something fall, push something over, or load and unload a plank.
"""

from __future__ import annotations

from tests.checking.mutations.editing import Mutation
from tests.checking.mutations.ends import (
    goal_missed,
    one_in_the_air_frees_another,
    other_home,
    stale_start,
    start_at_goals,
    start_in_the_air,
    start_in_the_robot,
)
from tests.checking.mutations.falls import (
    another_falls,
    fall_elsewhere,
    fall_into_the_air,
    fall_into_what_carries,
    fall_late,
    fall_up,
    fall_upside_down,
    never_fall,
)
from tests.checking.mutations.grips import (
    cut_between_pads,
    grasp_air,
    grasp_beside,
    keep_holding,
    never_grip,
    pries_open,
    slip_in_hand,
    spins_on_the_way,
    swings_down,
    swings_on_the_way,
    turned_flush,
    wrong_object,
    wrong_width,
)
from tests.checking.mutations.handling import (
    hangs_lower_than_said,
    met_where_it_was_let_go,
    rocks_over_its_foot,
    rocks_under_what_is_put_on_it,
    takes_a_board_over_the_rim,
)
from tests.checking.mutations.margins import (
    dropped_aside,
    hardly_open,
    home_on_the_way,
    pads_stay_off,
    start_a_little_aside,
    still_squeezed,
    too_heavy,
    too_heavy_for_the_arm,
    too_heavy_to_hurry,
    twist,
)
from tests.checking.mutations.motions import (
    beyond_joint_limit,
    closed_fingers,
    dip_between_samples,
    drag_what_is_narrow,
    drop_waypoints,
    hurry,
    jolt,
    meet_what_stays,
    not_at_rest,
    object_in_the_way,
    poke_what_rolls,
    rub,
    shift_into_table,
    shift_waypoint,
    speed_up,
    teleport,
)
from tests.checking.mutations.order import (
    drop_action,
    misnamed_phase,
    namesake,
    repeat_action,
    stop_early,
    swap_actions,
    unknown_action,
    wrong_argument,
)
from tests.checking.mutations.places import (
    creep,
    drop_from_height,
    forget_to_retreat,
    half_off_the_table,
    place_elsewhere,
    place_in_the_air,
    release_another,
)
from tests.checking.mutations.pushes import (
    push_beside,
    push_from_afar,
    push_hastily,
    push_loaded,
    push_nothing,
    push_over_the_edge,
    push_through,
    push_tips_backwards,
    push_what_is_heavy,
    push_what_rolls,
    push_what_slips,
    push_what_sticks,
)
from tests.checking.mutations.rounds import rolls_along_a_groove, rolls_off_half_a_rim
from tests.checking.mutations.solids import rocking_load, wedged_in
from tests.checking.mutations.stacks import (
    falls_the_other_way,
    falls_though_in_balance,
    heavy_load,
    light_counterweight,
    rolls_down_a_slope,
    rolls_off_what_is_light,
    stands_tilted,
    starts_beyond_the_rim,
    sunk_tower,
)
from tests.checking.mutations.topples import topple_halfway, topple_on_ice, topple_over_the_edge

__all__ = ["FALLS", "MUTATIONS", "PUSHES", "STACKS", "TOPPLES", "Mutation"]

MUTATIONS: dict[Mutation, tuple[str, ...]] = {
    swap_actions: ("continuity", "precondition"),
    drop_action: ("continuity", "precondition"),
    repeat_action: ("continuity", "precondition"),
    shift_into_table: ("collision",),
    object_in_the_way: ("collision",),
    speed_up: ("limits",),
    hurry: ("limits",),
    jolt: ("limits",),
    drop_waypoints: ("limits",),
    shift_waypoint: ("limits", "continuity"),
    beyond_joint_limit: ("limits",),
    not_at_rest: ("limits",),
    teleport: ("continuity",),
    grasp_beside: ("grasp",),
    grasp_air: ("grasp",),
    wrong_width: ("grasp",),
    wrong_object: ("grasp",),
    wrong_argument: ("precondition",),
    keep_holding: ("precondition", "continuity"),
    never_grip: ("continuity", "precondition"),
    slip_in_hand: ("continuity",),
    swings_down: ("grasp",),
    pries_open: ("grasp",),
    cut_between_pads: ("grasp",),
    turned_flush: ("collision",),
    place_in_the_air: ("support",),
    drop_from_height: ("release",),
    place_elsewhere: ("release",),
    half_off_the_table: ("support",),
    forget_to_retreat: ("release",),
    release_another: ("precondition",),
    stale_start: ("start",),
    start_in_the_air: ("start",),
    start_at_goals: ("start",),
    one_in_the_air_frees_another: ("start",),
    dip_between_samples: ("collision",),
    creep: ("release",),
    other_home: ("continuity", "start"),
    home_on_the_way: ("start",),
    start_a_little_aside: ("start",),
    dropped_aside: ("start",),
    pads_stay_off: ("grasp",),
    hardly_open: ("release",),
    still_squeezed: ("release",),
    twist: ("release",),
    too_heavy: ("grasp",),
    too_heavy_for_the_arm: ("limits",),
    too_heavy_to_hurry: ("grasp",),
    goal_missed: ("goal",),
    stop_early: ("goal",),
    closed_fingers: ("collision",),
    unknown_action: ("precondition",),
    namesake: ("precondition",),
    misnamed_phase: ("continuity",),
    sunk_tower: ("start",),
    stands_tilted: ("start",),
    starts_beyond_the_rim: ("start",),
    rolls_down_a_slope: ("start",),
    rolls_off_what_is_light: ("start",),
    rolls_along_a_groove: ("start",),
    rolls_off_half_a_rim: ("start",),
    falls_the_other_way: ("start",),
    falls_though_in_balance: ("start",),
    start_in_the_robot: ("start",),
    rocking_load: ("start",),
    wedged_in: ("collision",),
    rub: ("collision",),
    poke_what_rolls: ("collision",),
    drag_what_is_narrow: ("collision",),
    meet_what_stays: ("collision",),
    swings_on_the_way: ("grasp",),
    spins_on_the_way: ("grasp",),
    hangs_lower_than_said: ("collision",),
    met_where_it_was_let_go: ("collision",),
    rocks_over_its_foot: ("fall",),
    rocks_under_what_is_put_on_it: ("collision",),
    takes_a_board_over_the_rim: ("support",),
}

PUSHES: dict[Mutation, tuple[str, ...]] = {
    push_beside: ("grasp",),
    push_nothing: ("precondition",),
    push_from_afar: ("push",),
    push_through: ("collision",),
    push_loaded: ("precondition",),
    push_over_the_edge: ("support",),
    push_hastily: ("push",),
    push_what_sticks: ("push",),
    push_what_is_heavy: ("limits",),
    push_what_slips: ("push",),
    push_what_rolls: ("push",),
    push_tips_backwards: ("push",),
}

FALLS: dict[Mutation, tuple[str, ...]] = {
    fall_elsewhere: ("fall",),
    fall_into_the_air: ("support",),
    fall_into_what_carries: ("support", "fall"),
    fall_up: ("fall", "support"),
    fall_late: ("fall",),
    fall_upside_down: ("fall",),
    never_fall: ("precondition",),
    another_falls: ("fall", "precondition"),
}

TOPPLES: dict[Mutation, tuple[str, ...]] = {
    fall_late: ("fall",),
    push_beside: ("grasp",),
    push_nothing: ("precondition",),
    push_from_afar: ("push",),
    push_loaded: ("precondition",),
    topple_halfway: ("push",),
    topple_on_ice: ("push",),
    topple_over_the_edge: ("fall",),
}

STACKS: dict[Mutation, tuple[str, ...]] = {
    light_counterweight: ("precondition", "support"),
    heavy_load: ("start", "precondition", "support"),
}
