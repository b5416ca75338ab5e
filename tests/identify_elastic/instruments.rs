//! Noisy regressors: what least squares shrinks, and instruments do not.
use crate::identify_elastic::cli::scratch;
use crate::identify_elastic::leg::{Leg, Noise, Recorded, Sensors, identify};
use std::path::Path;

/// The inertia about the knee, without which the shank would not be felt: times a noisy acceleration.
const INERTIA: &str = "right_lower_leg.Iyy";

/// Coarse encoders, hardly filtered: accelerations are noisy, and least squares shrinks what multiplies them.
#[test]
#[ignore = "takes long"]
fn instruments_remove_the_bias_that_coarse_encoders_make() {
    let folder = scratch("elastic_instruments");
    let leg = Leg::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/tulip_v1_leg"));
    let mut noise = Noise(2);
    let leg = leg.with(&mut || 0.8 + 0.45 * noise.even());
    let mut away = [Vec::new(), Vec::new()];
    for seed in 0..2 {
        let log = folder.join(format!("log{seed}.csv"));
        let recorded = Recorded { seconds: 10.0, rate: 500.0, seed: 40 + seed, slowest: 0.3, fastest: 1.2 };
        leg.record(&log, recorded, Sensors { counts: Some([500.0, 4000.0]), current: 0.005 });
        for (k, estimator) in ["weighted", "instrumental"].iter().enumerate() {
            let options = ["--cutoff", "30", "--estimator", estimator];
            let answer = identify("robots/tulip_v1_leg", &log, &options).ok().json();
            let parameters = answer["parameters"].as_array().unwrap();
            let found = parameters.iter().find(|p| p["name"].as_str().unwrap().starts_with(INERTIA)).unwrap();
            let [value, truth, error] =
                ["value", "nominal", "standard_error"].map(|key| found[key].as_f64().unwrap());
            println!("{estimator}: {:+.1} ± {:.1} %", 100.0 * (value / truth - 1.0), 100.0 * error / truth);
            away[k].push([value / truth - 1.0, error / truth]);
        }
    }
    let [plain, instrumental] = away;
    assert!(plain.iter().all(|[away, error]| *away < -0.1 && *away < -4.0 * error), "{plain:?}");
    assert!(
        instrumental.iter().all(|[away, error]| away.abs() < 0.03 && away.abs() < 2.0 * error),
        "{instrumental:?}"
    );
}
