"""The same robot in Drake and in MuJoCo: costs, poses and yaw accelerations side by side.

Usage: python bench/drake_engine.py --python /path/to/a/python/with/pydrake
                                    [--step 0.001] [--record tests/golden/drake.json]

Drake has wheels for fewer versions of Python than nfopidn: its robot (drake_robot.py) runs in an
interpreter of its own, the controller here. --record writes the figures to a file, with the version
of Drake that gave them.
"""

import argparse
import json
import subprocess
from pathlib import Path

import numpy as np
from nfopidn import Controller, Robot, Scenario, _core, score, simulate, to_rep103
from nfopidn.mujoco import Caster, build_model, run
from nfopidn.mujoco.machine import Machine

HERE = Path(__file__).parent
CASTERS = (0.17, -0.17)
WHEEL_MASS = 0.115
ARMATURE = 1e-4
WIDTH = 0.03
STIFFNESS = 5e5  # [N/m]; the wheels sink in by 0.06 mm
RELAXATION = 0.01  # [s]


class Drake:
    """A robot in Drake, in a process of its own."""

    def __init__(self, python, robot, wheels, step, start, sample_time):
        self.process = subprocess.Popen(
            [python, HERE / "drake_robot.py"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        told = {name: getattr(robot, name) for name in ("mass", "inertia")}
        told |= {name: getattr(robot, name) for name in ("track_width", "wheel_radius")}
        told |= {"wheels": wheels, "wheel_mass": WHEEL_MASS, "wheel_width": WIDTH}
        told |= {"armature": ARMATURE, "casters": CASTERS, "step": step, "start": list(start)}
        told |= {"stiffness": STIFFNESS, "relaxation": RELAXATION, "sample_time": sample_time}
        self.state = self._ask(told)

    def _ask(self, told):
        self.process.stdin.write(json.dumps(told) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def move(self, torque):
        """Hold torques of the paper's sign for a sample."""
        self.state = self._ask(list(to_rep103(torque)))

    def close(self):
        """End the process."""
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()


def start_of(scenario):
    """Give x, y, theta, v, omega at the start."""
    first = scenario.reference[0]
    pose = first[:3] if scenario.initial_pose is None else scenario.initial_pose
    return (*map(float, pose), 0.0, 0.0)


def run_drake(python, scenario, controller, wheels, step):
    """Run a scenario in Drake; gives a SimulationResult."""
    dt = scenario.trajectory.dt
    engine = Drake(python, scenario.robot, wheels, step, start_of(scenario), dt)
    law = controller.replace()
    law.start(scenario)
    states, torques = [], []
    for row in scenario.reference:
        states.append(engine.state)
        torques.append(law.step(engine.state, row))
        engine.move(torques[-1])
    engine.close()
    names = ("x", "y", "theta", "v", "omega")
    log = dict(zip(names, np.array(states).T, strict=True))
    log["t"] = scenario.trajectory.t
    log["tau_left"], log["tau_right"] = np.array(torques).T
    return score(log, scenario, controller=controller)


def yaw_acceleration(move, state, torque):
    """Give the mean yaw acceleration over 0.2 s from rest under torques against each other."""
    move((torque, -torque))
    return state()[4] / 0.2


def model(wheels):
    """Give the MuJoCo model of the same robot."""
    casters = [Caster(x) for x in CASTERS]
    return build_model(
        Robot.eddie(),
        wheels,
        wheel_mass=WHEEL_MASS,
        armature=ARMATURE,
        wheel_width=WIDTH,
        casters=casters,
        cone="elliptic",
    )


def compare(python, step):
    """Give the figures of both engines."""
    law = Controller.recommended()
    fast = Scenario.published(heading="continuous", period=50.0, rng=0)
    paths = {
        "P": Scenario.published(rng=0),
        "C": Scenario.published(heading="continuous", rng=0),
        "F": fast,
    }
    found = {"cost": {}, "pose_difference": {}, "yaw_acceleration": {}}
    for wheels in ("sphere", "cylinder"):
        for name, scenario in paths.items():
            drake = run_drake(python, scenario, law, wheels, step)
            mujoco = run(scenario, law, model=model(wheels), step=step)
            exact = simulate(scenario.replace(integrator="exact"), law)
            key = f"{wheels} {name}"
            found["cost"][key] = {
                "drake": drake.cost, "mujoco": mujoco.cost, "simulated": exact.cost
            }  # fmt: skip
            found["pose_difference"][key] = float(
                np.abs(drake.pose[:, :2] - mujoco.pose[:, :2]).max()
            )
        for torque in (0.1, 0.5):
            still = Scenario(fast.trajectory, initial_pose=(0, 0, 0), rng=0, divergence_distance=10)
            engine = Drake(python, Robot.eddie(), wheels, step, (0, 0, 0, 0, 0), 0.2)
            drake = yaw_acceleration(engine.move, lambda: engine.state, torque)  # noqa: B023
            engine.close()
            machine = Machine(model(wheels), step, "Euler", still)
            mujoco = yaw_acceleration(
                lambda pair: machine.move(pair, (0, 0), round(0.2 / step)),  # noqa: B023
                lambda: machine.state,  # noqa: B023
                torque,
            )
            found["yaw_acceleration"][f"{wheels} {torque:g} N m"] = {
                "drake": drake, "mujoco": mujoco
            }  # fmt: skip
    return found


def main():
    """Print the figures, and record them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", required=True, help="an interpreter that has pydrake")
    parser.add_argument("--step", type=float, default=0.001)
    parser.add_argument("--record", metavar="FILE")
    arguments = parser.parse_args()
    words = [arguments.python, "-c", "import importlib.metadata as m; print(m.version('drake'))"]
    version = subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    found = {"drake": version, "step": arguments.step}
    found |= compare(arguments.python, arguments.step)
    text = json.dumps(found, indent=1)
    print(text)
    if arguments.record:
        _core.write_file(arguments.record, (text + "\n").encode())


if __name__ == "__main__":
    main()
