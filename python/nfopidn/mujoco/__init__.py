"""Robots in MuJoCo: the same scenario and the same controller, another engine.

It needs the package mujoco-core, version 4: `pip install "nfopidn[physics]"`.
"""

from nfopidn.mujoco.model import Model, build_model
from nfopidn.mujoco.parts import Bump, Caster
from nfopidn.mujoco.render import NoRendererError, render
from nfopidn.mujoco.run import run

__all__ = ["Bump", "Caster", "Model", "NoRendererError", "build_model", "render", "run"]
