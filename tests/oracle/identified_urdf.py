#!/usr/bin/env python3
"""Does a URDF written by `bipedc identify --write-urdf` mean the same to Pinocchio, MuJoCo and bipedc?

    python3 -m venv VENV && VENV/bin/pip install pin==4.1.0 mujoco numpy
    bipedc identify robots/tulip_v1_leg train.csv --method elastic --write-urdf new/robot.urdf
    cp robots/tulip_v1_leg/biped.toml new/
    VENV/bin/python identified_urdf.py new --program target/release/bipedc [--against robots/tulip_v1_leg/robot.urdf]

Joint torques at random states with the base held: those of `bipedc evaluate`, of Pinocchio's recursive Newton-Euler and of
MuJoCo's inverse dynamics (contacts, damping and friction off). Exit code 1 where they differ by more than 1e-9 of the
largest torque of Pinocchio's, or MuJoCo's by more than 1e-6 (it brings inertias into principal axes as it compiles). With
`--against` also how far the torques of another URDF are away.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

import mujoco
import numpy as np
import pinocchio as pin

STATES = 40


def pinocchio_torques(urdf, states):
    model = pin.buildModelFromUrdf(urdf)
    data = model.createData()
    names = list(model.names)[1:]
    if any(model.joints[k + 1].nq != 1 for k in range(len(names))):
        sys.exit(f"{urdf}: joints with one coordinate each are expected (no continuous joints)")
    pick = lambda state, key: np.array([state[key][n] for n in names])
    rows = [pin.rnea(model, data, pick(s, "position"), pick(s, "velocity"), pick(s, "acceleration")) for s in states]
    return names, np.array(rows)


def mujoco_torques(urdf, states, names):
    model = mujoco.MjModel.from_xml_path(urdf)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_damping[:] = 0
    model.dof_frictionloss[:] = 0
    model.dof_armature[:] = 0
    model.opt.gravity[:] = [0, 0, -9.81]
    data = mujoco.MjData(model)
    joints = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, n) for n in names]
    out = []
    for state in states:
        for n, j in zip(names, joints):
            data.qpos[model.jnt_qposadr[j]] = state["position"][n]
            data.qvel[model.jnt_dofadr[j]] = state["velocity"][n]
            data.qacc[model.jnt_dofadr[j]] = state["acceleration"][n]
        mujoco.mj_inverse(model, data)
        out.append([data.qfrc_inverse[model.jnt_dofadr[j]] for j in joints])
    return np.array(out)


def bipedc_torques(program, robot, states, names):
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "states.json")
        with open(file, "w") as out:
            json.dump(states, out)
        command = [program, "evaluate", robot, "inverse_dynamics", "--base", "fixed", "--states", file, "--json"]
        answer = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    order = [answer["rows"].index(n) for n in names]
    return np.array(answer["values"])[:, order]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robot", help="folder with the written robot.urdf and a biped.toml")
    parser.add_argument("--program", default="target/release/bipedc")
    parser.add_argument("--against", help="another URDF, such as the one before")
    arguments = parser.parse_args()
    urdf = os.path.join(arguments.robot, "robot.urdf")
    joints = list(pin.buildModelFromUrdf(urdf).names)[1:]
    random = np.random.default_rng(7)
    draw = lambda size: dict(zip(joints, (size * random.uniform(-1, 1, len(joints))).tolist()))
    states = [dict(position=draw(1.2), velocity=draw(4.0), acceleration=draw(20.0)) for _ in range(STATES)]
    names, reference = pinocchio_torques(urdf, states)
    own = bipedc_torques(arguments.program, arguments.robot, states, names)
    other = mujoco_torques(urdf, states, names)
    size = np.abs(reference).max()
    worst = {"bipedc": np.abs(own - reference).max() / size, "MuJoCo": np.abs(other - reference).max() / size}
    for who, away in worst.items():
        print(f"{who}: {away:.1e} of the largest torque ({size:.3f} N m) away from Pinocchio, {STATES} states")
    if arguments.against:
        _, before = pinocchio_torques(arguments.against, states)
        rms = np.sqrt(((before - reference) ** 2).mean(axis=0))
        for name, rms, whole in zip(names, rms, np.sqrt((reference ** 2).mean(axis=0))):
            print(f"  {name}: the other URDF is {rms:.4f} N m away, of {whole:.4f} N m (root mean squares)")
    sys.exit(0 if worst["bipedc"] < 1e-9 and worst["MuJoCo"] < 1e-6 else 1)


if __name__ == "__main__":
    main()
