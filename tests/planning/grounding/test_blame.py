"""What is concluded of the failures of some moves for others of their like."""

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from tamp.planning.grounding.blame import LIKE, Blame

FACTS = [("at", number) for number in range(4)]


@given(barred=st.lists(st.sampled_from(FACTS), max_size=30), passed=st.lists(st.sampled_from(FACTS), max_size=30))
def test_what_barred_often_and_more_often_than_not_bars_all(barred, passed):
    common = Blame(Counter(barred), len(barred), Counter(passed)).of_all()
    found = set() if common is None else set(common.facts)
    assert found == {fact for fact in FACTS if barred.count(fact) >= max(LIKE, passed.count(fact) + 1)}


def test_what_bars_all_does_not_depend_on_what_else_does():
    """A thing that was named in most failures hid another one that moves failed for whenever the first was gone."""
    first, second = FACTS[:2]
    common = Blame(Counter({first: 700, second: 300}), 1000).of_all()
    assert common is not None
    assert set(common.facts) == {first, second}
