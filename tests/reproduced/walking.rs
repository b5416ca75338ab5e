//! Section 8.4.1: statically stable walking.
use super::trials::tulip_file;
use super::walked::Walked;
use super::{gait, run};

#[test]
#[ignore = "takes long"]
fn two_steps_ahead_are_walked_as_wished() {
    // The left foot steps from 2.5 s to 4 s, the right one from 5.5 s to 7 s.
    let trial = run("forward", 1e-3, 7.3);
    let steps = gait::forward(6, 0.08);
    let found = Walked::of(&trial, &gait::trajectory(&steps).unwrap().wished);
    println!("{found:#?}");
    assert_eq!(found.steps, [1, 1]);
    assert!(found.joints.iter().all(|joint| joint.rms < 0.015 && joint.largest < 0.06), "{found:?}");
    assert!(found.moved[0] > 0.08, "{found:?}");
    // The torso stays upright.
    assert!(
        found.roll.iter().chain(&found.pitch).all(|x| x.abs() < 0.05) && found.yaw.abs() < 0.02,
        "{found:?}"
    );
}

#[test]
fn shipped_trajectories_are_those_of_the_gaits() {
    let gaits = [
        ("forward", gait::forward(6, 0.08)),
        ("sideways", gait::sideways(6, 0.06)),
        ("turning", gait::turning(6, 15.0_f64.to_radians())),
    ];
    for (name, steps) in gaits {
        let shipped = std::fs::read_to_string(tulip_file(&format!("scenarios/{name}.csv"))).unwrap();
        let made = gait::trajectory(&steps).unwrap().text;
        assert_eq!(shipped.lines().count(), made.lines().count(), "{name}");
        for (a, b) in shipped.lines().zip(made.lines()).skip(1) {
            let numbers = |line: &str| line.split(',').map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>();
            // Rounded to a microradian.
            let apart = numbers(a).iter().zip(numbers(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1.5e-6, "{name}: {a}\n{b}");
        }
    }
}
