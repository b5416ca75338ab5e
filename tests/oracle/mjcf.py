"""What MuJoCo makes of the models that `bipedc export --mjcf` writes.

    python3 tests/oracle/mjcf.py target/debug/bipedc

Exports robots, some with effects, loads them in MuJoCo and writes mass matrices and generalised forces (gravity, velocities, springs
and dampers) at random states to tests/data/mjcf. A free base stands upright and still: there MuJoCo's coordinates are ours.
Needs `mujoco` and `numpy`; made with MuJoCo 3.
"""
import json, os, shutil, subprocess, sys, tempfile
import mujoco, numpy

EFFECTS = """
[[effect]]
kind = "rotor_inertia"
joint = "left_knee_pitch"
inertia = 0.13

[[effect]]
kind = "viscous_friction"
joint = "left_knee_pitch"
damping = 0.7

[[effect]]
kind = "parallel_spring"
joint = "right_hip_pitch"
stiffness = 11.0
rest_angle = 0.2

[[effect]]
kind = "payload"
link = "left_femur"
mass = 1.5
x = 0.02
y = 0.0
z = -0.1

[[effect]]
kind = "inertial_correction"
link = "torso"
mass = 0.3
x = 0.01
iyy = 0.05
"""

def folder(robot, effects, place):
    made = os.path.join(place, robot)
    shutil.copytree(os.path.join("robots", robot), made)
    with open(os.path.join(made, "biped.toml"), "a") as file:
        file.write(effects)
    return made

def state(model, data, random):
    free = model.njnt > 0 and model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
    data.qpos[:] = random.uniform(-1, 1, model.nq)
    data.qvel[:] = random.uniform(-2, 2, model.nv)
    q = data.qpos.copy()
    if free:
        data.qpos[3:7] = [1, 0, 0, 0]
        data.qvel[:6] = 0
        q = data.qpos.copy()
        q[3:7] = [0, 0, 0, 1]
    mujoco.mj_forward(model, data)
    mass = numpy.zeros((model.nv, model.nv))
    for k, unit in enumerate(numpy.eye(model.nv)):
        mujoco.mj_mulM(model, data, mass[k], unit)
    force = data.qfrc_bias - data.qfrc_passive
    return {"q": q.tolist(), "v": data.qvel.tolist(), "mass_matrix": mass.ravel().tolist(), "bias": force.tolist()}

def main(program):
    cases = [("tulip", ""), ("tulip_v1_leg", ""), ("seven_link", ""), ("five_link", EFFECTS)]
    for robot, effects in cases:
        with tempfile.TemporaryDirectory() as place:
            path, out = folder(robot, effects, place), os.path.join(place, "model.xml")
            subprocess.run([program, "export", path, "--mjcf", out], check=True)
            text = open(out).read()
        model = mujoco.MjModel.from_xml_string(text)
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
        data, random = mujoco.MjData(model), numpy.random.default_rng(7)
        states = [state(model, data, random) for _ in range(3)]
        joints = [model.joint(k).name for k in range(model.njnt)]
        found = {"robot": robot, "joints": joints, "effects": effects, "mujoco": mujoco.__version__, "mjcf": text, "states": states}
        with open(f"tests/data/mjcf/{robot}.json", "w") as file:
            json.dump(found, file)

main(sys.argv[1])
