//! Parameters that bodies can have.
use crate::identify::simulated::{CELLS, Noise, Simulated, friction};
use bipedc_analysis::identify::physical::{Bound, Bounds, Links, Physical, Problem, choose, problem};
use bipedc_analysis::identify::{Design, Estimate, Extra, HeldOutError, Method, Summand, by_channel, errors};
use bipedc_analysis::robot::LinkInertias;
use bipedc_runtime::nalgebra::{DVector, Matrix3, Vector3};

/// CAD that is off: masses by 20 %, centres by a centimetre, inertias with the masses and 10 % more.
fn drawn(truth: &LinkInertias) -> LinkInertias {
    let mut noise = Noise(31);
    let mut cad = truth.clone();
    for link in &mut cad.links {
        let factor = 0.8 + 0.4 * noise.even();
        link.mass *= factor;
        link.inertia = link.inertia.map(|row| row.map(|x| 1.1 * factor * x));
        link.center = link.center.map(|c| c + 0.02 * (noise.even() - 0.5));
    }
    cad
}

/// Principal moments from the characteristic polynomial: not the way of the library's own check.
fn possible(mass: f64, inertia: &Matrix3<f64>) -> bool {
    let second = Matrix3::identity() * (0.5 * inertia.trace()) - inertia;
    // Sylvester: all leading minors positive.
    let minors = [
        second[(0, 0)],
        second[(0, 0)] * second[(1, 1)] - second[(0, 1)] * second[(1, 0)],
        second.determinant(),
    ];
    mass > 0.0 && minors.iter().all(|minor| *minor > 0.0)
}

/// Unknowns that are sums of masses and moments of inertia with positive factors: no robot has a negative one.
fn impossible(design: &Design<'_>, theta: &DVector<f64>) -> Vec<String> {
    let positive = |sum: &[(Summand, f64)]| {
        sum.iter().all(|(part, factor)| {
            let own = matches!(part, Summand::Inertial(k) if [0, 4, 7, 9].contains(&(k % 10)));
            own && *factor > 0.0
        })
    };
    let all = design.unknowns.iter().enumerate();
    all.filter(|(k, u)| positive(&u.sum) && theta[*k] < 0.0).map(|(_, u)| u.name.clone()).collect()
}

fn total(errors: &[HeldOutError]) -> f64 {
    errors.iter().fold(HeldOutError::default(), |sum, e| sum.plus(e)).relative()
}

#[test]
fn noisy_data_give_bodies_that_can_be_and_predict_as_well() {
    let robot = Simulated::new("tulip", "fixed");
    let extras = friction(robot.layout.joints.len());
    let list: Vec<Extra> = extras.iter().map(|(e, _)| *e).collect();
    let design = robot.design(list);
    let cad = drawn(&robot.link_inertias);
    let mut noise = Noise(2024);
    let (mut train, mut judge) = (robot.motion(20.0, 21, 0.3), robot.motion(20.0, 22, 0.5));
    robot.measure(&mut train, &extras, &mut |_| 0.5 * noise.normal());
    robot.measure(&mut judge, &extras, &mut |_| 0.5 * noise.normal());
    let (sums, judged) = (robot.sums(&design, &train), robot.sums(&design, &judge));
    let estimate =
        Estimate::weighted(&design, &sums, DVector::zeros(design.unknowns.len()), Method::Weighted);
    let theta = estimate.solve(&estimate.total, &estimate.seen);
    let negative = impossible(&design, &theta);
    println!("least squares has negative: {negative:?}");
    assert!(!negative.is_empty(), "the data are too good for this test");
    let (links, bounds) = (Links::new(&cad), Bounds::default());
    let problem = problem(&design, &links, &bounds);
    let folds: Vec<usize> = (0..CELLS).map(|cell| cell * 2 / CELLS).collect();
    let choice = choose(&problem, &design, &sums, &estimate, &folds, &|_| ()).unwrap();
    let found = problem.solve(&estimate.total.least_squares(), choice.weight).unwrap();
    for (body, x) in links.bodies.iter().zip(found.coordinates.chunks_exact(10)) {
        let inertia = body.inertia(x);
        assert!(possible(inertia.mass, &inertia.inertia), "{}: {inertia:?}", body.name);
    }
    let channels = by_channel(&judged, &design, &|_| true);
    let of = |theta: &DVector<f64>| total(&errors(&channels, &design, theta));
    let (free, kept) = (of(&theta), of(&found.theta));
    println!("held out: least squares {free:.4}, possible {kept:.4}, weight {}", choice.weight);
    assert!(kept <= 1.05 * free);
    assert!(impossible(&design, &found.theta).is_empty());
}

/// A small arm with noise, so much that conditions bind.
fn arm() -> (Simulated, Vec<(Extra, f64)>) {
    let robot = Simulated::new("tulip_v1_leg", "fixed");
    let extras = friction(robot.layout.joints.len());
    (robot, extras)
}

fn with_problem(noise: f64, bounds: &[Bound], judge: impl Fn(&Problem<'_>, &Estimate, &Design<'_>)) {
    let (robot, extras) = arm();
    let design = robot.design(extras.iter().map(|(e, _)| *e).collect());
    let mut r = robot.motion(20.0, 8, 0.4);
    let mut random = Noise(99);
    robot.measure(&mut r, &extras, &mut |_| noise * random.normal());
    let sums = robot.sums(&design, &r);
    let estimate =
        Estimate::weighted(&design, &sums, DVector::zeros(design.unknowns.len()), Method::Weighted);
    let cad = drawn(&robot.link_inertias);
    let links = Links::new(&cad);
    let bounds = Bounds::new(bounds, &links).unwrap();
    judge(&problem(&design, &links, &bounds), &estimate, &design);
}

/// Value of what is minimised, computed here.
fn objective(estimate: &Estimate, found: &Physical, weight: f64) -> f64 {
    let data = estimate.total.squares(&found.theta) / estimate.total.rows() as f64;
    data + weight * found.coordinates.iter().map(|x| x * x).sum::<f64>()
}

#[test]
fn the_certificate_proves_the_optimum() {
    with_problem(10.0, &[], |problem, estimate, _| {
        let mut bound = 0;
        for weight in [1e-6, 1e-4, 1e-2, 1.0] {
            let found = problem.solve(&estimate.total.least_squares(), weight).unwrap();
            let c = found.certificate;
            println!("weight {weight}: {c:?}");
            assert!(c.gap.abs() < 1e-6 && c.residual < 1e-6);
            bound += usize::from(c.iterations > 0);
            assert!((c.objective - objective(estimate, &found, weight)).abs() < 1e-9 * c.objective);
            // Nobody finds better: not the neighbours that keep the conditions.
            let mut random = Noise(7);
            for _ in 0..50 {
                let mut other = found.clone();
                let factor = 1.0 - 0.01 * random.even();
                // Towards CAD every condition stays kept: the set is convex and CAD lies in it.
                other.coordinates.iter_mut().for_each(|x| *x *= factor);
                let x = DVector::from_iterator(
                    other.coordinates.len() + other.extras.len(),
                    other.coordinates.iter().chain(&other.extras).copied(),
                );
                let away =
                    DVector::from_iterator(x.len(), found.coordinates.iter().chain(&found.extras).copied());
                other.theta = &found.theta + problem.slopes() * (x - away);
                assert!(objective(estimate, &other, weight) >= c.bound * (1.0 - 1e-12));
            }
        }
        assert!(bound >= 2, "conditions hardly bind");
    });
}

#[test]
fn a_heavy_prior_gives_the_description_and_a_light_one_the_data() {
    with_problem(0.01, &[], |problem, estimate, _| {
        let near = problem.solve(&estimate.total.least_squares(), 1e9).unwrap();
        assert!(near.coordinates.iter().all(|x| x.abs() < 1e-3));
        let far = problem.solve(&estimate.total.least_squares(), 1e-9).unwrap();
        let theta = estimate.solve(&estimate.total, &estimate.seen);
        let excess = estimate.total.squares(&far.theta) / estimate.total.squares(&theta);
        assert!(excess < 1.01, "{excess}");
    });
}

#[test]
fn the_weight_on_the_scales_and_a_box_are_kept() {
    let (robot, _) = arm();
    let name = robot.link_inertias.links.iter().find(|l| l.mass > 0.0).unwrap().name.clone();
    let cad: f64 = drawn(&robot.link_inertias).links.iter().map(|l| l.mass).sum();
    let high = [0.01, 0.01, -0.01];
    let low = [-0.01, -0.01, -0.1];
    let bounds = [Bound::TotalMass(0.9 * cad), Bound::Center { link: name.clone(), low, high }];
    with_problem(0.5, &bounds, |problem, estimate, _| {
        let found = problem.solve(&estimate.total.least_squares(), 0.1).unwrap();
        let inertias: Vec<_> = problem
            .links
            .bodies
            .iter()
            .zip(found.coordinates.chunks_exact(10))
            .map(|(body, x)| (body.name.clone(), body.inertia(x)))
            .collect();
        let mass: f64 = inertias.iter().map(|(_, i)| i.mass).sum();
        assert!((mass - 0.9 * cad).abs() < 1e-6, "{mass} {}", 0.9 * cad);
        let center: Vector3<f64> = inertias.iter().find(|(n, _)| *n == name).unwrap().1.center;
        for axis in 0..3 {
            assert!((low[axis] - 1e-6..high[axis] + 1e-6).contains(&center[axis]), "{center}");
        }
        assert!(inertias.iter().all(|(_, i)| possible(i.mass, &i.inertia)));
        assert!(found.certificate.gap.abs() < 1e-6);
    });
}

#[test]
fn left_equals_right() {
    let robot = Simulated::new("tulip", "fixed");
    let pairs: Vec<(String, String)> = robot
        .link_inertias
        .links
        .iter()
        .filter(|l| l.mass > 0.0 && l.name.contains("left"))
        .map(|l| (l.name.clone(), l.name.replace("left", "right")))
        .collect();
    assert!(!pairs.is_empty());
    let design = robot.design(Vec::new());
    let mut r = robot.motion(10.0, 8, 0.5);
    let mut random = Noise(99);
    robot.measure(&mut r, &[], &mut |_| 0.5 * random.normal());
    let sums = robot.sums(&design, &r);
    let estimate =
        Estimate::weighted(&design, &sums, DVector::zeros(design.unknowns.len()), Method::Weighted);
    let links = Links::new(&robot.link_inertias);
    let mirror =
        |(left, right): &(String, String)| Bound::Mirror { left: left.clone(), right: right.clone() };
    let bounds = Bounds::new(&pairs.iter().map(mirror).collect::<Vec<_>>(), &links).unwrap();
    let problem = problem(&design, &links, &bounds);
    let found = problem.solve(&estimate.total.least_squares(), 0.01).unwrap();
    let of = |name: &str| {
        let k = links.bodies.iter().position(|b| b.name == name).unwrap();
        links.bodies[k].inertia(&found.coordinates[10 * k..10 * k + 10])
    };
    assert!(found.coordinates.iter().any(|x| x.abs() > 1e-3), "nothing was learnt");
    for (left, right) in &pairs {
        let (a, b) = (of(left), of(right));
        assert!((a.mass - b.mass).abs() < 1e-6, "{left}: {} {}", a.mass, b.mass);
        let turned = Vector3::new(b.center.x, -b.center.y, b.center.z);
        assert!((a.center - turned).norm() < 1e-6, "{left}");
    }
}

#[test]
fn bounds_that_cannot_be_are_refused() {
    let (robot, _) = arm();
    let links = Links::new(&robot.link_inertias);
    let refused = |bound: Bound| Bounds::new(&[bound], &links).unwrap_err().message;
    assert!(refused(Bound::TotalMass(-1.0)).contains("total mass"));
    let low = [0.1, 0.0, 0.0];
    let name = links.bodies[0].name.clone();
    assert!(refused(Bound::Center { link: name.clone(), low, high: [0.0; 3] }).contains("centre of mass"));
    assert!(refused(Bound::Mirror { left: name, right: "nobody".to_owned() }).contains("`nobody`"));
}
