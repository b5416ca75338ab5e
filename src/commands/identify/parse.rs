//! Options of `identify` that are more than a number.
use bipedc_analysis::identify::physical::Bound;
use bipedc_analysis::identify::{ExtraChoice, joint};
use bipedc_analysis::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostic;

/// What joints add.
pub fn extras(
    subject: &JointLayout,
    friction: &[String],
    rotor: &[String],
    coupled: &[String],
) -> Result<ExtraChoice, Diagnostic> {
    let mut choice = ExtraChoice::none();
    laws(friction, &mut [&mut choice.viscous, &mut choice.coulomb, &mut choice.offset])?;
    choice.rotors = match rotor {
        [word] if word == "none" => Vec::new(),
        [word] if word == "all" => (0..subject.joints.len()).collect(),
        names => names.iter().map(|name| joint(subject, name)).collect::<Result<_, _>>()?,
    };
    for pair in coupled {
        let Some((one, other)) = pair.split_once(',') else {
            return Err(Diagnostic::error(format!("--coupled has `{pair}`")).help("give two joints: A,B"));
        };
        let pair = (joint(subject, one)?, joint(subject, other)?);
        if pair.0 == pair.1 {
            return Err(Diagnostic::error(format!("--coupled names `{one}` twice")).help("give two joints"));
        }
        choice.coupled.push(pair);
    }
    Ok(choice)
}

/// Which of viscous friction, Coulomb friction and offset are wanted.
pub fn laws(words: &[String], wanted: &mut [&mut bool; 3]) -> Result<(), Diagnostic> {
    for word in words {
        match word.as_str() {
            "viscous" => *wanted[0] = true,
            "coulomb" => *wanted[1] = true,
            "offset" => *wanted[2] = true,
            "none" if words.len() == 1 => {}
            other => {
                return Err(Diagnostic::error(format!("--friction has `{other}`"))
                    .help("give a list of viscous, coulomb and offset, or none"));
            }
        }
    }
    Ok(())
}

/// What is known beside the data.
pub fn bounds(mass: Option<f64>, centers: &[String], mirrors: &[String]) -> Result<Vec<Bound>, Diagnostic> {
    let mut bounds: Vec<Bound> = mass.map(Bound::TotalMass).into_iter().collect();
    for text in centers {
        bounds.push(center(text).ok_or_else(|| {
            Diagnostic::error(format!("--center has `{text}`"))
                .help("give LINK=X0,X1,Y0,Y1,Z0,Z1 in m, for example shank=-0.05,0.05,-0.05,0.05,-0.3,0")
        })?);
    }
    for text in mirrors {
        let Some((left, right)) = text.split_once('=') else {
            return Err(
                Diagnostic::error(format!("--mirror has `{text}`")).help("give two links: LEFT=RIGHT")
            );
        };
        bounds.push(Bound::Mirror { left: left.to_owned(), right: right.to_owned() });
    }
    Ok(bounds)
}

fn center(text: &str) -> Option<Bound> {
    let (link, numbers) = text.split_once('=')?;
    let numbers: Vec<f64> = numbers.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
    let [x0, x1, y0, y1, z0, z1] = numbers[..] else { return None };
    Some(Bound::Center { link: link.to_owned(), low: [x0, y0, z0], high: [x1, y1, z1] })
}
