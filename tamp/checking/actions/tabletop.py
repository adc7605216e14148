"""The rules of the tabletop domain, by the names of its actions."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from tamp.checking.actions.carrying import Pick, Place, Transport
from tamp.checking.actions.pushes.nudge import check_nudge
from tamp.checking.actions.pushes.push import check_push
from tamp.checking.actions.pushes.pushing import Push
from tamp.checking.actions.pushes.topple import check_topple
from tamp.checking.actions.rule import ActionRule

TABLETOP: Mapping[str, ActionRule] = MappingProxyType(
    {
        "move": Transport(),
        "pick": Pick(from_table=True),
        "unstack": Pick(from_table=False),
        "place": Place(on_table=True),
        "stack": Place(on_table=False),
        "lay": Place(on_table=True, falls=True),
        "lay-on": Place(on_table=False, falls=True),
        "slide": Push(check_push),
        "topple": Push(check_topple, falls=True),
        "nudge": Push(check_nudge),
    }
)
