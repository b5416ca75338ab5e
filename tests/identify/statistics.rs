//! Error bars that hold, estimators that forgive, and what data cannot tell.
use crate::identify::simulated::{CELLS, Noise, Simulated, friction};
use bipedc_analysis::identify::{Estimate, Extra, Method, Settings, Sums, Weighting, essential, fold};

/// Noise that lasts: an autoregressive process with this memory per sample.
const MEMORY: f64 = 0.95;

/// 95 % intervals from repeated experiments with noise that lasts half a second: those of this estimator cover the
/// truth about as often as they say, those of (8.2) far less often.
#[test]
#[ignore = "takes long"]
fn intervals_cover_when_noise_lasts() {
    let robot = Simulated::new("tulip_v1_leg", "fixed");
    let extras = friction(robot.layout.joints.len());
    let design = robot.design(extras.iter().map(|(e, _)| *e).collect());
    let truth = robot.truth(&design, &extras);
    let mut clean = robot.motion(40.0, 11, 1.0);
    robot.measure(&mut clean, &extras, &mut |_| 0.0);
    let (mut own, mut white, mut all) = (0, 0, 0);
    for trial in 0..12 {
        let mut noise = Noise(1000 + trial);
        let mut r = clean.clone();
        for effort in r.effort.iter_mut().flatten() {
            let mut lasting = 0.0;
            for value in effort {
                lasting = MEMORY * lasting + (1.0 - MEMORY * MEMORY).sqrt() * noise.normal();
                *value += 0.3 * lasting;
            }
        }
        let sums = robot.sums(&design, &r);
        let estimate = Estimate::weighted(&design, &sums, truth.map(|_| 0.0), Method::Weighted);
        let fit = estimate.fit(&design, &sums);
        let errors = fit.standard_errors();
        for k in 0..truth.len() {
            let off = (fit.theta[k] - truth[k]).abs();
            own += usize::from(off < 2.09 * errors[k]);
            white += usize::from(off < 1.96 * fit.white[(k, k)].sqrt());
            all += 1;
        }
    }
    let share = |count: usize| count as f64 / all as f64;
    println!("coverage {:.3}, as if independent {:.3}", share(own), share(white));
    assert!((0.92..0.995).contains(&share(own)), "{}", share(own));
    assert!(share(white) < 0.75, "{}", share(white));
}

#[test]
fn every_joint_counts_by_its_own_noise() {
    let robot = Simulated::new("tulip_v1_leg", "fixed");
    let design = robot.design(Vec::new());
    let truth = robot.truth(&design, &[]);
    let mut r = robot.motion(30.0, 5, 1.0);
    let mut noise = Noise(42);
    let last = robot.layout.joints.len() - 1;
    robot.measure(&mut r, &[], &mut |joint| if joint == last { 5.0 } else { 0.02 } * noise.normal());
    let sums = robot.sums(&design, &r);
    let error = |method| {
        let estimate = Estimate::weighted(&design, &sums, truth.map(|_| 0.0), method);
        if method == Method::Weighted {
            assert!(
                (4.5..5.5).contains(&estimate.noise[last]) && (0.018..0.022).contains(&estimate.noise[0])
            );
        }
        (estimate.solve(&estimate.total, &estimate.seen) - &truth).norm()
    };
    let (ordinary, weighted) = (error(Method::Ordinary), error(Method::Weighted));
    println!("ordinary {ordinary:.4}, weighted {weighted:.4}");
    assert!(weighted < 0.2 * ordinary);
}

#[test]
fn huber_forgives_what_least_squares_does_not() {
    let robot = Simulated::new("tulip_v1_leg", "fixed");
    let design = robot.design(Vec::new());
    let truth = robot.truth(&design, &[]);
    let mut r = robot.motion(30.0, 6, 1.0);
    let mut noise = Noise(77);
    // Every fiftieth sample is far off, always to one side.
    let mut count = 0;
    robot.measure(&mut r, &[], &mut |_| {
        count += 1;
        0.05 * noise.normal() + if count % 50 == 0 { 20.0 } else { 0.0 }
    });
    let raw = robot.sums(&design, &r);
    let plain = Estimate::weighted(&design, &raw, truth.map(|_| 0.0), Method::Weighted);
    let mut estimate = Estimate::weighted(&design, &raw, truth.map(|_| 0.0), Method::Weighted);
    let mut scale = estimate.noise.clone();
    for _ in 0..6 {
        let theta = estimate.solve(&estimate.total, &estimate.seen);
        let weighting = Weighting { theta, scale: scale.clone(), bend: 1.345 };
        let mut parts = vec![Sums::new(&design, CELLS)];
        fold(
            &design,
            &r,
            &|t| (t / 30.0 * CELLS as f64) as usize,
            &Settings::default(),
            Some(&weighting),
            &mut parts,
        );
        scale = parts[0].sizes.iter().map(|s| s.median().unwrap() / 0.6745).collect();
        estimate = Estimate::new(&design, &parts[0], &scale, truth.map(|_| 0.0));
    }
    let error = |e: &Estimate| (e.solve(&e.total, &e.seen) - &truth).norm();
    println!("least squares {:.4}, Huber {:.4}, scale {:.4}", error(&plain), error(&estimate), scale[0]);
    assert!(error(&estimate) < 0.1 * error(&plain));
    assert!((0.04..0.08).contains(&scale[0]));
}

/// A joint that stands still tells nothing of its viscous friction, and its dry friction is no offset.
#[test]
fn what_stands_still_is_not_seen() {
    let robot = Simulated::new("tulip_v1_leg", "fixed");
    let joints = robot.layout.joints.len();
    let extras = friction(joints);
    let design = robot.design(extras.iter().map(|(e, _)| *e).collect());
    let mut r = robot.motion(20.0, 9, 1.0);
    let last = joints - 1;
    for i in 0..r.time.len() {
        let k = i * joints + last;
        (r.trajectory.q[k], r.trajectory.v[k], r.trajectory.a[k]) = (0.1, 0.0, 0.0);
    }
    robot.measure(&mut r, &extras, &mut |_| 0.0);
    let sums = robot.sums(&design, &r);
    let truth = robot.truth(&design, &extras);
    let estimate = Estimate::weighted(&design, &sums, truth.clone(), Method::Ordinary);
    let unseen: Vec<&str> = (0..truth.len())
        .filter(|k| !estimate.seen.contains(k))
        .map(|k| design.unknowns[k].name.as_str())
        .collect();
    println!("{unseen:?}");
    let joint = &robot.layout.joints[last].name;
    assert!(unseen.contains(&format!("{joint}.viscous_friction").as_str()));
    assert!(unseen.contains(&format!("{joint}.coulomb_friction").as_str()));
    let theta = estimate.solve(&estimate.total, &estimate.seen);
    assert!((theta - truth).norm() < 1e-8, "with the unseen held at the truth the rest is right");
}

/// Friction that is not there is not essential; what matters is.
#[test]
fn essential_parameters_leave_out_what_is_not_there() {
    let robot = Simulated::new("tulip_v1_leg", "fixed");
    let extras = friction(robot.layout.joints.len());
    let list: Vec<Extra> = extras.iter().map(|(e, _)| *e).collect();
    let design = robot.design(list.clone());
    let mut r = robot.motion(40.0, 13, 1.0);
    let mut noise = Noise(5);
    // Only the first joint has friction.
    let some: Vec<(Extra, f64)> = extras.iter().filter(|(e, _)| e.joint == 0).copied().collect();
    robot.measure(&mut r, &some, &mut |_| 0.1 * noise.normal());
    let sums = robot.sums(&design, &r);
    let estimate = Estimate::weighted(
        &design,
        &sums,
        bipedc_runtime::nalgebra::DVector::zeros(design.unknowns.len()),
        Method::Weighted,
    );
    let folds: Vec<usize> = (0..CELLS).map(|cell| cell * 4 / CELLS).collect();
    let found = essential(&estimate, &design, &sums, &folds);
    let kept = |extra: &Extra| {
        let name = extra.name(&robot.layout);
        found.unknowns.iter().any(|&k| design.unknowns[k].name == name)
    };
    println!("{} of {}", found.unknowns.len(), design.unknowns.len());
    assert!(list.iter().filter(|e| e.joint == 0).all(kept));
    assert!(list.iter().filter(|e| e.joint != 0 && kept(e)).count() <= 2);
    assert!(found.held_out[1].relative() <= 1.02 * found.held_out[0].relative());
}
