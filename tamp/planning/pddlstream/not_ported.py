"""Names that scripts import from PDDLStream's modules and that are not there, each with what to do instead."""

from __future__ import annotations

_TRANSLATOR = "its translator is no part of this planner: give solve_from_pddl the texts of domain and problem"
_VALUES = "nothing is converted: facts, plans and evaluations hold the values themselves, as tuples"
_KEPT = "nothing is kept that it could show: print_solution, solution.report and solution.certified say what came of it"
_ONE = "one plan is returned, not several to choose from"
_TIMED = "actions have no durations here: write an (:action ...) with a cost"
_PARTS = 'give solve the goal And(*parts), and strategy="serialized" to reach one part after the other'
_PYTHON = "it has nothing to do with planning: Python's own libraries do the same"

NOT_PORTED = {
    name: why
    for why, names in {
        _TRANSLATOR: "TEMP_DIR apply_action get_action_instances get_conjunctive_parts get_fluents get_problem"
        " is_assignment is_literal make_predicate parse_sequential_domain plan_preimage sas_from_pddl solve_from_task"
        " task_from_domain_problem",
        _VALUES: "Atom Evaluation Head Object OptimisticObject evaluation_from_fact evaluation_from_fd"
        " evaluations_from_init fact_from_evaluation fact_from_fd obj_from_value_expression transform_plan_args"
        " value_from_evaluation value_from_obj_expression",
        _KEPT: "analyze_goal check_solution dump_plan examine_instantiated",
        "solution.report.streams has calls, outputs and times of each stream": "dump_total_statistics load_data"
        " load_stream_statistics write_stream_statistics",
        "nothing is left out at first: solve plans with the whole domain": "solve_hierarchical",
        _ONE: "diverse_subset p_conjunction p_disjunction",
        _TIMED: "SimplifiedDomain TemporalDomain solve_tfd",
        _PARTS: "solve_all_goals solve_first_goal solve_next_goal",
        _PYTHON: "Verbose get_python_version read_json read_pickle topological_sort write_json write_pickle",
    }.items()
    for name in names.split()
}
"""Name -> why it is not there and what to do instead."""
