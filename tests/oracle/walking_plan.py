"""Recomputes a walk that `bipedc gait plan` wrote, from the URDF, the plan's joints and base, and the footsteps alone.

    VENV/bin/pip install pin==4.1.0 numpy scipy
    VENV/bin/python walking_plan.py ROBOT.urdf PLAN.csv PLAN.json [--every N --reference OUT.json.gz]

PLAN.json is what `bipedc gait plan … --json` prints. Wished feet are computed anew from footsteps and phases (cosine profile 6.43), positions,
momenta and torques by Pinocchio, margins by scipy's convex hull. Exit code 1 where feet are farther than 1e-6 m from the wished, margins differ by more than 0.1 mm,
velocities and accelerations are not the derivatives of positions, or a limit of the URDF does not hold. --reference writes states and numbers of every Nth row.
"""
import argparse
import csv
import gzip
import json
import sys

import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull

AXES = "xyz"
FEET_WITHIN = 1e-6
MARGIN_WITHIN = 1e-4


def read(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    table = np.array(rows[1:], dtype=float)
    return {name: table[:, k] for k, name in enumerate(rows[0])}


def columns(log, prefix, axes=AXES):
    return np.stack([log[f"{prefix}/{axis}"] for axis in axes], axis=1)


def states(model, log):
    """q, v, a of Pinocchio at every row; base acceleration from the classical one."""
    n = len(log["time"])
    q, v, a = np.zeros((n, model.nq)), np.zeros((n, model.nv)), np.zeros((n, model.nv))
    q[:, :3], q[:, 3:7] = columns(log, "base/position"), columns(log, "base/orientation", "xyzw")
    q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1)[:, None]
    lin, ang = columns(log, "base/linear_velocity"), columns(log, "base/angular_velocity")
    lin_a, ang_a = columns(log, "base/linear_acceleration"), columns(log, "base/angular_acceleration")
    for k in range(n):
        turn = pin.Quaternion(q[k, 3:7]).toRotationMatrix()
        v[k, :3], v[k, 3:6] = turn.T @ lin[k], ang[k]
        a[k, :3] = turn.T @ lin_a[k] - np.cross(ang[k], v[k, :3])
        a[k, 3:6] = ang_a[k]
    for joint in range(2, model.njoints):
        name, iq, iv = model.names[joint], model.joints[joint].idx_q, model.joints[joint].idx_v
        q[:, iq], v[:, iv], a[:, iv] = (log[f"{name}/{what}"] for what in ("position", "velocity", "acceleration"))
    return q, v, a


def profile(s):
    s = min(max(s, 0.0), 1.0)
    return s - np.sin(2 * np.pi * s) / (2 * np.pi)


def wished(plan, times):
    """x, y, z, yaw of both soles at all times, and which stand: from footsteps and phases."""
    names = ["right", "left"]
    width = plan["settings"]["stance_width"]
    height = plan["settings"]["step_height"]
    stance = np.array([[0.0, -width / 2, 0.0, 0.0], [0.0, width / 2, 0.0, 0.0]])
    feet, stand = np.zeros((len(times), 2, 4)), np.ones((len(times), 2), dtype=bool)
    half = 0.5 * (times[1] - times[0])
    for index, phase in enumerate(plan["phases"]):
        begin, duration = phase["start"], phase["duration"]
        last = index + 1 == len(plan["phases"])
        inside = [k for k, t in enumerate(times) if t > begin - half and (last or t < begin + duration - half)]
        foot = names.index(phase["swing"]) if phase["swing"] else None
        if foot is not None:
            target = plan["footsteps"][phase["step"] - 1]
            goal = np.array([target["x"], target["y"], 0.0, target["yaw"]])
        for k in inside:
            feet[k] = stance
            if foot is None:
                continue
            s = (times[k] - begin) / duration
            stand[k, foot] = False
            start = stance[foot]
            if phase["kind"] == "swing":
                feet[k, foot] = start + profile(s) * (goal - start)
                feet[k, foot, 2] = height * (profile(2 * s) if s < 0.5 else 1 - profile(2 * s - 1))
            else:
                lifting = phase["kind"] == "lift"
                middle = 0.5 * (begun + goal) if not lifting else 0.5 * (start + goal)
                middle[2] = height
                a, b = (start, middle) if lifting else (middle, goal)
                feet[k, foot] = a + profile(s) * (b - a)
        if phase["kind"] == "lift":
            begun = stance[foot].copy()
        if phase["kind"] in ("swing", "place"):
            stance[foot] = goal
    return feet, stand


def margin(points, point):
    hull = ConvexHull(points)
    return -np.max(hull.equations[:, :2] @ point + hull.equations[:, 2])


def recompute(model, data, plan, soles, link_ids, q, v, a):
    """Soles (position, rotation, velocity), centre of mass, zero moment point, generalised forces at a state."""
    pin.computeAllTerms(model, data, q, v)
    pin.forwardKinematics(model, data, q, v, a)
    pin.updateFramePlacements(model, data)
    found = {"soles": [], "turns": [], "speeds": [], "jacobians": []}
    for sole, frame in zip(soles, link_ids):
        place = data.oMf[frame]
        found["soles"].append(place.act(np.array(sole["center"])))
        found["turns"].append(place.rotation @ np.array(sole["axes"]))
        jacobian = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
        arm = place.rotation @ np.array(sole["center"])
        jacobian[:3] -= pin.skew(arm) @ jacobian[3:]
        found["jacobians"].append(jacobian)
        found["speeds"].append(jacobian @ v)
    pin.computeCentroidalMomentumTimeVariation(model, data, q, v, a)
    mass, center = data.mass[0], data.com[0].copy()
    rate = data.dhg
    # About the world's origin; (4.42).
    angular = rate.angular + np.cross(center, rate.linear)
    weight = mass * 9.81
    load = weight + rate.linear[2]
    found["center"] = center
    found["zmp"] = np.array([(weight * center[0] - angular[1]) / load, (weight * center[1] + angular[0]) / load])
    found["forces"] = pin.rnea(model, data, q, v, a)
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("urdf")
    parser.add_argument("csv")
    parser.add_argument("json")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--reference")
    options = parser.parse_args()
    model = pin.buildModelFromUrdf(options.urdf, pin.JointModelFreeFlyer())
    data = model.createData()
    log, plan = read(options.csv), json.load(open(options.json))
    times = log["time"]
    q, v, a = states(model, log)
    feet, stand = wished(plan, times)
    soles = plan["soles"]
    link_ids = [model.getFrameId(sole["link"]) for sole in soles]
    worst = dict.fromkeys(
        ("feet (m)", "feet, as written (m)", "tilt (rad)", "standing feet's speed (m/s)", "centre of mass (m)", "zero moment point (m)",
         "margin (m)", "effort, one foot (N m)"), 0.0)
    least, reference = np.inf, []

    def note(name, value):
        worst[name] = max(worst[name], float(value))

    for k in range(len(times)):
        now = recompute(model, data, plan, soles, link_ids, q[k], v[k], a[k])
        points = []
        for foot, sole in enumerate(soles):
            x, y, z, yaw = feet[k, foot]
            note("feet (m)", np.abs(now["soles"][foot] - [x, y, z]).max())
            written = columns(log, f"{sole['foot']}/sole")[k]
            note("feet, as written (m)", np.abs(now["soles"][foot] - written).max())
            turn = pin.rpy.rpyToMatrix(0.0, 0.0, yaw)
            note("tilt (rad)", np.linalg.norm(pin.log3(turn.T @ now["turns"][foot])))
            assert bool(log[f"{sole['foot']}/contact"][k]) == bool(stand[k, foot]), f"contact at {times[k]} s"
            if stand[k, foot]:
                note("standing feet's speed (m/s)", np.abs(now["speeds"][foot]).max())
                corners = np.array(sole["corners"])[:, :2]
                spin = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
                points += list(corners @ spin.T + [x, y])
        note("centre of mass (m)", np.abs(now["center"] - columns(log, "center_of_mass")[k]).max())
        note("zero moment point (m)", np.abs(now["zmp"] - columns(log, "zero_moment_point", "xy")[k]).max())
        inside = margin(np.array(points), now["zmp"])
        least = min(least, inside)
        note("margin (m)", abs(inside - log["zero_moment_point/margin"][k]))
        if stand[k].sum() == 1:
            foot = int(np.argmax(stand[k]))
            jacobian = now["jacobians"][foot]
            wrench = np.linalg.solve(jacobian[:, :6].T, now["forces"][:6])
            torque = now["forces"] - jacobian.T @ wrench
            for joint in range(2, model.njoints):
                note("effort, one foot (N m)", abs(torque[model.joints[joint].idx_v] - log[f"{model.names[joint]}/effort"][k]))
        if k % options.every == 0:
            reference.append({
                "time": times[k], "q": list(q[k]), "v": list(v[k]), "a": list(a[k]),
                "soles": [list(p) for p in now["soles"]], "center": list(now["center"]), "zmp": list(now["zmp"]), "margin": inside})

    step = times[1] - times[0]
    joints = slice(7, None), slice(6, None)
    rate = (q[2:, joints[0]] - q[:-2, joints[0]]) / (2 * step) - v[1:-1, joints[1]]
    second = (v[2:, joints[1]] - v[:-2, joints[1]]) / (2 * step) - a[1:-1, joints[1]]
    # What a central difference of this step misses of a motion whose accelerations are so large and change so fast.
    jerk = np.abs(np.diff(a[:, joints[1]], axis=0)).max() / step
    limits = {
        "positions": bool(((q >= model.lowerPositionLimit - 1e-9) & (q <= model.upperPositionLimit + 1e-9))[:, 7:].all()),
        "velocities": bool((np.abs(v[:, 6:]) <= model.velocityLimit[6:] + 1e-9).all()),
        "efforts": all(
            np.abs(log[f"{model.names[j]}/effort"]).max() <= model.effortLimit[model.joints[j].idx_v] + 1e-9
            for j in range(2, model.njoints)),
    }
    print(f"{len(times)} rows of {step} s")
    for name, value in worst.items():
        print(f"{name:32} {value:.3e}")
    print(f"{'least margin (m)':32} {least:.6f}")
    print(f"velocity less difference of positions {np.abs(rate).max():.3e} rad/s, of {np.abs(v).max():.3f}")
    print(f"acceleration less difference of velocities {np.abs(second).max():.3e} rad/s2, of {np.abs(a).max():.3f}")
    print(f"limits of the URDF: {limits}")
    if options.reference:
        text = json.dumps({"robot": plan["robot"], "generator": f"pinocchio {pin.__version__}", "joints": list(model.names)[2:],
                           "worst": worst, "least_margin": least, "cases": reference})
        with gzip.GzipFile(options.reference, "wb", mtime=0) as file:
            file.write(text.encode())
    good = worst["feet (m)"] < FEET_WITHIN and worst["margin (m)"] < MARGIN_WITHIN and all(limits.values())
    good &= np.abs(rate).max() < jerk * step**2 and np.abs(second).max() < jerk * step
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
