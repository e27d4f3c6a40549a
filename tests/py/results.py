"""What tests of searches share."""

from numpy.testing import assert_array_equal


def same(one, other):
    """Assert that two results are equal to the last bit, but for the time they took."""
    assert set(one) == set(other)
    for key in set(one) - {"elapsed"}:
        if key in ("controller", "scenario"):
            assert one[key] == other[key]
        else:
            assert_array_equal(one[key], other[key], err_msg=key)


def watcher(seen):
    """A callback that keeps what it is given."""

    def watch(result):
        seen.append(result)

    return watch
