"""What both judges must say of a corrupted plan."""

import pytest

from tamp.checking import check
from tamp.task import Plan, Task


def assert_wrong_and_rejected(mutant, kinds):
    """The oracle calls it wrong, and the checker rejects it for at least one of the right reasons."""
    pytest.importorskip("pinocchio")
    from tests.checking.oracle import wrong

    assert wrong(*mutant) is not None
    assert {problem.kind for problem in check(*mutant).problems} & set(kinds)


def kinds(task: Task, plan: Plan) -> set[str]:
    """The kinds of all that the checker finds wrong."""
    return {problem.kind for problem in check(task, plan).problems}
