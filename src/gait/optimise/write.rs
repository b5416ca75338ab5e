//! What was found as a gait file: that of the form with other curves, torques and ends.
use super::Optimum;
use bipedc_compiler::compile::{Collocation, GaitForm};
use bipedc_effects::diagnostic::Diagnostic;
use std::collections::BTreeSet;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, Value, value};

/// The text of a gait file with what was found; `source` is that of the form, whose formulas of the configuration stay. `head` goes before it as
/// a comment, `friction` is the coefficient that its controller keeps to.
///
/// # Errors
/// The form is no TOML: it was read before, so that this is a fault of ours.
pub fn gait_text(
    source: &str,
    form: &GaitForm,
    of: &Collocation,
    found: &Optimum,
    (head, friction): (&str, f64),
) -> Result<String, Diagnostic> {
    let body: Vec<&str> =
        source.lines().skip_while(|line| line.trim().is_empty() || line.starts_with('#')).collect();
    let broken = |error: toml_edit::TomlError| Diagnostic::error(format!("the form is no TOML: {error}"));
    let mut text: DocumentMut = body.join("\n").parse().map_err(broken)?;
    text.remove("parameters");
    keep_quantities(&mut text, form);
    let mut limits = Table::new();
    limits.insert("friction", value(friction));
    text.insert("limits", Item::Table(limits));
    if let Some(phases) = text.get_mut("phase").and_then(Item::as_array_of_tables_mut) {
        for (p, phase) in phases.iter_mut().enumerate() {
            if of.phases.len() == 1 && !phase.contains_key("end") {
                one_phase(phase, of, found)
            } else {
                several(phase, (p, of), found)
            };
            outputs(phase, p, of, found);
        }
    }
    let head: String = head.lines().map(|line| format!("# {line}\n")).collect();
    Ok(format!("{head}\n{}\n", text.to_string().trim()))
}

/// Quantities that formulas of the configuration need.
fn keep_quantities(text: &mut DocumentMut, form: &GaitForm) {
    let phases = form.phases.iter();
    let formulas = phases
        .flat_map(|phase| phase.outputs.iter().map(|output| &output.controlled).chain([&phase.variable]));
    let mut open: Vec<String> = formulas.flat_map(|formula| formula.names().to_vec()).collect();
    let mut needed = BTreeSet::new();
    while let Some(name) = open.pop() {
        if let Some(quantity) = form.quantities.get(&name)
            && needed.insert(name)
        {
            open.extend(quantity.names().to_vec());
        }
    }
    if let Some(table) = text.get_mut("quantities").and_then(Item::as_table_mut) {
        table.retain(|key, _| needed.contains(key));
    }
    if needed.is_empty() {
        text.remove("quantities");
    }
}

/// The step ends where the foot in the air comes to the ground.
fn one_phase(phase: &mut Table, of: &Collocation, found: &Optimum) {
    let [first, last] = found.ends(0);
    let point =
        |index: Option<&usize>| index.map_or_else(String::new, |&k| of.tree.points[k].name.replace('/', "_"));
    let (lands, stands) = (point(of.changes[0].landing.first()), point(of.phases[0].standing.first()));
    let mut guard = InlineTable::new();
    guard.insert("zero", format!("{lands}_z - {stands}_z").into());
    let between = [first + 0.7 * (last - first), last + 0.2 * (last - first)];
    guard.insert("between", Value::Array(between.into_iter().collect()));
    phase.insert("guard", value(guard));
    phase.insert("impact_matching", value(true));
    posture(phase, found.configuration(0, 0), of);
}

fn several(phase: &mut Table, (p, of): (usize, &Collocation), found: &Optimum) {
    let [_, last] = found.ends(p);
    phase.insert("end", value(last));
    phase.insert("impact_matching", value(true));
    if p == 0 {
        // A chain of phases looks for the end of the first one.
        posture(phase, found.last_configuration(p), of);
    }
    phase.remove("feedforward");
    let (at, torques) = beyond(found.torques(of, p));
    let mut table = Table::new();
    table.insert("at", value(rows(&at)));
    let mut joints = Table::new();
    for (joint, values) in of.tree.joints.iter().zip(torques) {
        joints.insert(&joint.name, value(rows(&values)));
    }
    table.insert("torques", Item::Table(joints));
    phase.insert("feedforward", Item::Table(table));
}

/// Part of a phase by which torques go on behind its end as they came to it.
const BEYOND: f64 = 0.15;

/// Torques over φ with one place more, behind the end. The event that ends a phase comes a little earlier or later than in the motion; torques that stayed as they are
/// at the end would let the force that has to vanish vanish no further.
fn beyond((mut at, mut torques): (Vec<f64>, Vec<Vec<f64>>)) -> (Vec<f64>, Vec<Vec<f64>>) {
    let (Some(before), Some(last)) = (at.len().checked_sub(3), at.len().checked_sub(1)) else {
        return (at, torques);
    };
    let further = BEYOND * (at[last] - at[0]);
    for values in &mut torques {
        let slope = (values[last] - values[before]) / (at[last] - at[before]);
        values.push(values[last] + slope * further);
    }
    at.push(at[last] + further);
    (at, torques)
}

/// Joints where searches for a posture begin.
fn posture(phase: &mut Table, q: &[f64], of: &Collocation) {
    let mut table = InlineTable::new();
    for joint in &of.tree.joints {
        table.insert(&joint.name, ((q[joint.v_index] * 100.0).round() / 100.0).into());
    }
    phase.insert("posture", value(table));
}

fn outputs(phase: &mut Table, p: usize, of: &Collocation, found: &Optimum) {
    let Some(outputs) = phase.get_mut("output").and_then(Item::as_array_of_tables_mut) else { return };
    for (k, output) in outputs.iter_mut().enumerate() {
        let mut wanted = Table::new();
        wanted.set_dotted(true);
        wanted.insert("over", value(found.ends(p).into_iter().collect::<Array>()));
        wanted.insert("bezier", value(rows(found.coefficients(of, p, k))));
        output.insert("wanted", Item::Table(wanted));
    }
}

/// Numbers, a few in a line.
fn rows(of: &[f64]) -> Array {
    let mut found: Array = of.iter().copied().collect();
    for (k, value) in found.iter_mut().enumerate() {
        value.decor_mut().set_prefix(if k % 5 == 0 { "\n    " } else { " " });
    }
    found.set_trailing("\n");
    found.set_trailing_comma(true);
    found
}

#[cfg(test)]
mod tests {
    use super::beyond;

    /// A torque that falls evenly goes on to fall behind the end; what was known stays.
    #[test]
    fn torques_go_on_behind_the_end() {
        let (at, torques) = beyond((vec![0.0, 0.5, 1.0, 1.5, 2.0], vec![vec![9.0, 4.0, 3.0, 2.5, 2.0]]));
        assert_eq!(at[..5], [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(torques[0][..5], [9.0, 4.0, 3.0, 2.5, 2.0]);
        assert!((at[5] - 2.3).abs() < 1e-12 && (torques[0][5] - 1.7).abs() < 1e-12, "{at:?} {torques:?}");
        let short = (vec![0.0, 1.0], vec![vec![1.0, 2.0]]);
        assert_eq!(beyond(short.clone()), short);
    }
}
