//! Gaits of shipped robots: derivatives of the whole program, what is found from nothing, what is told where nothing is.
use super::constraints::Builder;
use super::*;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{GaitForm, compile_collocation};
use bipedc_compiler::description::gait::{gait_path, read_any_gait};
use bipedc_compiler::description::model::RobotDescription;
use std::path::Path;

pub(super) fn form(robot: &str, gait: &str) -> Collocation {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(robot);
    let robot = Robot::read(&folder).unwrap();
    let file = gait_path(&robot.sources, gait).unwrap();
    let (gait, _) = read_any_gait(&file, &robot.sources, &robot.description).unwrap();
    compile_collocation(&robot.description, &GaitForm::new(&gait, 7)).unwrap()
}

/// Numbers between −1 and 1, the same every time.
fn noise(count: usize) -> Vec<f64> {
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

/// First and second derivatives of the program against central differences of values and of first derivatives, along a direction.
#[test]
fn derivatives_of_all_phases_are_those_of_differences() {
    [Objective::Torque, Objective::Transport].into_iter().for_each(derivatives_are_those_of_differences);
}

fn derivatives_are_those_of_differences(objective: Objective) {
    let of = form("seven_link_v1", "collocated");
    let demands = Demands { intervals: 6, objective, ..Demands::new(0.4) };
    let layout = Layout::new(&of, &[2, 2, 2, 2]);
    let guess = guess::naive(&of, &layout, 0.4, 0);
    let similar = Similarity::new(&of, guess.height);
    let builder = Builder {
        of: &of,
        similar,
        coordinates: &Measure::of_coordinates(&of),
        layout: &layout,
        demands: &demands,
        outputs: true,
        rates: &guess.rates,
        regular: &std::array::from_fn::<_, 4, _>(|_| vec![Some(1.0); 2]),
        parts: &guess.parts,
        height: guess.height,
    };
    let program = Transcription::new(&of, layout.clone(), (builder.rows(), similar), &demands, &guess.x);
    let n = layout.variables;
    let m = program.limits().len();
    let mut x = program.scaled(&guess.x);
    x.iter_mut().zip(noise(n)).for_each(|(x, d)| *x += 0.02 * d);
    let (along, y) = (noise(2 * n).split_off(n), noise(m));
    let moved = |by: f64| x.iter().zip(&along).map(|(x, d)| x + by * d).collect::<Vec<f64>>();
    let step = 1e-6;
    let values = |x: &[f64]| {
        let mut out = vec![0.0; m];
        program.constraints(x, &mut out);
        out
    };
    // Gradient of f + Σ y c.
    let slopes = |x: &[f64]| {
        let mut out = vec![0.0; n];
        program.gradient(x, &mut out);
        let mut jacobian = vec![0.0; program.jacobian_structure().len()];
        program.jacobian(x, &mut jacobian);
        for ([row, column], value) in program.jacobian_structure().into_iter().zip(jacobian) {
            out[column] += y[row] * value;
        }
        out
    };
    let lagrangian =
        |x: &[f64]| program.objective(x) + values(x).iter().zip(&y).map(|(c, y)| c * y).sum::<f64>();
    let (ahead, behind) = (moved(step), moved(-step));
    let difference = (lagrangian(&ahead) - lagrangian(&behind)) / (2.0 * step);
    let slope: f64 = slopes(&x).iter().zip(&along).map(|(g, d)| g * d).sum();
    assert!((difference - slope).abs() < 1e-5 * slope.abs().max(1.0), "{difference} {slope}");
    let mut hessian = vec![0.0; program.hessian_structure().len()];
    program.hessian(&x, 1.0, &y, &mut hessian);
    let mut product = vec![0.0; n];
    for ([i, j], value) in program.hessian_structure().into_iter().zip(hessian) {
        product[i] += value * along[j];
        if i != j {
            product[j] += value * along[i];
        }
    }
    let (ahead, behind) = (slopes(&ahead), slopes(&behind));
    let largest = product.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    for (k, product) in product.iter().enumerate() {
        let difference = (ahead[k] - behind[k]) / (2.0 * step);
        assert!((difference - product).abs() < 1e-5 * largest, "{k}: {difference} {product} of {largest}");
    }
}

/// A robot of the same shape so many times as long and as heavy, under so much more gravity.
fn resized(of: &RobotDescription, [length, mass, gravity]: [f64; 3]) -> RobotDescription {
    let mut found = of.clone();
    found.gravity = found.gravity.map(|x| x * gravity);
    let longer = |xyz: [f64; 3]| xyz.map(|x| x * length);
    for inertial in found.links.iter_mut().filter_map(|link| link.inertial.as_mut()) {
        inertial.mass *= mass;
        inertial.origin.xyz = longer(inertial.origin.xyz);
        inertial.inertia = inertial.inertia.map(|x| x * mass * length * length);
    }
    for joint in &mut found.joints {
        joint.origin.xyz = longer(joint.origin.xyz);
        joint.effort_limit = joint.effort_limit.map(|x| x * mass * gravity * length);
        joint.velocity_limit = joint.velocity_limit.map(|x| x * (gravity / length).sqrt());
    }
    for point in found.feet.iter_mut().flat_map(|foot| &mut foot.points) {
        point.position = longer(point.position);
    }
    found
}

fn alike((name, within): (&str, f64), a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len(), "{name}");
    let largest = a.iter().filter(|x| x.is_finite()).fold(1.0, |a: f64, b| a.max(b.abs()));
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        assert!(a == b || (a - b).abs() < within * largest, "{name} {k}: {a} and {b}");
    }
}

/// The same robot in another size and on another planet is the same program: first guess, bounds, rows with their limits, cost, slopes.
#[test]
fn size_mass_and_gravity_of_a_robot_make_no_other_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/seven_link_v1");
    let robot = Robot::read(&folder).unwrap();
    let file = gait_path(&robot.sources, "collocated").unwrap();
    let (gait, _) = read_any_gait(&file, &robot.sources, &robot.description).unwrap();
    let gait = GaitForm::new(&gait, 7);
    let numbers = |[length, mass, gravity]: [f64; 3], at: Option<&[f64]>| {
        let robot = resized(&robot.description, [length, mass, gravity]);
        let there = GaitForm { gravity: gait.gravity.map(|x| x * gravity), ..gait.clone() };
        let of = compile_collocation(&robot, &there).unwrap();
        let usual = Demands::new(0.4);
        let (force, time, speed) = (mass * gravity, (length / gravity).sqrt(), (length * gravity).sqrt());
        let demands = Demands {
            speed: usual.speed * speed,
            push: usual.push * force,
            zmp: usual.zmp * length,
            clearance: usual.clearance * length,
            impulse: usual.impulse * force * time,
            lift_off: usual.lift_off * speed,
            landing: usual.landing.map(|x| x * speed),
            ..usual
        };
        let layout = Layout::new(&of, &[2, 2, 2, 2]);
        let guess = guess::naive(&of, &layout, demands.speed, 0);
        let similar = Similarity::new(&of, guess.height);
        let builder = Builder {
            of: &of,
            similar,
            coordinates: &Measure::of_coordinates(&of),
            layout: &layout,
            demands: &demands,
            outputs: true,
            rates: &[0.3 * speed; 4],
            regular: &std::array::from_fn::<_, 4, _>(|_| vec![None; 2]),
            parts: &guess.parts,
            height: guess.height,
        };
        let program = Transcription::new(&of, layout.clone(), (builder.rows(), similar), &demands, &guess.x);
        let first = program.scaled(&guess.x);
        let mut x = at.map_or_else(|| first.clone(), <[f64]>::to_vec);
        x.iter_mut().zip(noise(layout.variables)).for_each(|(x, d)| *x += 0.02 * d);
        let mut rows = vec![0.0; program.limits().len()];
        program.constraints(&x, &mut rows);
        let mut slopes = vec![0.0; program.jacobian_structure().len()];
        program.jacobian(&x, &mut slopes);
        let mut second = vec![0.0; program.hessian_structure().len()];
        program.hessian(&x, 1.0, &noise(rows.len()), &mut second);
        let flat = |pairs: Vec<[f64; 2]>| pairs.concat();
        [
            first,
            flat(program.bounds()),
            rows,
            flat(program.limits()),
            vec![program.objective(&x)],
            slopes,
            second,
        ]
    };
    let names = ["first guess", "bounds", "rows", "limits", "cost", "slopes", "second derivatives"];
    let usual = numbers([1.0, 1.0, 1.0], None);
    for size in [[0.4, 0.1, 1.0], [1.8, 4.0, 1.0], [1.0, 1.0, 0.165], [0.5, 0.2, 2.5]] {
        for ((name, a), b) in names.iter().zip(&usual).zip(&numbers(size, Some(&usual[0]))) {
            // Newton's method ends near the postures of the guess.
            let within = if *name == "first guess" { 1e-6 } else { 1e-9 };
            alike((name, within), a, b);
        }
    }
}

/// Where limits do not tell, both knees bend ahead, whichever way round their axes are.
#[test]
fn knees_without_limits_begin_bent_ahead() {
    let mut of = form("five_link", "optimised");
    of.description.joints.iter_mut().for_each(|joint| joint.position_limits = None);
    let knees = |of: &Collocation| -> Vec<f64> {
        let ease = guess::ease(of);
        let joints = of.tree.joints.iter().filter(|joint| joint.name.contains("knee"));
        joints.map(|joint| ease[joint.v_index]).collect()
    };
    assert_eq!(knees(&of), [0.3, 0.3]);
    let right = of.description.joints.iter_mut().find(|joint| joint.name == "right_knee_pitch").unwrap();
    right.axis = right.axis.map(|x| -x);
    assert_eq!(knees(&of), [-0.3, 0.3]);
    // Of limits that leave either way as well.
    of.description.joints.iter_mut().for_each(|joint| joint.position_limits = Some((-3.1, 3.1)));
    assert_eq!(knees(&of), [-0.3, 0.3]);
}

/// From nothing; margins are those asked for, measured again.
#[test]
fn a_five_link_gait_is_found_from_nothing() {
    let of = form("five_link", "optimised");
    let demands = Demands { intervals: 12, ..Demands::new(0.7) };
    let found = from_nothing(&of, &demands, 0, &mut |_, _| true);
    assert_eq!(found.ending, Ending::Minimum, "{:?}", found.violations);
    let margins = found.margins(&of);
    assert!(margins.friction <= 0.5 + 1e-6 && margins.impact_friction.unwrap() <= 0.5 + 1e-6, "{margins:?}");
    assert!(margins.clearance.unwrap() > 0.0119 && margins.push > 4.99, "{margins:?}");
    let duration: f64 = found.durations().iter().sum();
    assert!((found.step_length() / duration - 0.7).abs() < 1e-6);
    assert!(found.drift(&of)[0] < 1e-3, "{:?}", found.drift(&of));
    // A neighbour is found from it in fewer iterations than from nothing.
    let faster = Demands { speed: 0.75, ..demands };
    let again = from_neighbour(&of, &faster, &found, &mut |_, _| true);
    assert_eq!(again.ending, Ending::Minimum);
    assert!(3 * again.iterations < found.iterations, "{} {}", again.iterations, found.iterations);
}

/// Of four phases: begun at the minimum with its multipliers it took 119 iterations, most of them steps of a hundredth and less.
#[test]
#[ignore = "takes long"]
fn a_neighbour_of_four_phases_is_found_in_few_iterations() {
    let of = form("seven_link_v1", "collocated");
    let demands = |speed: f64| Wishes::default().demands(speed, size(&of)).with_reserve();
    let found = from_nothing(&of, &demands(0.4), 0, &mut |_, _| true);
    let again = from_neighbour(&of, &demands(0.42), &found, &mut |_, _| true);
    assert_eq!((found.ending, again.ending), (Ending::Minimum, Ending::Minimum));
    assert!(again.iterations <= 20, "{} {}", again.iterations, found.iterations);
    // It is no worse than that from nothing, which ends in another valley.
    let anew = from_nothing(&of, &demands(0.42), 0, &mut |_, _| true);
    assert!(again.cost <= anew.cost, "{} {}", again.cost, anew.cost);
    // What a library keeps of it is all that the next search needs, to the last bit.
    let kept = Optimum::from_text(&of, &found.to_text()).unwrap();
    assert_eq!(from_neighbour(&of, &demands(0.42), &kept, &mut |_, _| true).x, again.x);
}

/// A step that is too short for its speed: durations are bounded.
#[test]
fn what_cannot_be_is_named_with_its_place() {
    let of = form("five_link", "optimised");
    let demands = Demands { intervals: 6, longest_step: 0.05, ..Demands::new(0.7) };
    let found = from_nothing(&of, &demands, 0, &mut |_, _| true);
    assert!(!matches!(found.ending, Ending::Minimum | Ending::Feasible), "{:?}", found.ending);
    let named = found.violations.iter().any(|(name, by)| {
        ["length of the step", "walking speed"].contains(&name.what.as_str()) && by.abs() > 1e-4
    });
    assert!(named, "{:?}", found.violations);
}
