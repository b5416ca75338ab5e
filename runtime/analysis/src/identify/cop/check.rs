//! What may be wrong with a table of postures, before anything is estimated from it.
use crate::experiments::postures::{PostureExperiment, SolePose};
use crate::polygon::Polygon;
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostic;

/// A swing foot that is tilted by less counts as flat, rad: encoders and ground are not better than that.
pub const TILTED: f64 = 0.05;
/// Joints whose positions spread by less tell nothing, rad or m.
const STILL: f64 = 0.01;
/// Angles beyond this are no radians.
const DEGREES: f64 = 7.0;
/// A foot higher than this is in the air; one that is lower by more is below the ground, m.
const HEIGHT: f64 = 0.01;
/// Usual distances of a centre of pressure from the stance sole's origin, m.
const USUAL: std::ops::Range<f64> = 0.02..0.6;
/// A centre of pressure may lie outside the soles by what plates and encoders are off, m.
const OUTSIDE: f64 = 0.01;

/// Errors and warnings, naming columns, joints and postures.
pub fn check_postures(postures: &PostureExperiment<'_>, layout: &JointLayout) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    found.extend(coordinates(postures));
    found.extend(degrees(postures, layout));
    found.extend(toppled(postures));
    if found.is_empty() {
        found.extend(alike(postures, layout));
        found.extend(feet(postures));
        found.extend(centers(postures));
    }
    found
}

/// Both coordinates are needed.
fn coordinates(postures: &PostureExperiment<'_>) -> Option<Diagnostic> {
    let first = postures.centers().first().copied()?;
    let axis = ["x", "y"][first.iter().position(|c| c.is_nan())?];
    let message = format!("no column `cop/{axis}`: both coordinates of the centre of pressure are needed");
    Some(Diagnostic::error(message).help(format!(
        "log `cop/{axis}`, m, in the sole frame of `{}` (below its ankle roll axis, axes of the foot)",
        postures.stance()
    )))
}

fn degrees(postures: &PostureExperiment<'_>, layout: &JointLayout) -> Option<Diagnostic> {
    let positions = postures.positions();
    let largest = |j: usize| positions.iter().map(|q| q[j].abs()).fold(0.0, f64::max);
    let (joint, most) = (0..layout.joints.len())
        .filter(|j| !layout.joints[*j].prismatic)
        .map(|j| (j, largest(j)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    (most > DEGREES).then(|| {
        let name = &layout.joints[joint].name;
        Diagnostic::error(format!("`{name}/position` reaches {most:.1} rad: are these degrees?")).help(format!(
            "a mapping file converts: \"{name}/position\" = {{ column = \"{name}/position\", scale = 0.0174533 }}"
        ))
    })
}

fn toppled(postures: &PostureExperiment<'_>) -> Option<Diagnostic> {
    let toppled = postures.toppled();
    let first = *toppled.first()?;
    let message = format!(
        "`base/orientation` says that the sole of `{}` stands on its edge in {} postures, first in the {}th",
        postures.stance(),
        toppled.len(),
        first + 1
    );
    Some(
        Diagnostic::error(message)
            .help("is the quaternion base to world, x y z w, and does it belong to the root link?"),
    )
}

/// Joints that do not move, or none that does.
fn alike(postures: &PostureExperiment<'_>, layout: &JointLayout) -> Option<Diagnostic> {
    let positions = postures.positions();
    let spread = |j: usize| {
        let range = positions
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(q[j]), high.max(q[j])));
        range.1 - range.0
    };
    let still: Vec<usize> = (0..layout.joints.len()).filter(|j| spread(*j) < STILL).collect();
    let names = still.iter().map(|j| layout.joints[*j].name.as_str());
    let names = crate::log::names::list(names, 12);
    let help = "`bipedc excite ROBOT --postures 50 --placements 10` designs postures that differ";
    if still.len() == layout.joints.len() {
        return Some(Diagnostic::error("all postures are alike: no joint moves between them").help(help));
    }
    (!still.is_empty()).then(|| {
        Diagnostic::warning(format!(
            "joints that hardly move between postures (less than {STILL} rad): {names}"
        ))
        .help(help)
    })
}

/// Largest angle between the soles of feet and the stance sole: foot, posture and rad.
pub fn swing_tilt(postures: &PostureExperiment<'_>) -> Option<(String, usize, f64)> {
    let mut worst: Option<(String, usize, f64)> = None;
    for posture in 0..postures.centers().len() {
        for (foot, sole) in postures.feet().iter().zip(postures.soles(posture)) {
            let tilt = tilt(&sole);
            if foot.name != postures.stance() && worst.as_ref().is_none_or(|w| tilt > w.2) {
                worst = Some((foot.name.clone(), posture, tilt));
            }
        }
    }
    worst
}

fn tilt(sole: &SolePose) -> f64 {
    let normal = sole.rotation.column(2);
    normal[0].hypot(normal[1]).atan2(normal[2])
}

/// Feet that are tilted or below the ground.
fn feet(postures: &PostureExperiment<'_>) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    if let Some((foot, posture, tilt)) = swing_tilt(postures).filter(|(_, _, tilt)| *tilt > TILTED) {
        let message = format!(
            "feet are not flat: by the joint positions `{foot}` is tilted by up to {tilt:.2} rad against `{}` (posture {})",
            postures.stance(),
            posture + 1
        );
        found.push(Diagnostic::warning(message).help(
            "fine while that foot is in the air; if it stood on the plate, check encoder zeros and the URDF",
        ));
    }
    let mut lowest: Option<(String, usize, f64)> = None;
    for posture in 0..postures.centers().len() {
        for (foot, sole) in postures.feet().iter().zip(postures.soles(posture)) {
            let height = sole.corners.iter().map(|c| c.z).fold(f64::INFINITY, f64::min);
            if height < -HEIGHT && lowest.as_ref().is_none_or(|l| height < l.2) {
                lowest = Some((foot.name.clone(), posture, height));
            }
        }
    }
    if let Some((foot, posture, height)) = lowest {
        let message = format!(
            "by the joint positions `{foot}` lies {:.0} mm below the sole of `{}` (posture {})",
            -1e3 * height,
            postures.stance(),
            posture + 1
        );
        found.push(
            Diagnostic::warning(message)
                .help("check encoder zeros, signs and the URDF; or name another --stance"),
        );
    }
    found
}

/// Centres of pressure in wrong units or outside the feet.
fn centers(postures: &PostureExperiment<'_>) -> Vec<Diagnostic> {
    let centers = postures.centers();
    let outside = |scale: f64| -> Vec<(usize, f64)> {
        let distance = |(i, c): (usize, &[f64; 2])| {
            let ground = |sole: &SolePose| {
                sole.corners.iter().filter(|c| c.z.abs() < HEIGHT).map(|c| [c.x, c.y]).collect::<Vec<_>>()
            };
            let points: Vec<[f64; 2]> = postures.soles(i).iter().flat_map(ground).collect();
            (i, -Polygon::hull(&points).inside([scale * c[0], scale * c[1]]))
        };
        centers.iter().enumerate().map(distance).filter(|(_, d)| *d > OUTSIDE).collect()
    };
    let wrong = outside(1.0);
    if 2 * wrong.len() > centers.len() {
        let mut sizes: Vec<f64> = centers.iter().map(|[x, y]| x.hypot(*y)).collect();
        sizes.sort_by(f64::total_cmp);
        let middle = sizes[sizes.len() / 2];
        for (scale, unit) in [(1e-3, "millimetres"), (1e-2, "centimetres")] {
            if USUAL.contains(&(scale * middle)) && 4 * outside(scale).len() < centers.len() {
                let message = format!(
                    "`cop/x` and `cop/y` seem to be in {unit}: as metres they lie {middle:.1} m from the sole"
                );
                return vec![Diagnostic::error(message).help(format!(
                    "a mapping file converts: \"cop/x\" = {{ column = \"cop/x\", scale = {scale} }}, and the same for y"
                ))];
            }
        }
    }
    let Some(worst) = wrong.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return Vec::new() };
    let message = format!(
        "the centre of pressure lies outside the soles in {} of {} postures, by up to {:.0} mm (posture {})",
        wrong.len(),
        centers.len(),
        1e3 * worst.1,
        worst.0 + 1
    );
    let help = format!(
        "`cop/x`, `cop/y` belong into the sole frame of `{}`: is another foot the stance foot (--stance), or the feet's points in biped.toml too small?",
        postures.stance()
    );
    let most = 2 * wrong.len() > centers.len();
    vec![if most { Diagnostic::error(message) } else { Diagnostic::warning(message) }.help(help)]
}
