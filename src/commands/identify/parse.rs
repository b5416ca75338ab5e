//! Options of `identify` that are more than a number.
use bipedc::identification::Rotors;
use bipedc_analysis::identify::offered;
use bipedc_analysis::identify::physical::Bound;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::Kind;

/// What joints add, in the order of the library.
pub fn friction(words: &[String]) -> Result<Vec<&'static Kind>, Diagnostic> {
    let known = || offered().map(|(_, identified)| identified.option);
    let alone = matches!(words, [word] if word == "none");
    if let Some(other) = words.iter().find(|word| !alone && !known().any(|option| option == word.as_str())) {
        let list: Vec<&str> = known().collect();
        return Err(Diagnostic::error(format!("--friction has `{other}`"))
            .help(format!("give a list of {}, or none", list.join(", "))));
    }
    let wanted = offered().filter(|(_, identified)| words.iter().any(|word| word == identified.option));
    Ok(wanted.map(|(kind, _)| kind).collect())
}

/// Joints whose effort moves a rotor too.
pub fn rotors(words: &[String]) -> Rotors {
    match words {
        [word] if word == "none" => Rotors::None,
        [word] if word == "all" => Rotors::All,
        names => Rotors::Of(names.to_vec()),
    }
}

/// Joints whose drives turn together.
pub fn coupled(pairs: &[String]) -> Result<Vec<[String; 2]>, Diagnostic> {
    let pair = |pair: &String| match pair.split_once(',') {
        Some((one, other)) => Ok([one.to_owned(), other.to_owned()]),
        None => Err(Diagnostic::error(format!("--coupled has `{pair}`")).help("give two joints: A,B")),
    };
    pairs.iter().map(pair).collect()
}

/// What is known beside the data.
pub fn bounds(centers: &[String], mirrors: &[String]) -> Result<Vec<Bound>, Diagnostic> {
    let mut bounds = Vec::new();
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
