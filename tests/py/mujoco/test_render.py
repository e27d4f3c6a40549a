"""Animations, where something renders; a clear word where nothing does."""

import ctypes.util
import os
import sys

import numpy as np
import pytest
from nfopidn import Controller, Scenario, simulate
from nfopidn.mujoco import NoRendererError, render
from PIL import Image

SHORT = Scenario.published(heading="continuous", period=50.0, rng=0)
SMALL = {"width": 96, "height": 64, "speed": 100.0, "frames_a_second": 10.0}


@pytest.fixture(scope="module")
def result():
    return simulate(SHORT, Controller.recommended())


@pytest.fixture(scope="module")
def frames(result):
    try:
        return render(result, **SMALL)
    except NoRendererError as error:
        pytest.skip(str(error))


def test_frames_show_a_robot_that_moves(frames):
    assert frames.shape == (5, 64, 96, 3)
    assert frames.dtype == np.uint8
    assert len({frame.tobytes() for frame in frames}) == 5
    assert frames.std() > 5


def test_a_gif_is_written(result, frames, tmp_path):
    path = tmp_path / "run.gif"
    again = render(result, path, **SMALL)
    np.testing.assert_array_equal(again, frames)
    with Image.open(path) as picture:
        assert (picture.n_frames, picture.size) == (5, (96, 64))
        assert picture.info["duration"] == 100
    assert os.listdir(tmp_path) == ["run.gif"]


def test_no_renderer_is_told_and_nothing_is_written(result, tmp_path, monkeypatch):
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: None)
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    with pytest.raises(NoRendererError, match="neither EGL nor OSMesa is found"):
        render(result, tmp_path / "run.gif", **SMALL)
    assert os.listdir(tmp_path) == []


def test_a_library_that_gives_no_context_is_told(result, tmp_path, monkeypatch):
    module = sys.modules["nfopidn.mujoco.render"]

    def broken(*_words):
        raise OSError("no display")

    monkeypatch.setattr(module, "_make_context", broken)
    monkeypatch.setenv("MUJOCO_GL", "egl")
    with pytest.raises(NoRendererError, match=r"egl gives no context to render in \(no display\)"):
        render(result, tmp_path / "run.gif", **SMALL)

    def missing(*_words):
        raise ImportError("No module named 'OpenGL'")

    monkeypatch.setattr(module, "_make_context", missing)
    with pytest.raises(NoRendererError, match=r'pip install "mujoco-core\[rendering\]"'):
        render(result, tmp_path / "run.gif", **SMALL)
    assert os.listdir(tmp_path) == []


def test_a_film_without_ffmpeg_is_refused_before_any_work(result, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ValueError, match="needs the program ffmpeg"):
        render(result, tmp_path / "run.mp4", **SMALL)


def test_what_ffmpeg_says_is_told(result, frames, tmp_path, monkeypatch):
    """With a program of that name that fails, and one that writes its last argument."""
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\n/bin/cat > /dev/null\necho bad film >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ValueError, match="no film of 5 frames: bad film"):
        render(result, tmp_path / "run.mp4", **SMALL)
    assert os.listdir(tmp_path) == ["ffmpeg"]
    program.write_text('#!/bin/sh\nfor last; do :; done\n/bin/cat > "$last"\n')
    render(result, tmp_path / "run.mp4", **SMALL)
    assert (tmp_path / "run.mp4").read_bytes() == frames.tobytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"target": "run.avi"}, r"run.avi: must end in one of .gif, .mp4"),
        ({"target": "nowhere/run.gif"}, "nowhere/run.gif: cannot be written"),
        ({"speed": 0.0}, "speed is 0.0"),
        ({"frames_a_second": 1000}, "frames_a_second is 1000"),
        ({"width": 4}, "width is 4"),
        ({"height": 1e9}, "height is 1000000000.0"),
        ({"speed": 0.01}, "100000 frames at speed 0.01; at most 5000"),
    ],
)
def test_bad_arguments_are_refused(result, arguments, message, monkeypatch):
    with pytest.raises(ValueError, match=message):
        render(result, **arguments)


def test_no_run_no_film():
    with pytest.raises(ValueError, match="result is None"):
        render(None)
