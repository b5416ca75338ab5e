#!/usr/bin/env python3
"""Writes oracle numbers for the robots of this repository, computed by Pinocchio.

    python3 -m venv VENV && VENV/bin/pip install pin numpy        # written with pin 4.1.0, numpy 2.4
    VENV/bin/python make_reference.py ROBOTS_FOLDER OUTPUT_FOLDER [--robots a,b] [--states 8] [--no-check]

ROBOTS_FOLDER holds `<name>.urdf` (or `<name>/robot.urdf`) and `contacts.json`; OUTPUT_FOLDER receives one
`<name>.json.gz` per robot (floating base; `tulip_v1_leg` fixed base) and, for the planar robots, also
`<name>_planar.json.gz`. The seed is fixed, so a second run on the same machine writes the same bytes.
All numbers are written so that they read back to the same double. Nothing here shares code with bipedc.

Everything that Pinocchio does not return itself (contact dynamics, impact, momentum about the world origin,
zero moment point) is assembled here with dense numpy algebra from Pinocchio's M, bias, J and J̇v. Unless
`--no-check` is given, the numbers are also checked against each other and against central differences.

The formats are described in README.md beside this file.
"""
import argparse
import gzip
import json
import os
import sys

import numpy as np
import pinocchio as pin

SEED = 20261121
GRAVITY = 9.81
PLANAR = ("three_link", "five_link", "seven_link")
FIXED = ("tulip_v1_leg",)
# (name in this repository, file stem and key in contacts.json of the folder the robots came from)
ROBOTS = {
    "three_link": "three_link",
    "five_link": "five_link",
    "seven_link": "seven_link",
    "biped_3d": "biped_3d",
    "tulip": "tulip_v3",
    "tulip_v1_leg": "tulip_v1_leg",
}
# Contact sets: each a list of `link` (all six rows; planar three), `link/edge` (five rows) or `link/point`
# (three rows; planar two).
CONTACT_SETS = {
    ("three_link", "floating"): [["right_leg/point_foot"]],
    ("five_link", "floating"): [["right_tibia/point_foot"], ["left_tibia/point_foot"]],
    ("seven_link", "floating"): [["right_foot"], ["left_foot/heel"]],
    ("three_link", "planar"): [["right_leg/point_foot"], ["left_leg/point_foot"],
                               ["left_leg/point_foot", "right_leg/point_foot"]],
    ("five_link", "planar"): [["right_tibia/point_foot"], ["left_tibia/point_foot"],
                              ["left_tibia/point_foot", "right_tibia/point_foot"]],
    ("seven_link", "planar"): [["right_foot"], ["left_foot"], ["right_foot/toe"], ["left_foot/heel"],
                               ["right_foot/toe", "left_foot/heel"], ["right_foot", "left_foot"]],
    ("biped_3d", "floating"): [["right_foot"], ["left_foot"], ["right_foot/front"], ["left_foot/rear"],
                               ["right_foot/front_left"], ["right_foot/front", "left_foot/rear"],
                               ["right_foot", "left_foot"]],
    ("tulip", "floating"): [["right_foot"], ["left_foot"], ["right_foot/front"], ["left_foot/rear"],
                            ["right_foot/front_left"], ["right_foot/front", "left_foot/rear"],
                            ["right_foot", "left_foot"]],
    ("tulip_v1_leg", "fixed"): [["right_foot/front_left"], ["right_foot/rear"], ["right_foot"]],
}
PASSIVE = {"tulip_v1_leg": ("right_ankle_roll",)}
EDGES = {"front": ("front_right", "front_left"), "rear": ("rear_right", "rear_left")}
WORLD = pin.LOCAL_WORLD_ALIGNED


def call(function, model, *arguments):
    """`function` with fresh data. Copies before the data dies: some results are views of it."""
    data = model.createData()
    result = function(model, data, *arguments)
    return tuple(np.array(r) for r in result) if isinstance(result, tuple) else np.array(result)


def build(urdf, base, points):
    """The model, with one operational frame per contact point, named `link/point`."""
    if base == "floating":
        model = pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer())
    elif base == "planar":
        # Three joints with massless bodies between: JointModelComposite gives wrong derivatives (pin 4.1).
        fixed = pin.buildModelFromUrdf(urdf)
        model, parent = pin.Model(), 0
        for joint, n in ((pin.JointModelPX(), "base/x"), (pin.JointModelPZ(), "base/z"),
                         (pin.JointModelRY(), "base/pitch")):
            parent = model.addJoint(parent, joint, pin.SE3.Identity(), n)
        root = next(f for f in fixed.frames if f.type == pin.BODY)
        model.appendBodyToJoint(parent, fixed.inertias[0], pin.SE3.Identity())
        model.addFrame(pin.Frame(root.name, parent, 0, pin.SE3.Identity(), pin.BODY))
        for i in range(1, fixed.njoints):
            over = parent if fixed.parents[i] == 0 else fixed.parents[i] + parent
            j = model.addJoint(int(over), fixed.joints[i], fixed.jointPlacements[i], fixed.names[i])
            assert j == i + parent
            model.appendBodyToJoint(j, fixed.inertias[i], pin.SE3.Identity())
            body = next(f for f in fixed.frames if f.type == pin.BODY and f.parentJoint == i)
            model.addFrame(pin.Frame(body.name, j, 0, pin.SE3.Identity(), pin.BODY))
    else:
        model = pin.buildModelFromUrdf(urdf)
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    for link, named in points.items():
        body = model.frames[model.getFrameId(link, pin.BODY)]
        for name, position in named.items():
            offset = pin.SE3(np.eye(3), np.array(position, float))
            model.addFrame(pin.Frame(f"{link}/{name}", body.parentJoint, model.getFrameId(link, pin.BODY),
                                     body.placement * offset, pin.OP_FRAME))
    # One link per joint: the regressor's columns are then the links' own parameters in their own frames.
    for frame in model.frames:
        if frame.type == pin.BODY:
            assert frame.placement.isIdentity(0.0), f"{frame.name} hangs on a fixed joint"
    return model


def first_link(base):
    """Index of the joint that carries the first link: the planar base's other two bodies are massless."""
    return 3 if base == "planar" else 1


def coordinate_names(model, base):
    joints = [n for n in model.names if n not in ("universe", "root_joint") and not n.startswith("base/")]
    head = {"floating": [f"base/{k}/{c}" for k in ("linear", "angular") for c in "xyz"],
            "planar": ["base/x", "base/z", "base/pitch"], "fixed": []}[base]
    return joints, head + joints


def random_state(rng, model, base):
    n = model.nv
    q = rng.uniform(-1.2, 1.2, model.nq)
    if base == "floating":
        quaternion = rng.normal(size=4)
        q[3:7] = quaternion / np.linalg.norm(quaternion)
    return q, rng.uniform(-3, 3, n), rng.uniform(-6, 6, n), rng.uniform(-25, 25, n)


def spatial_force(model, data, frame, force):
    """A world-axes force at a frame's origin, as a spatial force in the axes of the joint that carries it."""
    joint = model.frames[frame].parentJoint
    placement = data.oMi[joint]
    lever = data.oMf[frame].translation - placement.translation
    return joint, pin.Force(placement.rotation.T @ force, placement.rotation.T @ np.cross(lever, force))


def frame_numbers(model, q, v, a, frame):
    """Kinematics of one frame; everything in world axes, at the frame's origin."""
    jacobian = call(pin.computeFrameJacobian, model, q, frame, WORLD)
    data = model.createData()

    def motion(function):
        result = function(model, data, frame, WORLD)
        return np.concatenate([result.linear, result.angular])

    pin.forwardKinematics(model, data, q, v, a)
    pin.updateFramePlacements(model, data)
    velocity, acceleration = motion(pin.getFrameVelocity), motion(pin.getFrameClassicalAcceleration)
    pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
    pin.updateFramePlacements(model, data)
    rate = motion(pin.getFrameClassicalAcceleration)
    return dict(position=data.oMf[frame].translation.copy(), rotation=data.oMf[frame].rotation.copy(),
                jacobian=jacobian, velocity=velocity, acceleration=acceleration, jacobian_rate_times_velocity=rate)


def contact_rows(model, q, v, contact, points, planar):
    """Rows Wᵀ of one contact, w = (d/dt Wᵀ) v, their names, and Wᵀ's map from a world wrench (force, moment
    about the world origin) to what it does on the rows: wrench = span @ λ."""
    link, _, part = contact.partition("/")
    if part in EDGES:
        frame = f"{link}/{EDGES[part][0]}"
    else:
        frame = contact if part else link
    kind = pin.OP_FRAME if part else pin.BODY
    k = frame_numbers(model, q, v, np.zeros(model.nv), model.getFrameId(frame, kind))
    # Unit wrenches (force, moment about the frame's origin) of the rows.
    if planar:
        names, units = ["x", "z"], [np.eye(6)[0], np.eye(6)[2]]
        if not part:
            names.append("pitch")
            units.append(np.eye(6)[4])
    else:
        names, units = ["x", "y", "z"], list(np.eye(6)[:3])
        if not part:
            names += ["rotation_x", "rotation_y", "rotation_z"]
            units += list(np.eye(6)[3:])
        elif part in EDGES:
            # No rotation about axes perpendicular to the edge, which runs along y of the link.
            assert points[link][EDGES[part][0]][0] == points[link][EDGES[part][1]][0]
            assert points[link][EDGES[part][0]][2] == points[link][EDGES[part][1]][2]
            names += ["rotation_link_x", "rotation_link_z"]
            for axis in (0, 2):
                units.append(np.concatenate([np.zeros(3), k["rotation"][:, axis]]))
    units = np.array(units)
    rows = units @ k["jacobian"]
    # For a link-fixed axis e: d/dt (e·ω) = e·ω̇ + (ω×e)·ω = e·ω̇.
    rate = units @ k["jacobian_rate_times_velocity"]
    span = np.array([np.concatenate([u[:3], u[3:] + np.cross(k["position"], u[:3])]) for u in units]).T
    return rows, rate, [f"{contact}:{n}" for n in names], span


def saddle(matrix, jacobian_rows, right, below):
    """Solves [M −W; Wᵀ 0] [x; λ] = [right; below] densely, refined in extended precision."""
    n, m = len(matrix), len(jacobian_rows)
    kkt = np.block([[matrix, -jacobian_rows.T], [jacobian_rows, np.zeros((m, m))]])
    b = np.concatenate([right, below])
    x = np.linalg.solve(kkt, b).astype(np.longdouble)
    for _ in range(3):
        x = x + np.linalg.solve(kkt, (b - kkt.astype(np.longdouble) @ x).astype(float))
    x = x.astype(float)
    return x[:n], x[n:], np.linalg.cond(kkt)


def contact_numbers(model, q, v, tau, contacts, points, planar):
    mass = symmetric(call(pin.crba, model, q))

    def rows_at(velocity):
        parts = [contact_rows(model, q, velocity, c, points, planar) for c in contacts]
        return (np.vstack([p[0] for p in parts]), np.concatenate([p[1] for p in parts]),
                [n for p in parts for n in p[2]], parts)

    def wrenches(parts, multipliers):
        out, at = {}, 0
        for contact, (rows, _, _, span) in zip(contacts, parts):
            out[contact] = span @ multipliers[at:at + len(rows)]
            at += len(rows)
        return out

    def dynamics(velocity):
        rows, rate, _, parts = rows_at(velocity)
        bias = call(pin.nonLinearEffects, model, q, velocity)
        a, multipliers, _ = saddle(mass, rows, tau - bias, -rate)
        return dict(v=velocity, constraint_rate=rate, acceleration=a, multipliers=multipliers,
                    world_wrenches=wrenches(parts, multipliers))

    rows, _, names, parts = rows_at(v)
    after, impulses, condition = saddle(mass, rows, mass @ v, np.zeros(len(rows)))
    assert condition < 1e9, (contacts, condition)
    return dict(contacts=contacts, row_names=names, rows=rows,
                dynamics=dynamics(v),
                impact=dict(v_after=after, impulses=impulses, world_wrench_impulses=wrenches(parts, impulses),
                            kinetic_energy_before=v @ mass @ v / 2, kinetic_energy_after=after @ mass @ after / 2),
                dynamics_after_impact=dynamics(after))


def symmetric(m):
    return np.triu(m) + np.triu(m, 1).T


def momentum_about_origin(model, q, v, a):
    data = model.createData()
    pin.centerOfMass(model, data, q, v, a)
    c = data.com[0].copy()
    pin.computeCentroidalMomentumTimeVariation(model, data, q, v, a)
    h, rate = data.hg.vector.copy(), data.dhg.vector.copy()
    # σ = h_ang + c×ρ; its rate has no ċ×ρ because ρ = M ċ.
    sigma, sigma_rate = h[3:] + np.cross(c, h[:3]), rate[3:] + np.cross(c, rate[:3])
    return np.concatenate([h[:3], sigma]), np.concatenate([rate[:3], sigma_rate])


def zero_moment_point(mass, com, rate):
    load = mass * GRAVITY + rate[2]
    return np.array([(mass * GRAVITY * com[0] - rate[4]) / load, (mass * GRAVITY * com[1] + rate[3]) / load])


def case(rng, model, name, base, points):
    q, v, a, tau = random_state(rng, model, base)
    planar = base == "planar"
    c = dict(q=q, v=v, a=a, tau=tau)
    c["inverse_dynamics"] = call(pin.rnea, model, q, v, a)
    c["forward_dynamics"] = call(pin.aba, model, q, v, tau)
    mass = symmetric(call(pin.crba, model, q))
    c["mass_matrix"] = mass
    c["bias"] = call(pin.nonLinearEffects, model, q, v)
    c["gravity"] = call(pin.computeGeneralizedGravity, model, q)
    # Without gravity, not as a difference: the velocity terms keep their own digits.
    free = model.copy()
    free.gravity.linear = np.zeros(3)
    c["coriolis_times_velocity"] = call(pin.nonLinearEffects, free, q, v)
    d = call(pin.computeRNEADerivatives, model, q, v, a)
    c["inverse_dynamics_dq"], c["inverse_dynamics_dv"] = d[0], d[1]
    d = call(pin.computeABADerivatives, model, q, v, tau)
    c["forward_dynamics_dq"], c["forward_dynamics_dv"], c["forward_dynamics_dtau"] = d
    c["forward_dynamics_dtau"] = symmetric(c["forward_dynamics_dtau"])
    c["kinetic_energy"] = float(call(pin.computeKineticEnergy, model, q, v))
    c["potential_energy"] = float(call(pin.computePotentialEnergy, model, q))

    data = model.createData()
    pin.centerOfMass(model, data, q, v, a)
    com = data.com[0].copy()
    c["center_of_mass"], c["center_of_mass_velocity"] = com, data.vcom[0].copy()
    c["center_of_mass_acceleration"] = data.acom[0].copy()
    c["center_of_mass_jacobian"] = call(pin.jacobianCenterOfMass, model, q)
    data = model.createData()
    pin.computeCentroidalMomentumTimeVariation(model, data, q, v, a)
    c["centroidal_momentum"], c["centroidal_momentum_rate"] = data.hg.vector.copy(), data.dhg.vector.copy()
    c["momentum"], c["momentum_rate"] = momentum_about_origin(model, q, v, a)
    total = pin.computeTotalMass(model)
    c["zero_moment_point"] = zero_moment_point(total, com, c["momentum_rate"])

    c["frames"] = {}
    forces, fext = {}, pin.StdVec_Force()
    for _ in range(model.njoints):
        fext.append(pin.Force.Zero())
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    for i, frame in enumerate(model.frames):
        if frame.type in (pin.BODY, pin.OP_FRAME) and (frame.parentJoint > 0):
            c["frames"][frame.name] = frame_numbers(model, q, v, a, i)
        if frame.type == pin.OP_FRAME:
            force = rng.uniform(-40, 40, 3)
            if planar:
                force[1] = 0.0
            forces[frame.name] = force
            joint, spatial = spatial_force(model, data, i, force)
            fext[joint] += spatial
    c["contact_forces"] = forces
    c["inverse_dynamics_with_forces"] = call(pin.rnea, model, q, v, a, fext)
    c["forward_dynamics_with_forces"] = call(pin.aba, model, q, v, tau, fext)

    first = 10 * (first_link(base) - 1)
    c["inverse_dynamics_regressor"] = call(pin.computeJointTorqueRegressor, model, q, v, a)[:, first:]
    c["kinetic_energy_regressor"] = np.ravel(call(pin.computeKineticEnergyRegressor, model, q, v))[first:]
    c["potential_energy_regressor"] = np.ravel(call(pin.computePotentialEnergyRegressor, model, q))[first:]

    # B τ: the base is not actuated, nor are passive joints.
    effort = tau.copy()
    effort[: {"floating": 6, "planar": 3, "fixed": 0}[base]] = 0.0
    for joint in PASSIVE.get(name, ()):
        effort[model.joints[model.getJointId(joint)].idx_v] = 0.0
    c["generalized_effort"] = effort
    c["contact"] = [contact_numbers(model, q, v, effort, s, points, planar) for s in CONTACT_SETS[name, base]]
    return c


def close(what, actual, expected, tolerance):
    actual, expected = np.asarray(actual), np.asarray(expected)
    error = np.max(np.abs(actual - expected), initial=0.0) / max(1.0, np.max(np.abs(expected), initial=0.0))
    if not error <= tolerance:
        raise SystemExit(f"check failed: {what}: {error:.2e} > {tolerance:.0e}")


def check(model, base, c, parameters, floating):
    """Consistency of one case: identities to rounding, derivatives by central differences."""
    q, v, a, tau, n = c["q"], c["v"], c["a"], c["tau"], model.nv
    close("bias = C v + G", c["coriolis_times_velocity"] + c["gravity"], c["bias"], 1e-12)
    close("M a + H", c["mass_matrix"] @ a + c["bias"], c["inverse_dynamics"], 1e-12)
    close("forward dynamics", c["mass_matrix"] @ c["forward_dynamics"] + c["bias"], tau, 1e-10)
    close("M dqdd/dtau", c["mass_matrix"] @ c["forward_dynamics_dtau"], np.eye(n), 1e-10)
    close("regressor", c["inverse_dynamics_regressor"] @ parameters, c["inverse_dynamics"], 1e-12)
    close("kinetic energy", v @ c["mass_matrix"] @ v / 2, c["kinetic_energy"], 1e-12)
    close("kinetic regressor", c["kinetic_energy_regressor"] @ parameters, c["kinetic_energy"], 1e-12)
    close("potential regressor", c["potential_energy_regressor"] @ parameters, c["potential_energy"], 1e-12)
    total = pin.computeTotalMass(model)
    close("CoM velocity", c["center_of_mass_jacobian"] @ v, c["center_of_mass_velocity"], 1e-12)
    close("linear momentum", total * c["center_of_mass_velocity"], c["momentum"][:3], 1e-12)
    close("its rate", total * c["center_of_mass_acceleration"], c["momentum_rate"][:3], 1e-12)
    applied = sum(c["frames"][p]["jacobian"][:3].T @ f for p, f in c["contact_forces"].items())
    close("external forces", c["inverse_dynamics"] - applied, c["inverse_dynamics_with_forces"], 1e-11)
    close("forces, forward", c["mass_matrix"] @ c["forward_dynamics_with_forces"] + c["bias"] - applied, tau, 1e-9)
    for f in c["frames"].values():
        close("frame velocity", f["jacobian"] @ v, f["velocity"], 1e-12)
        close("frame acceleration", f["jacobian"] @ a + f["jacobian_rate_times_velocity"], f["acceleration"], 1e-11)
    if base == "floating":
        # The base wrench of inverse dynamics, moved to the world origin, is the ground's: no force to spare at
        # the zero moment point except along z.
        data = model.createData()
        pin.forwardKinematics(model, data, q)
        R, p = data.oMi[1].rotation, data.oMi[1].translation
        force = R @ c["inverse_dynamics"][:3]
        moment = R @ c["inverse_dynamics"][3:6] + np.cross(p, force)
        close("ZMP from the base wrench", [-moment[1] / force[2], moment[0] / force[2]], c["zero_moment_point"], 1e-10)
    h = 1e-6
    for i in range(n):
        step = np.zeros(n)
        step[i] = h
        up, down = pin.integrate(model, q, step), pin.integrate(model, q, -step)
        difference = (call(pin.rnea, model, up, v, a) - call(pin.rnea, model, down, v, a)) / (2 * h)
        close("inverse dynamics dq", difference, c["inverse_dynamics_dq"][:, i], 1e-6)
        difference = (call(pin.rnea, model, q, v + step, a) - call(pin.rnea, model, q, v - step, a)) / (2 * h)
        close("inverse dynamics dv", difference, c["inverse_dynamics_dv"][:, i], 1e-6)
        difference = (call(pin.aba, model, up, v, tau) - call(pin.aba, model, down, v, tau)) / (2 * h)
        close("forward dynamics dq", difference, c["forward_dynamics_dq"][:, i], 1e-5)
        difference = (call(pin.aba, model, q, v + step, tau) - call(pin.aba, model, q, v - step, tau)) / (2 * h)
        close("forward dynamics dv", difference, c["forward_dynamics_dv"][:, i], 1e-5)
    # Along the motion with acceleration a: rates of momentum, Jacobians, constraint rows.
    ahead, behind = pin.integrate(model, q, h * v + h * h / 2 * a), pin.integrate(model, q, -h * v + h * h / 2 * a)
    difference = (momentum_about_origin(model, ahead, v + h * a, a)[0]
                  - momentum_about_origin(model, behind, v - h * a, a)[0]) / (2 * h)
    close("momentum rate", difference, c["momentum_rate"], 1e-6)
    for s in c["contact"]:
        W = np.asarray(s["rows"])
        for k in ("dynamics", "dynamics_after_impact"):
            d = s[k]
            H = call(pin.nonLinearEffects, model, q, d["v"])
            close("contact dynamics", c["mass_matrix"] @ d["acceleration"] + H - W.T @ d["multipliers"],
                  c["generalized_effort"], 1e-9)
            close("contact acceleration", W @ d["acceleration"] + d["constraint_rate"], np.zeros(len(W)), 1e-9)
            # The world wrenches do on the base what the multipliers do.
            if base == "floating":
                data = model.createData()
                pin.forwardKinematics(model, data, q)
                R, p = data.oMi[1].rotation, data.oMi[1].translation
                w = sum(d["world_wrenches"].values())
                on_base = np.concatenate([R.T @ w[:3], R.T @ (w[3:] - np.cross(p, w[:3]))])
                close("world wrench", on_base, (W.T @ d["multipliers"])[:6], 1e-9)
        i = s["impact"]
        close("impact", c["mass_matrix"] @ (i["v_after"] - v), W.T @ i["impulses"], 1e-9)
        close("impact rows", W @ i["v_after"], np.zeros(len(W)), 1e-10)
        assert i["kinetic_energy_after"] <= i["kinetic_energy_before"]
    if base == "planar":
        # The same state seen by the floating model.
        x, z, pitch = q[:3]
        half = pitch / 2
        R = pin.utils.rotate("y", pitch)
        qf = np.concatenate([[x, 0, z, 0, np.sin(half), 0, np.cos(half)], q[3:]])
        omega = np.array([0, v[2], 0])
        body = R.T @ [v[0], 0, v[1]]
        vf = np.concatenate([body, omega, v[3:]])
        af = np.concatenate([R.T @ [a[0], 0, a[1]] - np.cross(omega, body), [0, a[2], 0], a[3:]])
        t = call(pin.rnea, floating, qf, vf, af)
        force = R @ t[:3]
        close("planar = floating", np.concatenate([[force[0], force[2], t[4]], t[6:]]), c["inverse_dynamics"], 1e-12)


def plain(x):
    """Lists of floats; exact zeros (structure) as 0."""
    if isinstance(x, np.ndarray):
        return plain(x.tolist())
    if isinstance(x, dict):
        return {k: plain(v) for k, v in x.items()}
    if isinstance(x, (list, tuple)):
        return [plain(v) for v in x]
    if isinstance(x, (float, np.floating)):
        assert np.isfinite(x)
        return 0 if x == 0.0 else float(x)
    return x


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("robots_folder")
    p.add_argument("output_folder")
    p.add_argument("--robots", default=",".join(ROBOTS))
    p.add_argument("--states", type=int, default=8)
    p.add_argument("--no-check", action="store_true")
    args = p.parse_args()
    os.makedirs(args.output_folder, exist_ok=True)
    with open(os.path.join(args.robots_folder, "contacts.json")) as f:
        contacts = json.load(f)
    for name in args.robots.split(","):
        stem = ROBOTS[name]
        candidates = [f"{stem}.urdf", f"{name}.urdf", f"{name}/robot.urdf"]
        urdf = next(u for u in (os.path.join(args.robots_folder, c) for c in candidates) if os.path.exists(u))
        points = contacts.get(stem) or contacts[name]
        bases = ["fixed"] if name in FIXED else ["floating"] + (["planar"] if name in PLANAR else [])
        for base in bases:
            model = build(urdf, base, points)
            floating = build(urdf, "floating", points)
            joints, coordinates = coordinate_names(model, base)
            bodies = [next(f.name for f in model.frames if f.type == pin.BODY and f.parentJoint == i)
                      for i in range(first_link(base), model.njoints)]
            parameters = np.array([model.inertias[i].toDynamicParameters() for i in range(first_link(base), model.njoints)])
            rng = np.random.default_rng([SEED, list(ROBOTS).index(name), ["floating", "planar", "fixed"].index(base)])
            cases = [case(rng, model, name, base, points) for _ in range(args.states)]
            if not args.no_check:
                for c in cases:
                    check(model, base, c, parameters.ravel(), floating)
            out = dict(robot=name, base=base, generator=f"Pinocchio {pin.__version__}", seed=SEED,
                       gravity=[0, 0, -GRAVITY], total_mass=pin.computeTotalMass(model), joints=joints,
                       coordinates=coordinates, links=bodies,
                       parameter_order=["m", "m c_x", "m c_y", "m c_z", "I_xx", "I_xy", "I_yy", "I_xz", "I_yz", "I_zz"],
                       link_parameters=dict(zip(bodies, parameters)),
                       contact_points={f"{l}/{n}": x for l, named in points.items() for n, x in named.items()},
                       cases=cases)
            file = os.path.join(args.output_folder, name + ("_planar" if base == "planar" else "") + ".json.gz")
            text = json.dumps(plain(out), separators=(",", ":"), allow_nan=False) + "\n"
            with open(file, "wb") as f:
                f.write(gzip.compress(text.encode(), 9, mtime=0))
            print(f"{file}: {len(text)} bytes, {os.path.getsize(file)} compressed", file=sys.stderr)


if __name__ == "__main__":
    main()
