"""The worst pictures are the same ones in whatever order the workers finish."""

from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.metrics import Kept, QualityResult, WorstKeeper


def kept(key: int, flip: float) -> Kept:
    return Kept(key, None, QualityResult({"flip": flip}))


flips = st.lists(st.sampled_from([0.0, 0.1, 0.2, 0.3, 0.5, 0.9]), max_size=30)


@given(flips, st.integers(0, 5), st.integers(1, 7), st.randoms())
def test_any_order_keeps_the_same(values, count, per_bucket, random):
    offered = [kept(key, flip) for key, flip in enumerate(values)]
    keeper = WorstKeeper(count, lambda key: key // per_bucket)
    random.shuffle(offered)
    for item in offered:
        keeper.offer(item)
    # By sorting everything at once: the worst of each bucket, then the worst of those.
    best = {}
    for item in sorted(offered, key=lambda k: k.rank):
        best[item.key // per_bucket] = item
    expected = sorted(best.values(), key=lambda k: k.rank, reverse=True)[:count]
    assert [k.key for k in keeper.kept()] == [k.key for k in expected]
