//! `bipedc export`: the robot as amended, for other tools.
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::{Workbench, export};
use bipedc_compiler::description::JointDynamics;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, kinds};
use bipedc_effects::files::write;
use clap::{ArgGroup, Args};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc export robots/tulip --urdf amended.urdf
  bipedc export robots/tulip --mjcf tulip.xml

Links get the masses, centres of mass and inertias that they have with the effects of biped.toml (payload, com_offset, \
inertia_error, inertial_correction), joints the damping (N m s/rad) and friction (N m) of viscous_friction and coulomb_friction as \
<dynamics>. Everything else of the URDF stays byte for byte, comments too; <dynamics> that the model does not have are named. MJCF (MuJoCo) also has rotor_inertia as armature and \
parallel_spring, contact points as spheres of 1 mm on a floor, a motor for every actuated joint; shapes and meshes it has not. What a \
format has no words for is listed.
JSON: {\"urdf\", \"mjcf\": null, or {\"file\", \"left_out\" (effects)}, of a URDF also \"links\" and \"joints\" with other numbers and \"kept\" (\"joint\", \"damping\", \"friction\" that the model does not have)}.";

/// Write the robot with what was amended as a URDF or as MJCF
#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(group(ArgGroup::new("outputs").required(true).multiple(true).args(["urdf", "mjcf"])))]
pub struct Export {
    /// Folder with `biped.toml`, or that file
    #[arg(value_name = "ROBOT")]
    path: PathBuf,
    /// URDF to write
    #[arg(long, value_name = "OUT.urdf")]
    urdf: Option<PathBuf>,
    /// MuJoCo model to write
    #[arg(long, value_name = "OUT.xml")]
    mjcf: Option<PathBuf>,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

/// What was written.
#[derive(Serialize, Default)]
struct Json {
    urdf: Option<Written>,
    mjcf: Option<Written>,
}

#[derive(Serialize)]
struct Written {
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    links: Option<Vec<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    joints: Option<Vec<String>>,
    left_out: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    kept: Option<Vec<Kept>>,
}

/// What a joint's `<dynamics>` say beyond the model; N m s/rad and N m, of joints that slide N s/m and N.
#[derive(Serialize)]
struct Kept {
    joint: String,
    damping: Option<f64>,
    friction: Option<f64>,
}

impl Export {
    /// Reads, rewrites, writes.
    pub fn run(self) -> Outcome {
        let bench = Workbench::open(&self.path)?;
        output::diagnostics(&bench.robot().warnings);
        let mut ledger = bench.ledger();
        for (option, file) in [("--urdf", &self.urdf), ("--mjcf", &self.mjcf)] {
            if let Some(file) = file {
                ledger.writes_source(option, file)?;
            }
        }
        // Both are made before one is written.
        let urdf = self.urdf.as_ref().map(|_| export::urdf(bench.robot())).transpose()?;
        let mjcf = self.mjcf.as_ref().map(|_| export::mjcf(bench.robot())).transpose()?;
        let (mut json, mut words) = (Json::default(), String::new());
        if let (Some(file), Some(exported)) = (&self.urdf, urdf) {
            write(file, &exported.urdf)?;
            words += &format!("wrote {}: {}\n", file.display(), changed(&exported.links, &exported.joints));
            let (links, joints) = (Some(exported.links), Some(exported.joints));
            let left_out = left_out("a URDF", &exported.left_out);
            let kept = Some(kept(&exported.kept));
            json.urdf = Some(Written { file: file.display().to_string(), links, joints, left_out, kept });
        }
        if let (Some(file), Some(exported)) = (&self.mjcf, mjcf) {
            write(file, &exported.mjcf)?;
            words += &format!("wrote {}\n", file.display());
            let left_out = left_out("MJCF", &exported.left_out);
            json.mjcf = Some(Written {
                file: file.display().to_string(),
                links: None,
                joints: None,
                left_out,
                kept: None,
            });
        }
        if self.json {
            output::print_json(&json)?
        } else {
            output::print(&words)?
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Warns of effects that a format has no words for, and names them.
fn left_out(format: &str, effects: &[Effect]) -> Vec<String> {
    let list: Vec<String> = effects.iter().map(Effect::to_string).collect();
    if !list.is_empty() {
        let warning = Diagnostic::warning(format!("{format} has no words for: {}", list.join(", ")));
        output::diagnostics(&[warning.help("they stay in biped.toml")]);
    }
    list
}

/// Warns of damping and friction that stand in the URDF and not in the model.
fn kept(dynamics: &[(String, JointDynamics)]) -> Vec<Kept> {
    if let [(first, stated), ..] = dynamics {
        let list: Vec<&str> = dynamics.iter().map(|(joint, _)| joint.as_str()).collect();
        let message = format!(
            "<dynamics> of the URDF say what the model does not have, and stand as they stood: {}",
            list.join(", ")
        );
        let (kind, value) = match (stated.damping, stated.friction) {
            (Some(damping), _) => (kinds::VISCOUS_FRICTION.name, format!("damping={damping}")),
            (None, friction) => {
                (kinds::COULOMB_FRICTION.name, format!("torque={}", friction.unwrap_or_default()))
            }
        };
        let help = format!(
            "other tools will use them; `bipedc amend ROBOT --effect {kind} --joint {first} --set {value}` gives them to the model, the value 0 takes them out"
        );
        output::diagnostics(&[Diagnostic::warning(message).help(help)]);
    }
    let one = |(joint, stated): &(String, JointDynamics)| Kept {
        joint: joint.clone(),
        damping: stated.damping,
        friction: stated.friction,
    };
    dynamics.iter().map(one).collect()
}

/// Links and joints of which numbers are others than in the URDF, in words.
fn changed(links: &[String], joints: &[String]) -> String {
    let told = |what: &str, names: &[String]| match names {
        [] => None,
        [one] => Some(format!("{what} {one}")),
        several => Some(format!("{what}s {}", several.join(", "))),
    };
    let both: Vec<String> = [told("link", links), told("joint", joints)].into_iter().flatten().collect();
    match both.is_empty() {
        true => "all numbers are those of the URDF".to_owned(),
        false => format!("other numbers for {}", both.join("; ")),
    }
}

#[cfg(test)]
mod tests {
    use super::changed;

    #[test]
    fn what_did_not_change_is_not_listed() {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        assert_eq!(changed(&[], &[]), "all numbers are those of the URDF");
        assert_eq!(changed(&[], &names(&["knee"])), "other numbers for joint knee");
        let both = changed(&names(&["shin", "thigh"]), &names(&["knee"]));
        assert_eq!(both, "other numbers for links shin, thigh; joint knee");
    }
}
