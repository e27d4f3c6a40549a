"""A damaged checkpoint is found out, whatever the damage; the state before takes its place."""

import json
import random
import shutil

import nfopidn
import nominal
import pytest
from checkpoints import crc64
from nfopidn import _core
from refusal import refused
from results import same

BOX = [(-2.0, 3.0), (0.0, 1.0)]


def bowl(x):
    return float(((x - 0.25) ** 2).sum())


def search(path, **arguments):
    return nfopidn.bfoa(bowl, BOX, **({"rng": 1, "maxfev": 600, "checkpoint": path} | arguments))


def tuning(path, **arguments):
    return nominal.tune(**({"rng": 1, "maxfev": 600, "checkpoint": path} | arguments))


def stop_at(step):
    calls = []

    def callback(result):
        calls.append(result)
        if len(calls) == step:
            raise StopIteration

    return callback


@pytest.fixture(params=[search, tuning])
def run(request):
    return request.param


@pytest.fixture
def path(tmp_path):
    return tmp_path / "search.checkpoint"


def before(path):
    return path.with_name(path.name + ".previous")


def damages(content, draw):
    """Give damages of each kind, at random places and at both ends."""
    size = len(content)
    places = [
        0,
        size // 2,
        size - 25,
        size - 2,
        size - 1,
        *(draw.randrange(size) for _ in range(25)),
    ]
    for place in places:
        span = draw.choice([1, 1, 2, 9, 100])
        bit = bytes([content[place] ^ (1 << draw.randrange(8))])
        yield content[:place] + bit + content[place + 1 :]
        digit = b"7" if content[place : place + 1] != b"7" else b"3"
        yield content[:place] + digit + content[place + 1 :]
        yield content[:place] + content[place + span :]  # removed
        yield content[:place]  # truncated
        piece = content[place : place + span]
        yield content[:place] + piece + piece + content[place + span :]  # duplicated
        yield content[:place] + b"\0" * len(piece) + content[place + span :]  # never written
    yield content + content
    yield content + b"\n"
    yield b" " + content
    yield content.replace(b'"crc64"', b'"crc65"')


def test_every_single_damage_is_found_out(run, path):
    run(path, maxfev=200)
    content = path.read_bytes()
    count = 0
    for damaged in damages(content, random.Random(1)):
        if damaged == content:
            continue
        count += 1
        path.write_bytes(damaged)
        assert _core.checkpoint_problem(str(path)) is None
        if count % 8 == 0 or len(damaged) < 2:
            with refused("checkpoint", str(path)):
                run(path, maxfev=200)
            assert path.read_bytes() == damaged
    assert count > 150


def test_the_file_is_a_document_with_the_digest_of_what_stands_before(run, path):
    run(path, maxfev=200)
    content = path.read_bytes()
    before, digest = content[:-29], content[-29:]
    assert digest == b',"crc64":"%016x"}\n' % crc64(before)
    assert json.loads(content)["format"] == "nfopidn-checkpoint"


def test_the_state_before_takes_the_place_of_a_damaged_one(run, path):
    run(path, callback=stop_at(2))
    assert not before(path).exists()
    first = path.read_bytes()
    later = run(path, callback=stop_at(5))
    assert before(path).read_bytes() == first
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.warns(RuntimeWarning, match="is damaged; the search goes on from the state before"):
        result = run(path)
    assert result.nfev > later.nfev
    same(result, run(None))
    # What was damaged has not taken the place of the good one; the new one is whole.
    assert before(path).read_bytes() == first
    assert len(json.loads(path.read_text())["record"]) > len(json.loads(first)["record"])
    same(run(path), result)


def test_the_seed_is_that_of_the_state_before(run, path):
    run(path, rng=7, callback=stop_at(2))
    run(path, rng=7, callback=stop_at(5))
    path.write_bytes(b"nothing")
    with pytest.warns(RuntimeWarning, match="is damaged"):
        result = run(path, rng=None)
    same(result, run(None, rng=7))


@pytest.mark.parametrize("other", ["missing", "damaged", "of another search"])
def test_a_damaged_one_is_refused_where_nothing_takes_its_place(other, run, path, tmp_path):
    run(path, callback=stop_at(2))
    run(path, callback=stop_at(5))
    if other == "missing":
        before(path).unlink()
    elif other == "damaged":
        before(path).write_bytes(before(path).read_bytes()[1:])
    else:
        run(tmp_path / "other", rng=2)
        shutil.copy(tmp_path / "other", before(path))
    content = path.read_bytes()[:-1]
    path.write_bytes(content)
    with refused("checkpoint", str(path), "is damaged, or no checkpoint of this version"):
        run(path)
    assert path.read_bytes() == content


def test_what_lies_beside_a_search_that_begins_is_not_its_own(run, path):
    run(path, callback=stop_at(2))
    run(path, callback=stop_at(5))
    path.unlink()
    same(run(path), run(None))
    assert not before(path).exists()


def test_a_link_s_states_lie_beside_what_it_leads_to(run, path, tmp_path):
    (tmp_path / "there").mkdir()
    run(tmp_path / "there" / "search", callback=stop_at(2))
    path.symlink_to(tmp_path / "there" / "search")
    run(path, callback=stop_at(5))
    names = {file.name for file in (tmp_path / "there").iterdir()}
    assert names == {"search", "search.previous"}
    (tmp_path / "there" / "search").write_bytes(b"nothing")
    with pytest.warns(RuntimeWarning, match="is damaged"):
        same(run(path), run(None))
