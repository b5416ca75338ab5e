"""Outputs of a gait of several phases on the constrained dynamics, derived again (pip install numpy).

    python phased_lie_derivatives.py > ../data/gaits/phased_lie_derivatives.json

Nothing of bipedc takes part but the numbers in its URDF's place below and in the gait file. Bodies are described by the place of the hip and
absolute angles; the equations are those of seven rigid bodies, sum of m J^T J and m J^T (J' v + g). Contacts are points: toes and heels.
The constrained accelerations and forces follow from one linear system [D, -J^T; J, 0]. h is differentiated by hand: by Bernstein
polynomials and by the second derivatives of the points. Doubles: agreement is expected to some 1e-11.
"""
import json
import pathlib
import tomllib

import numpy as np
from math import comb

HERE = pathlib.Path(__file__).resolve().parent
GAIT = tomllib.loads((HERE / "../../robots/seven_link_v1/gaits/collocated.toml").read_text())
G = GAIT["gravity"]

# Coordinates: hip x, hip z, pitches (about +y, forward) of stance foot, shank, thigh, torso, swing thigh, shank, foot.
F1, S1, T1, TO, T2, S2, F2 = range(2, 9)
SHANK, THIGH = 0.30, 0.30
TOE, HEEL, ANKLE = 0.15, -0.07, -0.06
# Mass, inertia, pitch of the body, and the way to its centre: (pitch, x, z) one after the other.
LEG1, LEG2 = [(T1, 0, -THIGH), (S1, 0, -SHANK)], [(T2, 0, -THIGH), (S2, 0, -SHANK)]
BODIES = [
    (10.0, 0.25, TO, [(TO, 0, 0.22)]),
    (2.5, 0.01875, T1, [(T1, 0, -0.13)]),
    (2.5, 0.01875, T2, [(T2, 0, -0.13)]),
    (1.4, 0.0105, S1, LEG1[:1] + [(S1, 0, -0.13)]),
    (1.4, 0.0105, S2, LEG2[:1] + [(S2, 0, -0.13)]),
    (0.6, 0.0024, F1, LEG1 + [(F1, 0.03, -0.03)]),
    (0.6, 0.0024, F2, LEG2 + [(F2, 0.03, -0.03)]),
]
POINTS = {
    "right_toe": LEG1 + [(F1, TOE, ANKLE)],
    "right_heel": LEG1 + [(F1, HEEL, ANKLE)],
    "left_toe": LEG2 + [(F2, TOE, ANKLE)],
    "left_heel": LEG2 + [(F2, HEEL, ANKLE)],
}
# Joint angles in the order of bipedc: right hip, knee, ankle, then left; each one pitch less another.
JOINTS = [(T1, TO), (S1, T1), (F1, S1), (T2, TO), (S2, T2), (F2, S2)]
# By phase: points that are held, and directions.
HELD = {
    "single_support": [("right_toe", "xz"), ("right_heel", "z")],
    "toe_support": [("right_toe", "xz")],
    "touch_down": [("right_toe", "xz"), ("left_heel", "xz")],
    "push_off": [("right_toe", "xz"), ("right_heel", "z"), ("left_toe", "xz")],
}


def place(way, q, v):
    """Where a point is, how it moves with q, and its acceleration at v' = 0."""
    at, slope, bend = np.array(q[:2], float), np.zeros((2, 9)), np.zeros(2)
    slope[0, 0] = slope[1, 1] = 1
    for pitch, x, z in way:
        c, s = np.cos(q[pitch]), np.sin(q[pitch])
        arm = np.array([x * c + z * s, -x * s + z * c])
        at += arm
        slope[:, pitch] += arm[1], -arm[0]
        bend -= arm * v[pitch] ** 2
    return at, slope, bend


def unit(index):
    row = np.zeros(9)
    row[index] = 1
    return row


def relative(joint):
    return unit(JOINTS[joint][0]) - unit(JOINTS[joint][1])


def quantity(name, q, v):
    """Value, slopes, and second derivative along v of what a gait controls."""
    joints = dict(stance_hip=0, stance_knee=1, stance_ankle=2, swing_hip=3, swing_knee=4, swing_ankle=5)
    pitches = dict(torso=TO, stance_foot=F1, swing_foot=F2)
    if name in joints:
        row = relative(joints[name])
        return row @ q, row, 0.0
    if name in pitches:
        return q[pitches[name]], unit(pitches[name]), 0.0
    at, slope, bend = place(POINTS["right_toe"], q, v)
    axis = dict(phase=0, hip_height=1)[name]
    return q[axis] - at[axis], unit(axis) - slope[axis], -bend[axis]


def bernstein(c, s):
    n = len(c) - 1
    return sum(c[k] * comb(n, k) * s**k * (1 - s) ** (n - k) for k in range(n + 1))


def wanted(output, phase):
    c, (a, b) = np.array(output["wanted"]["bezier"]), output["wanted"]["over"]
    s, n = (phase - a) / (b - a), len(c) - 1
    first = n * np.diff(c)
    second = (n - 1) * np.diff(first)
    return bernstein(c, s), bernstein(first, s) / (b - a), bernstein(second, s) / (b - a) ** 2


def matching(value, slope, start, end, phase):
    """h_p: the cubic with this value and slope at `start` that vanishes twice at `end`."""
    length = end - start
    cubic = np.poly1d([-1 / length, 1.0]) ** 2 * np.poly1d([2 * value / length + slope, value])
    x = phase - start
    return cubic(x), cubic.deriv()(x), cubic.deriv(2)(x)


def motion(phase, q, v):
    """Accelerations and forces of the points, without torques and by joint."""
    mass, load = np.zeros((9, 9)), np.zeros(9)
    for m, inertia, pitch, way in BODIES:
        _, slope, bend = place(way, q, v)
        mass += m * slope.T @ slope
        mass[pitch, pitch] += inertia
        load += m * slope.T @ (bend + [0, G])
    rows, bends, names = [], [], []
    for point, axes in HELD[phase]:
        _, slope, bend = place(POINTS[point], q, v)
        for axis in axes:
            rows.append(slope["xz".index(axis)])
            bends.append(bend["xz".index(axis)])
            names.append((point, axis))
    rows, count = np.array(rows), len(rows)
    system = np.block([[mass, -rows.T], [rows, np.zeros((count, count))]])
    right = [np.concatenate([-load, -np.array(bends)])]
    right += [np.concatenate([relative(joint), np.zeros(count)]) for joint in range(6)]
    solved = np.linalg.solve(system, np.array(right).T)
    return solved[:9], dict(zip(names, solved[9:])), rows


def foot_forces(phase, forces):
    """As bipedc names them: along x, z and the moment about the middle of a flat sole, else at the point."""
    zero = np.zeros(7)
    of = lambda point, axis: forces.get((point, axis), zero)
    found = []
    for side in ("right", "left"):
        held = [point for point, _ in HELD[phase] if point.startswith(side)]
        if not held:
            continue
        toe, heel = f"{side}_toe", f"{side}_heel"
        found += [of(toe, "x") + of(heel, "x"), of(toe, "z") + of(heel, "z")]
        if len(held) == 2:
            half = 0.5 * (TOE - HEEL)
            # A push ahead of the middle turns backward about +y.
            found.append(-half * of(toe, "z") + half * of(heel, "z"))
    return found


def standing(phase, random):
    """A random state in which the held points are at rest on the ground."""
    of = next(p for p in GAIT["phase"] if p["name"] == phase)
    over = of["output"][0]["wanted"]["over"]
    start = np.array([0, 0.62, 0.0, -0.1, -0.15, 0.1, 0.2, 0.5, 0.3])
    if phase in ("toe_support", "touch_down"):
        start[F1] = 0.3
    if phase == "touch_down":
        start[[T2, S2, F2]] = -0.5, -0.2, -0.3
    if phase == "push_off":
        start[[T1, S1]] = -0.5, -0.3
    q = start + 0.08 * random.standard_normal(9)
    if phase in ("single_support", "push_off"):
        q[F1] = 0.0
    v = random.standard_normal(9) * 1.5
    for _ in range(60):
        points = [(point, axis) for point, axes in HELD[phase] for axis in axes]
        miss, slopes = [], []
        for point, axis in points:
            at, slope, _ = place(POINTS[point], q, v)
            # Where a foot stands along x is free.
            if axis == "z":
                miss.append(at[1])
                slopes.append(slope[1])
        middle = 0.5 * sum(over)
        value, slope, _ = quantity("phase", q, v)
        miss.append(value - middle)
        slopes.append(slope)
        q = q - np.linalg.pinv(np.array(slopes)) @ np.array(miss)
    q[0] += 0.3
    _, _, rows = motion(phase, q, v)
    v = v - np.linalg.pinv(rows) @ (rows @ v)
    return q, v


def ours(q, base):
    """In the order of bipedc: base x, z, pitch, then joints."""
    return [float(x) for x in [base[0], base[1], q[TO]] + [relative(joint) @ q for joint in range(6)]]


def case(phase, random):
    of = next(p for p in GAIT["phase"] if p["name"] == phase)
    q, v = standing(phase, random)
    accelerations, forces, _ = motion(phase, q, v)
    value, slope, bend = quantity("phase", q, v)
    rate = slope @ v
    ends = [value - 0.05 - 0.05 * random.random(), value + 0.05 + 0.05 * random.random()]
    cubic = [[0.05 * random.standard_normal(), 0.5 * random.standard_normal()] for _ in of["output"]]
    rows = []
    for output, pair in zip(of["output"], cubic):
        h0, gradient, curve = quantity(output["name"], q, v)
        hd, h1, h2 = np.array(wanted(output, value)) + matching(*pair, *ends, value)
        along = gradient - h1 * slope
        drift = along @ accelerations[:, 0] + curve - h1 * bend - h2 * rate**2
        rows.append([h0 - hd, along @ v, drift, *(along @ accelerations[:, 1:])])
    for force in foot_forces(phase, forces):
        rows.append([0.0, 0.0, *force])
    arguments = [0.0, *ends] + [x for pair in cubic for x in pair]
    return {
        "phase": phase,
        "q": ours(q, q),
        "v": ours(v, v),
        "arguments": [float(x) for x in arguments],
        "rows": [[float(x) for x in row] for row in rows],
    }


random = np.random.default_rng(8)
cases = [json.dumps(case(phase, random)) for phase in HELD for _ in range(6)]
print('{"cases": [\n' + ",\n".join(cases) + "\n]}")
