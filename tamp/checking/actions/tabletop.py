"""The rules of the tabletop domain, by the names of its actions."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from tamp.checking.actions.carrying import Pick, Place, Transport
from tamp.checking.actions.nudge import check_nudge
from tamp.checking.actions.push import check_push
from tamp.checking.actions.pushing import Push
from tamp.checking.actions.rule import ActionRule
from tamp.checking.actions.topple import check_topple

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
