from tamp.planning import Report, SkeletonReport, StreamReport, combined


def report(total_s, *streams, counts=None, skeletons=()):
    return Report("adaptive", "failed", 1.0, total_s, {"search": total_s / 2}, streams, skeletons, counts or {}, "no")


def test_runs_are_added_stream_by_stream():
    grasps = StreamReport("sample-grasp", 3, 1, 0.5, (("too wide", 2),))
    more = StreamReport("sample-grasp", 4, 0, 1.5, (("no room", 3), ("too wide", 1)))
    places = StreamReport("sample-placement", 1, 1, 0.25)
    skeleton = SkeletonReport(("pick",), 1, False)
    runs = [
        report(2.0, grasps, counts={"iterations": 2, "operators": 10}),
        report(3.0, more, places, counts={"iterations": 1, "operators": 7}, skeletons=(skeleton,)),
    ]
    whole = combined(runs, "solved")
    assert whole.status == "solved"
    assert whole.total_s == 5.0
    assert whole.seconds == {"search": 2.5}
    assert whole.counts == {"iterations": 3, "operators": 7}
    assert whole.skeletons == (skeleton,)
    # Equally frequent failures keep the order in which they first came.
    assert whole.streams == (
        StreamReport("sample-grasp", 7, 1, 2.0, (("too wide", 3), ("no room", 3))),
        places,
    )


def test_one_run_is_itself():
    one = report(1.0, StreamReport("sample-grasp", 1, 1, 0.1), counts={"iterations": 1, "operators": 5})
    assert combined([one], "failed") == one
