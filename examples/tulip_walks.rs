//! TUlip walks by itself, undisturbed and disturbed, and is pushed: how often it stays on its feet.
//!
//! `cargo run --release --example tulip_walks [TRIALS] [TABLE…]` prints Markdown tables, all or those of `walks`, `together`, `ground`, `payloads`,
//! `pushes`, `limits`; every number follows from the seeds, which count from 0. TRIALS are those of each push; of the others' rows `ground`, `payloads`
//! and `together` have eight, `walks` one.
use bipedc::simulation::{EstimateErrors, FootstepSummary, Options, wilson};
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

/// Steps of 3 s, for half of which both feet stand: slow enough that the centre of mass is over the sole that stands alone.
const SLOW_STEPS: &str = "step_height = 0.03\nmargin = 0.015\nstep_time = 3.0\ndouble_support = 0.5\n";

/// Of a table.
type Outcome = Result<(), Diagnostics>;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let trials = words.iter().find_map(|word| word.parse().ok()).unwrap_or(100);
    let chosen: Vec<&String> = words.iter().filter(|word| word.parse::<usize>().is_err()).collect();
    let pushes = || pushes(trials);
    let tables: [(&str, &dyn Fn() -> Outcome); 6] = [
        ("walks", &walks),
        ("together", &together),
        ("ground", &ground),
        ("payloads", &payloads),
        ("pushes", &pushes),
        ("limits", &limits),
    ];
    for (name, table) in tables {
        let wanted = chosen.is_empty() || chosen.iter().any(|word| *word == name);
        if let Err(errors) = if wanted { table() } else { Ok(()) } {
            eprintln!("{errors}");
            std::process::exit(1);
        }
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

/// How a walk went; none where the simulation broke off.
type Walk = Option<FootstepSummary>;

/// A walk of so many seconds at a velocity.
fn walk(seconds: f64, velocity: &str, measured: bool, more: &str, seed: usize) -> Result<Walk, Diagnostics> {
    let keys = if measured { "state = \"measured\"\n" } else { "" };
    walk_with((seconds, seed), velocity, keys, &format!("{}{more}", if measured { SENSORS } else { "" }))
}

/// The same with keys of `[walking]`, sensors among what is more.
fn walk_with(
    (seconds, seed): (f64, usize),
    velocity: &str,
    keys: &str,
    more: &str,
) -> Result<Walk, Diagnostics> {
    let folder = Path::new("target/tulip_walks");
    fs::create_dir_all(folder).expect("target/ can be written");
    let [file, log] =
        ["toml", "csv"].map(|end| folder.join(format!("{:?}.{end}", std::thread::current().id())));
    let text = format!(
        "duration = {seconds}\nlog_step = 0.1\nseed = {seed}\n[walking]\n{keys}velocity = [{{ time = 0.5, {velocity} }}]\n{more}"
    );
    fs::write(&file, text).expect("target/ can be written");
    let robot = Workbench::open("robots/tulip")?;
    match robot.simulate(&robot.scene(&file)?, log, &Options::default()) {
        Ok(run) => {
            let fell = run.fell();
            Ok(Some(FootstepSummary { fell, ..run.walk.unwrap_or_default() }))
        }
        Err(errors) => {
            eprintln!("{velocity}, seed {seed}: {errors}");
            Ok(None)
        }
    }
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
    println!("| 70 s | true state | measured state |\n|---|---|---|");
    for (words, velocity, more) in rows {
        let [exact, measured] = [false, true].map(|measured| walk(70.0, velocity, measured, more, 0));
        println!("| {words} | {} | {} |", told(&exact?), told(&measured?));
    }
    let file = Path::new("target/tulip_walks/slow_steps.toml");
    fs::write(file, SLOW_STEPS).expect("target/ can be written");
    let slow = |keys: &str, more: &str| {
        walk_with((325.0, 0), "forward = 0.02", &format!("{keys}settings = \"slow_steps.toml\"\n"), more)
    };
    let [exact, measured] = [slow("", "")?, slow("state = \"measured\"\n", SENSORS)?];
    println!("| forward, static: 0.02 m/s for 325 s | {} | {} |", told(&exact), told(&measured));
    Ok(())
}

fn told(walk: &Walk) -> String {
    let Some(walk) = walk else { return "the simulation breaks off".to_owned() };
    match walk.fell {
        None => format!("{} steps, {:.2} m", walk.steps, walk.distance),
        Some(time) => format!("falls at {time:.1} s, {} steps", walk.steps),
    }
}

/// Everything at once: noise and biases of the sensors, 1° of play in both ankles, 5 % of the mass more or less than known, readings 2 ms late; at least
/// a hundred steps.
fn together() -> Result<(), Diagnostics> {
    let gaits = [
        ("forward, 0.3 m/s", "forward = 0.3"),
        ("backward, 0.2 m/s", "forward = -0.2"),
        ("to the side, 0.1 m/s", "left = 0.1"),
        ("on the spot, turning by 0.4 rad/s", "turning = 0.4"),
        ("curve, 0.25 m/s and 0.3 rad/s", "forward = 0.25, turning = 0.3"),
        ("forward, 0.4 m/s", "forward = 0.4"),
    ];
    println!(
        "\n| 70 s, everything at once | 5 % heavier than known | 5 % lighter than known |\n|---|---|---|"
    );
    for (words, velocity) in gaits {
        let cells = [0.95, -0.95].map(|mass| {
            let mass =
                format!("[[effect]]\nkind = \"inertial_correction\"\nlink = \"torso\"\nmass = {mass}\n");
            let more = format!("{SENSORS}{}{mass}", play());
            let keys = "state = \"measured\"\ndelay = 0.002\n";
            each(8, |seed| walk_with((70.0, seed), velocity, keys, &more)).map(|all| counted(&all))
        });
        let [heavier, lighter] = cells;
        println!("| {words} | {} | {} |", heavier?, lighter?);
    }
    Ok(())
}

/// Ground that nobody told the controller of.
fn ground() -> Result<(), Diagnostics> {
    let kinds = [
        ("level", String::new()),
        ("footholds of ±10 mm", "[ground.heights]\nkind = \"footholds\"\nheight = 0.01\n".to_owned()),
        ("tiles of ±10 mm", "[ground.heights]\nkind = \"tiles\"\nheight = 0.01\n".to_owned()),
        ("waves of ±10 mm", "[ground.heights]\nkind = \"waves\"\nheight = 0.01\n".to_owned()),
        ("level, 1° of play in the ankles", play()),
    ];
    println!(
        "\n| 64 s forward, 0.3 m/s, measured state | walks | estimate along the ground, median and worst | up | tilt | heading |\n|---|---|---|---|---|---|"
    );
    for (words, more) in kinds {
        let all = each(8, |seed| walk(64.0, "forward = 0.3", true, &more, seed))?;
        let found = |of: fn(&EstimateErrors) -> f64, by: f64| {
            let mut all: Vec<f64> =
                all.iter().flatten().filter_map(|walk| walk.estimated.as_ref()).map(|e| by * of(e)).collect();
            all.sort_by(f64::total_cmp);
            let middle = 0.5 * (all[(all.len() - 1) / 2] + all[all.len() / 2]);
            format!("{middle:.3} and {:.3}", all[all.len() - 1])
        };
        let (mm, degrees) = (1e3, 1.0_f64.to_degrees());
        println!(
            "| {words} | {} | {} mm | {} mm | {}° | {}° |",
            counted(&all),
            found(|e| e.along_ground, mm),
            found(|e| e.up, mm),
            found(|e| e.tilt, degrees),
            found(|e| e.heading, degrees)
        );
    }
    Ok(())
}

/// Rougher ground, faster walks and delays, none of which the controller knows of: where it ends.
fn limits() -> Result<(), Diagnostics> {
    let heights =
        |kind: &str, height: f64| format!("[ground.heights]\nkind = \"{kind}\"\nheight = {height}\n");
    let late = |seconds: f64| format!("delay = {seconds}\n");
    let mut rows = Vec::new();
    for kind in ["footholds", "tiles", "waves"] {
        rows.push((format!("0.2 m/s, {kind} of ±10 mm"), 0.2, String::new(), heights(kind, 0.01)));
    }
    for (speed, millimetres) in [(0.3, 15), (0.3, 20), (0.4, 10)] {
        let words = format!("{speed} m/s, footholds of ±{millimetres} mm");
        rows.push((words, speed, String::new(), heights("footholds", 1e-3 * f64::from(millimetres))));
    }
    for milliseconds in [5, 12, 15, 20] {
        let keys = late(1e-3 * f64::from(milliseconds));
        rows.push((format!("0.3 m/s, delay of {milliseconds} ms"), 0.3, keys.clone(), String::new()));
        rows.push(("the same, 1° of play in the ankles".to_owned(), 0.3, keys, play()));
    }
    println!("\n| 64 s forward | true state | measured state |\n|---|---|---|");
    for (words, speed, keys, more) in rows {
        let velocity = format!("forward = {speed}");
        let cells = [("", ""), ("state = \"measured\"\n", SENSORS)].map(|(state, sensors)| {
            let (keys, more) = (format!("{state}{keys}"), format!("{sensors}{more}"));
            each(8, |seed| walk_with((64.0, seed), &velocity, &keys, &more)).map(|all| counted(&all))
        });
        let [exact, measured] = cells;
        println!("| {words} | {} | {} |", exact?, measured?);
    }
    Ok(())
}

/// What is put onto the torso while it walks, 5 s later.
fn payloads() -> Result<(), Diagnostics> {
    let rows = [
        ("forward, 0.3 m/s", "forward = 0.3", 1.0, [0.0, 0.0, 0.2]),
        ("forward, 0.3 m/s", "forward = 0.3", 1.0, [0.05, -0.05, 0.1]),
        ("forward, 0.4 m/s", "forward = 0.4", 1.0, [0.05, 0.0, 0.1]),
        ("backward, 0.2 m/s", "forward = -0.2", 1.0, [0.0, 0.05, 0.2]),
        ("to the side, 0.05 m/s", "left = 0.05", 1.0, [-0.05, 0.05, 0.3]),
        ("on the spot, turning by 0.4 rad/s", "turning = 0.4", 1.0, [-0.05, 0.0, 0.2]),
        ("standing", "forward = 0.0", 1.0, [0.05, -0.05, 0.1]),
        ("curve, 0.2 m/s and 0.3 rad/s", "forward = 0.2, turning = 0.3", 2.0, [0.05, -0.05, 0.1]),
        ("forward, 0.2 m/s", "forward = 0.2", 0.3, [0.05, -0.05, 0.1]),
        ("forward, 0.2 m/s", "forward = 0.2", 3.0, [0.05, 0.0, 0.2]),
        ("forward, 0.2 m/s", "forward = 0.2", 0.0, [0.0; 3]),
        ("forward, 0.3 m/s", "forward = 0.3", 0.0, [0.0; 3]),
    ];
    println!(
        "\n| walking | put on | walks | mass, median and farthest off | place, median | farthest off |\n|---|---|---|---|---|---|"
    );
    for (words, velocity, mass, place) in rows {
        let put = format!("{SENSORS}[[payload]]\ntime = 4.0\nmass = {mass}\nposition = {place:?}\n");
        let more = if mass > 0.0 { put } else { SENSORS.to_owned() };
        let keys = "state = \"measured\"\nlearn_payload = true\n";
        let all = each(8, |seed| walk_with((9.0, seed), velocity, keys, &more))?;
        let stood = all.iter().flatten().filter(|walk| walk.fell.is_none());
        let found: Vec<_> = stood.filter_map(|walk| walk.payload).collect();
        let of = |wished: f64, values: Vec<f64>| {
            let mut sorted = values;
            sorted.sort_by(f64::total_cmp);
            let far = sorted.iter().copied().max_by(|a, b| (a - wished).abs().total_cmp(&(b - wished).abs()));
            let middle = sorted.get((sorted.len().max(1) - 1) / 2).zip(sorted.get(sorted.len() / 2));
            far.zip(middle.map(|(a, b)| 0.5 * (a + b)))
        };
        let axes = [0, 1, 2].map(|k| of(place[k], found.iter().filter_map(|f| f.place[k]).collect()));
        let text = |x: Option<f64>| x.map_or("?".to_owned(), |x| format!("{x:.3}"));
        let [medians, farthest] = [
            axes.map(|axis| text(axis.map(|(_, median)| median))).join(", "),
            [0, 1, 2].map(|k| text(axes[k].map(|(far, _)| far - place[k]))).join(", "),
        ];
        let (far, median) = of(mass, found.iter().map(|f| f.mass).collect()).unwrap_or((f64::NAN, f64::NAN));
        let put = if mass > 0.0 { format!("{mass} kg at {place:?} m") } else { "nothing".to_owned() };
        println!(
            "| {words} | {put} | {} | {median:.3} and {far:.3} kg | ({medians}) m | ({farthest}) m |",
            counted(&all)
        );
    }
    Ok(())
}

/// The walks of all seeds, two at a time.
fn each(
    seeds: usize,
    one: impl Fn(usize) -> Result<Walk, Diagnostics> + Sync,
) -> Result<Vec<Walk>, Diagnostics> {
    let part = |first: usize| (first..seeds).step_by(2).map(&one).collect::<Result<Vec<_>, Diagnostics>>();
    let (even, odd) = std::thread::scope(|scope| {
        let odd = scope.spawn(|| part(1));
        (part(0), odd.join().expect("a walk does not panic"))
    });
    Ok(even?.into_iter().chain(odd?).collect())
}

/// How many of them fell, and how far the others came.
fn counted(all: &[Walk]) -> String {
    let ended: Vec<&FootstepSummary> = all.iter().flatten().collect();
    let steps: Vec<usize> = ended.iter().filter(|walk| walk.fell.is_none()).map(|walk| walk.steps).collect();
    let mut words = format!("{} of {} fall", ended.len() - steps.len(), all.len());
    if ended.len() < all.len() {
        words += &format!(", {} break off", all.len() - ended.len());
    }
    if let (Some(least), Some(most)) = (steps.iter().min(), steps.iter().max()) {
        words += &format!(", {least} to {most} steps");
    }
    words
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
        walk(7.5, "forward = 0.2", measured, &push, seed)
            .map(|walk| usize::from(walk.is_some_and(|walk| walk.fell.is_none())))
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
