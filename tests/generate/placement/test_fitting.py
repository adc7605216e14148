from tamp.generate.placement.fitting import fits
from tamp.generate.placement.object_model import thing
from tamp.scenarios.library.model import read_library

THINGS = {model.kind: thing(model) for model in read_library() if model.set == "trial"}


def test_what_does_not_fit_is_not_put_together():
    assert not fits("in", THINGS["plate"], THINGS["bowl"])
    assert not fits("on", THINGS["basket"], THINGS["can"])
    assert not fits("on", THINGS["apple"], THINGS["roof"])
    assert not fits("leaning", THINGS["apple"], THINGS["carton"])
    assert not fits("standing", THINGS["apple"], THINGS["penholder"])
