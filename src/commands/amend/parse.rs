//! The arguments of `amend` that clap leaves as texts.
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, Law, OwnParameter};

/// Refuses an effect without parameters if its kind has any that must be given.
///
/// # Errors
/// Says which, with units.
pub fn demand_parameters(effect: &Effect) -> Result<(), Diagnostic> {
    let kind = effect.kind;
    if kind.law == Law::Formula {
        return Ok(());
    }
    let names: Vec<String> =
        kind.estimated().map(|p| format!("{}=… ({}, {})", p.name, p.unit, p.meaning)).collect();
    if names.is_empty() {
        return Ok(());
    }
    Err(Diagnostic::error(format!("parameters are needed for `{}`", kind.name))
        .help(format!("give them: --set {}", names.join(", "))))
}

/// `name=0.43`
///
/// # Errors
/// No `=`, or no finite number behind it.
pub fn assignment(text: &str, example: &str) -> Result<(String, f64), Diagnostic> {
    let Some((name, value)) = text.split_once('=') else {
        return Err(Diagnostic::error(format!("`{text}` is no NAME=VALUE")).help(format!("write {example}")));
    };
    Ok((name.trim().to_owned(), number(name, value)?))
}

fn number(name: &str, text: &str) -> Result<f64, Diagnostic> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(Diagnostic::error(format!(
            "`{}`: expected a finite number, found `{}`",
            name.trim(),
            text.trim()
        ))
        .help("write it in SI units with a decimal point, such as 0.43 or 1e-3")),
    }
}

/// `k=0.1,unit=N m,min=0,max=2`
///
/// # Errors
/// Parts that have no meaning.
pub fn own_parameter(text: &str) -> Result<(String, f64, OwnParameter), Diagnostic> {
    const EXAMPLE: &str = "--param \"k=0.1,unit=N m,min=0,max=2\"";
    let mut parts = text.split(',');
    let (name, value) = assignment(parts.next().unwrap_or(""), EXAMPLE)?;
    let mut own = OwnParameter { unit: "1".to_owned(), min: None, max: None };
    for part in parts {
        match part.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
            Some(("unit", unit)) => own.unit = unit.to_owned(),
            Some(("min", bound)) => own.min = Some(number("min", bound)?),
            Some(("max", bound)) => own.max = Some(number("max", bound)?),
            _ => {
                return Err(Diagnostic::error(format!(
                    "--param {name}: `{part}` is none of unit=, min=, max="
                ))
                .help(format!("write {EXAMPLE}; give --param again for another parameter")));
            }
        }
    }
    Ok((name, value, own))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_parameters_have_units_with_blanks() {
        let (name, value, own) = own_parameter("k=0.1,unit=N m s/rad,min=0").unwrap();
        assert_eq!((name.as_str(), value, own.unit.as_str()), ("k", 0.1, "N m s/rad"));
        assert_eq!((own.min, own.max), (Some(0.0), None));
        for nonsense in ["k", "k=", "k=nan", "k=1,size=3", "k=1,min=x", ""] {
            assert!(own_parameter(nonsense).is_err(), "{nonsense}");
        }
    }
}
