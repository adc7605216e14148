import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.domains.samplers import load_sampler, resolve_samplers
from tamp.domains.tabletop import DOMAIN
from tamp.errors import SamplerError

NAMES = ("sample-grasp", "sample-placement", "plan-motion")


def sampler(text):
    def function(context):
        return text

    return function


def layer_of(text, names):
    return {name: sampler(text) for name in names}


subsets = st.sets(st.sampled_from(NAMES))


@given(layers=st.lists(subsets, max_size=4))
def test_the_nearest_layer_that_names_a_stream_serves_it(layers):
    resolved = resolve_samplers(
        layer_of("default", NAMES), *(layer_of(str(i), sorted(names)) for i, names in enumerate(layers))
    )
    assert set(resolved) == set(NAMES)
    for name in NAMES:
        naming = [str(i) for i, names in enumerate(layers) if name in names]
        assert resolved[name](None) == (naming[-1] if naming else "default")


def test_addresses_and_functions_may_be_mixed():
    mine = sampler("mine")
    resolved = resolve_samplers({"a": "math:sin", "b": "math:cos"}, {"b": "math:tan"}, {"a": mine})
    assert resolved == {"a": mine, "b": math.tan}


def test_the_layers_are_left_as_they_are():
    default, mine = layer_of("default", NAMES), {"sample-grasp": "math:sin"}
    before = dict(default)
    resolve_samplers(default, mine)
    assert default == before
    assert mine == {"sample-grasp": "math:sin"}


def test_an_unknown_stream_is_refused_with_the_names_that_there_are():
    with pytest.raises(SamplerError) as refused:
        resolve_samplers(layer_of("default", NAMES), {"sample-grasps": "math:sin"})
    message = str(refused.value)
    assert "no stream 'sample-grasps'" in message
    assert "did you mean 'sample-grasp'?" in message
    assert "plan-motion, sample-grasp, sample-placement" in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("address", "complaint"),
    [
        ("math", "not of the form package.module:function"),
        (":sin", "not of the form package.module:function"),
        ("math:", "not of the form package.module:function"),
        ("", "not of the form package.module:function"),
        (".math:sin", "not of the form package.module:function"),
        ("math..sin:sin", "not of the form package.module:function"),
        ("nowhere_at_all:sin", "there is no module 'nowhere_at_all'"),
        ("math.nowhere:sin", "there is no module 'math.nowhere'"),
        ("math:sine", "math has no function 'sine'; did you mean 'sin'?"),
        ("math:pi", "math has no function 'pi'"),
    ],
)
def test_a_bad_address_is_refused_in_one_sentence_that_names_its_stream(address, complaint):
    with pytest.raises(SamplerError) as refused:
        load_sampler(address, "sample-grasp")
    message = str(refused.value)
    assert message.startswith("sampler for sample-grasp: ")
    assert complaint in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("import something_that_is_absent", "ModuleNotFoundError: No module named 'something_that_is_absent'"),
        ("int('three')", "ValueError: invalid literal for int() with base 10: 'three'"),
        ("def grasps(:", "SyntaxError: invalid syntax"),
        ("raise SystemExit(0)", "SystemExit: 0"),
    ],
)
def test_what_fails_inside_the_users_module_is_said_with_its_line(line, complaint, tmp_path, monkeypatch):
    name = f"fails_{len(line)}"
    (tmp_path / f"{name}.py").write_text(f"\n{line}\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(SamplerError) as refused:
        load_sampler(f"{name}:grasps", "sample-grasp")
    where = tmp_path / f"{name}.py"
    assert str(refused.value) == f"sampler for sample-grasp: {name!r} cannot be imported: {complaint} at {where}:2"


def test_every_stream_of_the_tabletop_has_a_sampler_that_loads():
    names = {s.name for s in DOMAIN.stream_file.streams}
    assert set(DOMAIN.samplers) == names
    assert all(callable(function) for function in resolve_samplers(DOMAIN.samplers).values())


def test_what_is_no_function_is_refused_and_not_offered_as_what_was_meant(monkeypatch):
    monkeypatch.setattr(math, "GRASPS", 5, raising=False)
    with pytest.raises(SamplerError, match=r"math has no function 'GRASPS'$"):
        load_sampler("math:GRASPS", "sample-grasp")
    with pytest.raises(SamplerError, match=r"^sampler for sample-grasp: None is no function; valid are a function and"):
        resolve_samplers({"sample-grasp": "math:sin"}, {"sample-grasp": None})
