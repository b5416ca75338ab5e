//! TUlip walks by itself, undisturbed and disturbed, and is pushed: how often it stays on its feet.
//!
//! `cargo run --release --example tulip_walks [TRIALS]` prints Markdown tables; every number follows from the seeds, which count from 0.
use bipedc::simulation::{FootstepSummary, Options, wilson};
use bipedc::{Diagnostics, Workbench};
use std::fs;
use std::path::Path;

/// What sensors of today do, all of them unknown to the controller.
const SENSORS: &str = "\
[sensors]
position_noise = 1e-4
velocity_noise = 0.01
force_noise = 1.0
[imu]
acceleration_noise = 0.1
angular_velocity_noise = 0.005
acceleration_bias = [0.1, -0.05, 0.1]
angular_velocity_bias = [0.01, -0.01, 0.005]
";

/// 3°, along x and across.
const SLOPES: [&str; 2] = [
    "[[effect]]\nkind = \"ground_slope\"\nroll = 0.0\npitch = 0.0524\n",
    "[[effect]]\nkind = \"ground_slope\"\nroll = 0.0524\npitch = 0.0\n",
];

fn main() {
    let trials = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(100);
    if let Err(errors) = walks().and_then(|()| pushes(trials)) {
        eprintln!("{errors}");
        std::process::exit(1);
    }
}

/// Play of 1° in both ankles, about either axis.
fn play() -> String {
    let joints = ["left_ankle_pitch", "left_ankle_roll", "right_ankle_pitch", "right_ankle_roll"];
    let motor =
        |joint: &&str| format!("[motor.{joint}]\ngear_ratio = 50.0\nrotor_inertia = 1e-5\ngap = 0.01745\n");
    joints.iter().map(motor).collect()
}

/// 5 % of the robot's mass more, so far (m) ahead in the torso.
fn heavier(ahead: f64) -> String {
    format!("[[effect]]\nkind = \"payload\"\nlink = \"torso\"\nmass = 1.0\nx = {ahead}\ny = 0.0\nz = 0.1\n")
}

/// A walk of so many seconds at a velocity.
fn walk(
    seconds: f64,
    velocity: &str,
    measured: bool,
    more: &str,
    seed: usize,
) -> Result<FootstepSummary, Diagnostics> {
    let folder = Path::new("target/tulip_walks");
    fs::create_dir_all(folder).expect("target/ can be written");
    let [file, log] =
        ["toml", "csv"].map(|end| folder.join(format!("{:?}.{end}", std::thread::current().id())));
    let (state, sensors) = if measured { ("state = \"measured\"\n", SENSORS) } else { ("", "") };
    let text = format!(
        "duration = {seconds}\nlog_step = 0.1\nseed = {seed}\n[walking]\n{state}velocity = [{{ time = 0.5, {velocity} }}]\n{sensors}{more}"
    );
    fs::write(&file, text).expect("target/ can be written");
    let robot = Workbench::open("robots/tulip")?;
    let run = robot.simulate(&robot.scene(&file)?, log, &Options::default())?;
    Ok(run.walk.unwrap_or_default())
}

fn walks() -> Result<(), Diagnostics> {
    let (play, heavy) = (play(), [0.0, 0.05].map(heavier));
    let forward = "forward = 0.3";
    let rows = [
        ("forward, 0.3 m/s", forward, ""),
        ("forward, 0.4 m/s", "forward = 0.4", ""),
        ("forward, 0.5 m/s", "forward = 0.5", ""),
        ("backward, 0.2 m/s", "forward = -0.2", ""),
        ("to the side, 0.05 m/s", "left = 0.05", ""),
        ("to the side, 0.1 m/s", "left = 0.1", ""),
        ("on the spot, turning by 0.4 rad/s", "turning = 0.4", ""),
        ("curve, 0.25 m/s and 0.3 rad/s", "forward = 0.25, turning = 0.3", ""),
        ("forward, 1° of play in the ankles", forward, play.as_str()),
        ("forward, 1 kg more than known at the torso", forward, heavy[0].as_str()),
        ("forward, 1 kg more than known, 50 mm ahead", forward, heavy[1].as_str()),
        ("forward, 3° slope along the way", forward, SLOPES[0]),
        ("backward, 0.2 m/s, 3° slope along the way", "forward = -0.2", SLOPES[0]),
        ("forward, 3° slope across the way", forward, SLOPES[1]),
        ("curve, 3° slope", "forward = 0.25, turning = 0.3", SLOPES[0]),
    ];
    println!("| 60 s | true state | measured state |\n|---|---|---|");
    for (words, velocity, more) in rows {
        let [exact, measured] = [false, true].map(|measured| walk(60.0, velocity, measured, more, 0));
        println!("| {words} | {} | {} |", told(&exact?), told(&measured?));
    }
    Ok(())
}

fn told(walk: &FootstepSummary) -> String {
    match walk.fell {
        None => format!("{} steps, {:.2} m", walk.steps, walk.distance),
        Some(time) => format!("falls at {time:.1} s, {} steps", walk.steps),
    }
}

/// Pushes on the torso for 0.1 s at random instants of a step.
fn pushes(trials: usize) -> Result<(), Diagnostics> {
    println!("\n| push | survives, true state | survives, measured state |\n|---|---|---|");
    let ways = [("forward", 0.0), ("back", 180.0), ("to the left", 90.0), ("to the right", -90.0)];
    for (words, degrees) in ways {
        for impulse in [4.0, 5.0, 7.0] {
            let cells =
                [false, true].map(|measured| survived(impulse, f64::to_radians(degrees), measured, trials));
            let cells = cells.into_iter().collect::<Result<Vec<_>, _>>()?;
            println!("| {words}, {impulse} N s | {} |", cells.join(" | "));
        }
    }
    Ok(())
}

/// How many of the trials, with the interval of Wilson at 95 %.
fn survived(impulse: f64, direction: f64, measured: bool, trials: usize) -> Result<String, Diagnostics> {
    let one = |seed: usize| {
        // Spread over a pair of steps.
        let time = 3.0 + 1.2 * (seed as f64 + 0.5) / trials as f64;
        let push = format!("[[push]]\ntime = {time}\nimpulse = {impulse}\ndirection = {direction}\n");
        walk(7.5, "forward = 0.2", measured, &push, seed).map(|walk| usize::from(walk.fell.is_none()))
    };
    let part = |first: usize| (first..trials).step_by(2).map(one).sum::<Result<usize, Diagnostics>>();
    let (even, odd) = std::thread::scope(|scope| {
        let odd = scope.spawn(|| part(1));
        (part(0), odd.join().expect("a walk does not panic"))
    });
    let survived = even? + odd?;
    let [low, high] = wilson(survived, trials);
    Ok(format!("{survived} of {trials} ({:.0} to {:.0} %)", 100.0 * low, 100.0 * high))
}
