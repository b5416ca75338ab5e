"""Lie derivatives of gaits' outputs, to thirty digits (pip install mpmath==1.3.0).

    python lie_derivatives.py > ../data/gaits/lie_derivatives.json

Nothing of bipedc takes part. As in zero_dynamics.py bodies are described by absolute angles t, with the foot that stands at the origin:
M(t) t'' = B u - (what gravity and the bodies' centripetal accelerations do). h is differentiated along curves: L_f h is the slope of
h(t + s t'), L_f^2 h the second derivative of h(t + s t' + s^2/2 t''(u = 0)), a column of L_g L_f h the slope of h(t + s M^-1 B_j).
"""
import json
import random

from mpmath import cos, diff, lu_solve, matrix, mp, mpf, pi, sin

from zero_dynamics import FIVE, THREE, cubic, five_link, three_link

mp.dps = 30

# Rows of the joints in terms of absolute angles: each is one angle less another.
JOINTS = {"three_link": [(1, 0), (2, 0)], "five_link": [(1, 0), (2, 1), (3, 0), (4, 3)]}


def published(p):
    """The gait of Grizzle, Abba and Plestan."""
    end = p["landing"]
    read = lambda t: (t[1], [t[0], t[1] + t[2]])
    wanted = lambda x: [
        mpf("0.512") + mpf("0.073") * x + mpf("0.035") * x**2 - mpf("0.819") * x**3,
        (x + end) * (x - end) * (mpf("-2.27") + mpf("3.26") * x + mpf("3.11") * x**2 + mpf("1.89") * x**3),
    ]
    return THREE, end, read, wanted, None, 2


def columns(robot, arms, t):
    """Of a body's centre from the stance foot: how x and z change with each angle, and with its square of the rate."""
    arms = [a - f for a, f in zip(arms, robot["feet"][0])]
    moves = [(a * cos(x), -a * sin(x)) for a, x in zip(arms, t)]
    turns = [(-a * sin(x), -a * cos(x)) for a, x in zip(arms, t)]
    return moves, turns


def dynamics(robot, t, rates):
    """M and the right-hand side without torques."""
    n = len(t)
    mass, free = matrix(n, n), matrix(n, 1)
    for index, (m, inertia, arms) in enumerate(robot["bodies"]):
        moves, turns = columns(robot, arms, t)
        bend = [sum(turn[k] * r**2 for turn, r in zip(turns, rates)) for k in (0, 1)]
        for i in range(n):
            for j in range(n):
                mass[i, j] += m * (moves[i][0] * moves[j][0] + moves[i][1] * moves[j][1])
            free[i] -= m * (moves[i][0] * bend[0] + moves[i][1] * (bend[1] + robot["g"]))
        mass[index, index] += inertia
    return mass, free


def case(name, gait, make, p, rng):
    robot, end, read, wanted, _, count = make(p)
    n, between = len(robot["bodies"]), lambda a, b: mpf(str(round(rng.uniform(a, b), 6)))
    t, rates = [between(-0.5, 0.5) for _ in range(n)], [between(-2, 2) for _ in range(n)]
    start, stop = between(-0.4, -0.1), between(0.1, 0.5) if name != "five_link" else end
    matching = [[between(-0.2, 0.2), between(-0.5, 0.5)] for _ in range(count)]
    polynomials = [cubic(start, stop, value, slope) for value, slope in matching]

    def output(i):
        def h(angles):
            phase, controlled = read(angles)
            return controlled[i] - wanted(phase)[i] - polynomials[i](phase)
        return h

    mass, free = dynamics(robot, t, rates)
    drift = lu_solve(mass, free)
    responses = []
    for plus, minus in JOINTS[name]:
        force = matrix(n, 1)
        force[plus], force[minus] = mpf(1), mpf(-1)
        responses.append(lu_solve(mass, force))
    line = lambda by: lambda s: [x + s * b for x, b in zip(t, by)]
    curve = lambda s: [x + s * r + s**2 / 2 * a for x, r, a in zip(t, rates, drift)]
    rows = []
    for i in range(count):
        h = output(i)
        rows.append([h(t), diff(lambda s: h(line(rates)(s)), 0), diff(lambda s: h(curve(s)), 0, 2)]
                    + [diff(lambda s, by=by: h(line(by)(s)), 0) for by in responses])
    joints = lambda x: [x[a] - x[b] for a, b in JOINTS[name]]
    return {
        "robot": name, "gait": gait, "set": {k: float(v) for k, v in p.items()},
        "ends": [float(start), float(stop)], "matching": [[float(x) for x in pair] for pair in matching],
        "q": [float(x) for x in [t[0]] + joints(t)], "v": [float(x) for x in [rates[0]] + joints(rates)],
        "lie_derivatives": [[float(x) for x in row] for row in rows],
    }


def main():
    rng = random.Random(7)
    n = lambda **p: {k: mpf(v) for k, v in p.items()}
    kinds = [
        ("three_link", "thesis", three_link, n(step_length="0.5", torso_lean="-0.5")),
        ("three_link", "thesis", three_link, n(step_length="0.7", torso_lean="0.2")),
        ("three_link", "published", published, {"landing": pi / 8}),
        ("five_link", "thesis", five_link, n(step_length="0.4", torso_lean="0.2", knee="0.3")),
        ("five_link", "thesis", five_link, n(step_length="0.5", torso_lean="0.5", knee="0.1")),
    ]
    cases = [case(name, gait, make, p, rng) for name, gait, make, p in kinds for _ in range(8)]
    print(json.dumps({"generator": "mpmath, 30 digits", "cases": cases}, indent=1))


if __name__ == "__main__":
    main()
