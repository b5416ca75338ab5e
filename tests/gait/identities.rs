//! What holds whatever the numbers are.
use super::{bent, gait};
use bipedc_analysis::gait::{Course, GaitModel};

/// Gaits with values of their parameters.
const GAITS: [(&str, &[f64]); 4] = [
    ("robots/three_link", &[0.5, -0.5]),
    ("robots/three_link", &[0.9, 0.3]),
    ("robots/five_link", &[0.4, 0.2, 0.3]),
    ("robots/five_link", &[0.6, -0.2, 0.6]),
];

fn on_each(check: impl Fn(&str, &GaitModel<'_>, &Course<'_, '_>)) {
    for (folder, values) in GAITS {
        let bench = gait(folder, "thesis");
        let model = bench.model().unwrap();
        let course = model.steady_course(values).unwrap();
        check(folder, &model, &course);
    }
    let bench = bent();
    let model = bench.model().unwrap();
    check("bent", &model, &model.steady_course(&[0.5, -0.5]).unwrap());
}

fn phases(course: &Course<'_, '_>, count: usize) -> Vec<f64> {
    let [start, end] = course.ends();
    (0..=count).map(|k| start + (end - start) * k as f64 / count as f64).collect()
}

/// σ = α φ̇ changes by −γ alone (6.7): then β is the slope of α.
#[test]
fn beta_is_the_slope_of_alpha() {
    on_each(|folder, _, course| {
        let [start, end] = course.ends();
        let h = 1e-4 * (end - start);
        let mut worst = 0.0_f64;
        for phase in phases(course, 12) {
            let alpha = |k: f64| course.zero_dynamics(phase + k * h).unwrap()[0];
            let slope = (8.0 * (alpha(1.0) - alpha(-1.0)) - (alpha(2.0) - alpha(-2.0))) / (12.0 * h);
            worst = worst.max((course.zero_dynamics(phase).unwrap()[1] - slope).abs());
        }
        println!("{folder}: β is the slope of α within {worst:.1e}");
        assert!(worst < 1e-6, "{folder}: {worst:e}");
    });
}

/// T′ and T″ are the slopes of T and T′.
#[test]
fn slopes_of_the_surface_are_slopes() {
    on_each(|folder, model, course| {
        let [start, end] = course.ends();
        let h = 1e-4 * (end - start);
        for phase in phases(course, 12) {
            let at = |k: f64| course.surface(phase + k * h).unwrap();
            let [a, b, c, d] = [1.0, -1.0, 2.0, -2.0].map(at);
            let here = course.surface(phase).unwrap();
            let slope = |of: [f64; 4]| (8.0 * (of[0] - of[1]) - (of[2] - of[3])) / (12.0 * h);
            for k in 0..model.size() {
                let first = slope([a.q[k], b.q[k], c.q[k], d.q[k]]);
                let second = slope([a.slope[k], b.slope[k], c.slope[k], d.slope[k]]);
                assert!((here.slope[k] - first).abs() < 1e-8, "{folder}: T'[{k}]");
                assert!((here.curvature[k] - second).abs() < 1e-6, "{folder}: T''[{k}]");
            }
        }
    });
}

/// The closed form and Newton's method find the same surface.
#[test]
fn iteration_finds_the_closed_form() {
    on_each(|folder, model, course| {
        let iterating = model.clone().iterating();
        for phase in phases(course, 12) {
            let arguments = course.arguments(phase);
            let closed = course.surface(phase).unwrap();
            let found = iterating.surface(&arguments, &vec![0.0; model.size()]).unwrap();
            let pairs =
                [(&closed.q, &found.q), (&closed.slope, &found.slope), (&closed.curvature, &found.curvature)];
            for (a, b) in pairs {
                let worst = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(worst < 1e-11, "{folder} at {phase}: {worst:e}");
            }
        }
    });
}

/// No torque reaches the turn about the foot: the base's moment is that of the force on the foot, and the foot does not move.
#[test]
fn the_force_on_the_foot_carries_the_base() {
    on_each(|folder, model, course| {
        let energy = course.p_max.max(0.0) + 300.0;
        for phase in phases(course, 12) {
            let point = course.surface(phase).unwrap();
            let efforts = model.efforts(course, phase, energy).unwrap();
            // The foot is at the origin; pitch about +y of a force there is −(z − z_b) x… about the base.
            let (x, z) = (point.q[0], point.q[1]);
            let moment = -z * efforts[0] + x * efforts[1];
            assert!(
                (efforts[2] - moment).abs() < 1e-10 * 500.0,
                "{folder} at {phase}: {} {moment}",
                efforts[2]
            );
        }
    });
}

/// Energy along the solution of (6.6), integrated by itself, stays what it was (6.12).
#[test]
fn energy_is_conserved_along_a_step() {
    on_each(|folder, _, course| {
        let energy = course.p_max.max(0.0) + 400.0;
        let [start, end] = course.ends();
        let acceleration = |x: [f64; 2]| {
            let [alpha, beta, gamma] = course.zero_dynamics(x[0]).unwrap();
            [x[1], -(beta * x[1] * x[1] + gamma) / alpha]
        };
        let mut x = [start, course.rates(start, energy).unwrap()[0]];
        let h = 2e-4;
        let plus = |a: [f64; 2], b: [f64; 2], s: f64| [a[0] + s * b[0], a[1] + s * b[1]];
        let mut steps = 0;
        while x[0] < end - 0.01 {
            let k1 = acceleration(x);
            let k2 = acceleration(plus(x, k1, h / 2.0));
            let k3 = acceleration(plus(x, k2, h / 2.0));
            let k4 = acceleration(plus(x, k3, h));
            for i in 0..2 {
                x[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
            }
            steps += 1;
            if steps % 50 == 0 {
                let own = 0.5 * (course.zero_dynamics(x[0]).unwrap()[0] * x[1]).powi(2)
                    + course.potential(x[0]).unwrap();
                assert!((own - energy).abs() < 1e-9 * energy, "{folder} at {}: {own} {energy}", x[0]);
            }
        }
        assert!(steps > 500, "{steps}");
    });
}

/// After the impact the outputs and their rates vanish: the state is q = T(φ₊), q̇ = T′ φ̇₊, and its momentum α φ̇₊.
#[test]
fn the_impact_leads_back_onto_the_surface() {
    on_each(|folder, _, course| {
        let landing = &course.landing;
        let point = course.surface(course.start).unwrap();
        // Where the foot was before, it is not the origin that stands.
        for k in 2..point.q.len() {
            assert!((point.q[k] - landing.q[k]).abs() < 1e-13, "{folder}: q[{k}]");
            assert!((point.slope[k] * landing.eta - landing.v[k]).abs() < 1e-12, "{folder}: v[{k}]");
        }
        let alpha = course.zero_dynamics(course.start).unwrap()[0];
        assert!((alpha * landing.eta - landing.momentum_after).abs() < 1e-11, "{folder}");
        let delta = (landing.eta * alpha / landing.momentum_before).powi(2);
        assert!((delta - landing.delta).abs() < 1e-13, "{folder}");
    });
}

/// (6.16), (6.17): many steps with the same parameters end at the limit speed.
#[test]
#[ignore = "takes long"]
fn many_steps_reach_the_limit_speed() {
    let bench = gait("robots/three_link", "thesis");
    let model = bench.model().unwrap();
    let mut speed = 3.0;
    let limit = model.step(&[0.5, -0.5], &[0.5, -0.5], speed).limit_speed.unwrap();
    for _ in 0..150 {
        speed = model.step(&[0.5, -0.5], &[0.5, -0.5], speed).next_speed.unwrap();
    }
    assert!((speed - limit).abs() < 1e-12, "{speed} {limit}");
}
