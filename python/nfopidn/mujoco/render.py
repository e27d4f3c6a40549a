"""Pictures of a run, made without a screen."""

from __future__ import annotations

import ctypes.util
import io
import math
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import SimulationResult
from nfopidn.arguments import real_number, whole_number
from nfopidn.files import replace_file
from nfopidn.mujoco.engine import load, quiet_warnings
from nfopidn.mujoco.model import Model, build_model

Frames = NDArray[np.uint8]

_SUFFIXES = (".gif", ".mp4")
_MOST_FRAMES = 5000
_TRACK_COLOUR = (0.05, 0.3, 0.75, 1.0)
_REFERENCE_COLOUR = (0.5, 0.5, 0.5, 1.0)


class NoRendererError(RuntimeError):
    """Nothing on this machine renders without a screen."""


def render(
    result: SimulationResult,
    target: str | PathLike[str] | None = None,
    *,
    model: Model | None = None,
    frames_a_second: float = 20.0,
    speed: float = 5.0,
    width: int = 480,
    height: int = 360,
) -> Frames:
    """Play a run back and write it as a GIF or a film.

    The robot is set to the recorded pose of each frame, its wheels turned as far as they rolled:
    what is seen is the recorded run, not a second one. The reference is the grey line, the way so
    far the blue one.

    Parameters
    ----------
    result
        Of `run`, of `nfopidn.simulate` or of `nfopidn.score`.
    target
        A name that ends in .gif or .mp4; None: nothing is written. Films need the program ffmpeg.
    model
        What is shown; None: `build_model` of the scenario's robot.
    frames_a_second
        Of the film, in [1, 100].
    speed
        Seconds of the run in a second of the film, in [0.01, 1000].
    width, height
        Of a frame [pixels], in [16, 2000].

    Returns
    -------
    ndarray
        (n, height, width, 3) of bytes: the frames.

    Raises
    ------
    ImportError
        MuJoCo is not installed.
    NoRendererError
        Neither EGL nor OSMesa is there, or PyOpenGL is missing; nothing is written.
    ValueError
        An argument out of its range, over 5000 frames, or no ffmpeg for a film.
    """
    if not isinstance(result, SimulationResult):
        raise ValueError(f"result is {result!r}; must be a SimulationResult")
    suffix = _suffix(target)
    real_number("frames_a_second", frames_a_second, 1.0, 100.0)
    real_number("speed", speed, 0.01, 1000.0)
    whole_number("width", width, 16, 2000)
    whole_number("height", height, 16, 2000)
    if len(result) < 2:
        raise ValueError(f"result has {len(result)} samples; needs 2 at least")
    times = np.arange(result.t[0], result.t[-1], speed / frames_a_second)
    if len(times) > _MOST_FRAMES:
        raise ValueError(
            f"{len(times)} frames at speed {speed:g}; at most {_MOST_FRAMES}: a larger speed"
        )
    shown = build_model(result.scenario.robot) if model is None else model
    frames = _frames(result, shown, times, width, height)
    if suffix == ".gif":
        replace_file(fspath(target or ""), _gif(frames, frames_a_second))
    elif suffix == ".mp4":
        replace_file(fspath(target or ""), _film(frames, frames_a_second))
    return frames


def _suffix(target: str | PathLike[str] | None) -> str:
    """Check the name of the file, before any work."""
    if target is None:
        return ""
    name = fspath(target)
    suffix = Path(name).suffix.lower()
    if suffix not in _SUFFIXES:
        raise ValueError(f"{name}: must end in one of {', '.join(_SUFFIXES)}")
    try:
        _core.check_writable(name)
    except OSError as error:
        raise ValueError(f"{name}: cannot be written: {error.strerror}") from None
    if suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise ValueError(f"{name}: a film needs the program ffmpeg; a GIF does not")
    return suffix


def _frames(result: SimulationResult, model: Model, times: Any, width: int, height: int) -> Frames:
    """Render the run at the times [s]."""
    mujoco = load()
    spec = model.spec.copy()
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.headlight.diffuse = [0.35, 0.35, 0.35]
    spec.visual.headlight.specular = [0, 0, 0]
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=[0, 0, 8],
        dir=[0.3, 0.4, -1],
        diffuse=[0.3, 0.3, 0.3],
        castshadow=False,
        specular=[0, 0, 0],
    )
    _draw_body(mujoco, spec, model)
    poses = np.column_stack([np.interp(times, result.t, column) for column in result.pose.T])
    angles = _wheel_angles(result, times)
    with quiet_warnings(), _context(width, height):
        compiled = spec.compile()
        data = mujoco.MjData(compiled)
        stage = _Stage(mujoco, compiled, result, width, height)
        place = int(compiled.jnt(int(compiled.body(model.body).jntadr[0])).qposadr[0])
        wheels = [int(compiled.joint(name).qposadr[0]) for name in (model.left, model.right)]
        frames = np.zeros((len(times), height, width, 3), dtype=np.uint8)
        for number, (x, y, theta) in enumerate(poses):
            half = theta / 2
            data.qpos[place : place + 7] = [
                x, y, model.height, math.cos(half), 0, 0, math.sin(half),
            ]  # fmt: skip
            data.qpos[wheels] = angles[number]
            mujoco.mj_forward(compiled, data)
            frames[number] = stage.shoot(data, poses[: number + 1])
    return frames


def _wheel_angles(result: SimulationResult, times: Any) -> Any:
    """Give how far the wheels of REP-103 have turned at the times [rad], (n, 2)."""
    robot = result.scenario.robot
    columns = result.columns
    turn = columns["omega"] * robot.track_width / 2
    dt = result.scenario.trajectory.dt
    angles = []
    for sign in (-1.0, 1.0):
        rate = (columns["v"] + sign * turn) / robot.wheel_radius
        angles.append(np.interp(times, result.t, np.cumsum(rate) * dt))
    return np.column_stack(angles)


def _draw_body(mujoco: Any, spec: Any, model: Model) -> None:
    """Give the robot's body a shape for the eye, and a mark on each wheel."""
    if model.wheels == "urdf":
        return
    robot = model.robot
    half, radius = robot.track_width / 2, robot.wheel_radius
    body = spec.body(model.body)
    for size, pos, colour in (
        ([0.85 * half, 0.35 * radius, 0], [0, 0, 0.9 * radius], [0.95, 0.6, 0.15, 1]),
        ([0.1 * half, 0.5 * radius, 0], [0.6 * half, 0, 1.2 * radius], [0.15, 0.15, 0.15, 1]),
    ):
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=size,
            pos=pos,
            rgba=colour,
            mass=0,
            contype=0,
            conaffinity=0,
        )
    for name in (model.left, model.right):
        wheel = spec.joint(name).parent
        for geom in wheel.geoms:
            geom.rgba = [0.2, 0.2, 0.22, 1]
        wheel.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[0.8 * radius, 0.02, 0.1 * radius],
            rgba=[0.9, 0.9, 0.9, 1],
            mass=0,
            contype=0,
            conaffinity=0,
        )


class _Stage:
    """A camera above the whole path."""

    def __init__(
        self, mujoco: Any, model: Any, result: SimulationResult, width: int, height: int
    ) -> None:
        self.mujoco = mujoco
        self.model = model
        self.scene = mujoco.MjvScene(model=model, maxgeom=4000)
        self.option = mujoco.MjvOption()
        self.target = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self.target)
        self.rectangle = mujoco.MjrRect(0, 0, width, height)
        self.picture = np.zeros((height, width, 3), dtype=np.uint8)
        self.reference = _thinned(result.scenario.reference[:, :2])
        points = np.vstack([self.reference, _thinned(result.pose[:, :2])])
        low, high = points.min(axis=0), points.max(axis=0)
        self.camera = mujoco.MjvCamera()
        self.camera.lookat = [*((low + high) / 2), 0.0]
        self.camera.distance = 1.5 * max(0.5, float((high - low).max()))
        self.camera.elevation, self.camera.azimuth = -55.0, 100.0

    def shoot(self, data: Any, way: Any) -> Frames:
        """Make one frame; `way` are the poses so far."""
        mujoco = self.mujoco
        category = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(
            self.model, data, self.option, None, self.camera, category, self.scene
        )
        self._line(self.reference, _REFERENCE_COLOUR, 0.004)
        self._line(_thinned(way[:, :2]), _TRACK_COLOUR, 0.006)
        mujoco.mjr_render(self.rectangle, self.scene, self.target)
        mujoco.mjr_readPixels(self.picture, None, self.rectangle, self.target)
        return self.picture[::-1]

    def _line(self, points: Any, colour: tuple[float, ...], height: float) -> None:
        """Draw a line on the floor."""
        mujoco = self.mujoco
        width = self.camera.distance / 400
        for start, end in pairwise(points):
            if self.scene.ngeom >= self.scene.maxgeom:
                return
            geom = self.scene.geoms[self.scene.ngeom]
            kind = mujoco.mjtGeom.mjGEOM_CAPSULE
            mujoco.mjv_initGeom(
                geom, kind, np.zeros(3), np.zeros(3), np.zeros(9), np.array(colour, np.float32)
            )
            mujoco.mjv_connector(geom, kind, width, [*start, height], [*end, height])
            self.scene.ngeom += 1


def _thinned(points: Any) -> Any:
    """Give at most some hundreds of the points, the last one among them."""
    step = max(1, len(points) // 400)
    return np.vstack([points[::step], points[-1:]])


@contextmanager
def _context(width: int, height: int) -> Iterator[None]:
    """Have an offscreen OpenGL context for a while.

    Raises
    ------
    NoRendererError
        Says what is missing.
    """
    load()
    asked = os.environ.get("MUJOCO_GL", "").strip().lower()
    found = {"egl": ctypes.util.find_library("EGL"), "osmesa": ctypes.util.find_library("OSMesa")}
    names = [asked] if asked in found else [name for name, library in found.items() if library]
    if not names:
        raise NoRendererError(
            "nothing renders here without a screen: neither EGL nor OSMesa is found; on Debian "
            "apt-get install libegl1 or libosmesa6"
        )
    try:
        context = _make_context(names[0], width, height)
    except ImportError as error:
        raise NoRendererError(
            f"{names[0]} renders through PyOpenGL, which does not load ({error}): "
            'pip install "mujoco-core[rendering]"'
        ) from None
    except Exception as error:  # OpenGL has exceptions of its own
        raise NoRendererError(
            f"{names[0]} gives no context to render in ({error}); MUJOCO_GL=egl or "
            "MUJOCO_GL=osmesa chooses another"
        ) from None
    try:
        context.make_current()
        yield
    finally:
        context.free()


def _make_context(name: str, width: int, height: int) -> Any:
    """Make a context of EGL or OSMesa."""
    if name == "egl":
        from mujoco.egl import GLContext
    else:
        from mujoco.osmesa import GLContext
    return GLContext(width, height)


def _gif(frames: Frames, frames_a_second: float) -> bytes:
    """Give a GIF of one palette."""
    from PIL import Image

    pictures = [Image.fromarray(frame) for frame in frames]
    palette = pictures[len(pictures) // 2].quantize(64)
    pictures = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    content = io.BytesIO()
    pictures[0].save(
        content,
        format="GIF",
        save_all=True,
        append_images=pictures[1:],
        duration=round(1000 / frames_a_second),
        loop=0,
    )
    return content.getvalue()


def _film(frames: Frames, frames_a_second: float) -> bytes:
    """Give a film, made by ffmpeg.

    Raises
    ------
    ValueError
        ffmpeg makes none; with its last words.
    """
    count, height, width, _ = frames.shape
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mp4"
        words = ["ffmpeg", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
        words += ["-s", f"{width}x{height}", "-r", f"{frames_a_second:g}", "-i", "-"]
        words += ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", str(path)]
        done = subprocess.run(words, input=frames.tobytes(), capture_output=True, check=False)
        if done.returncode or not path.is_file():
            told = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
            raise ValueError(f"ffmpeg makes no film of {count} frames: {' '.join(told)}")
        return path.read_bytes()
