//! Contact points, phases and impacts.
use super::super::Context;
use super::super::quantity::Quantity;
use super::{acceleration_units, configuration_names};
use crate::derive::constrained::{
    constrained_dynamics as constrained, constrained_dynamics_with_effects as constrained_with_effects,
};
use crate::derive::constraint::Constraints;
use crate::derive::contact::{ContactPoints, contact_points, is_planar};
use crate::derive::impact::{impact_map as impact, impact_map_with_effects as impact_with_effects};
use crate::derive::relabel::Relabelling;
use crate::description::model::Phase;
use crate::expression::Sym;
use crate::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::Argument;

fn velocity_units(tree: &Tree) -> Vec<String> {
    (0..tree.nv).map(|r| if tree.row_is_linear(r) { "m/s" } else { "rad/s" }.to_owned()).collect()
}

fn normal_names(tree: &Tree) -> Vec<String> {
    tree.points.iter().map(|point| format!("{}/z", point.name)).collect()
}
fn tangential_names(tree: &Tree) -> Vec<String> {
    let axes: &[&str] = if is_planar(tree) { &["x"] } else { &["x", "y"] };
    tree.points
        .iter()
        .flat_map(|point| axes.iter().map(move |axis| format!("{}/{axis}", point.name)))
        .collect()
}

fn points<'g>(c: &Context<'g, '_>) -> ContactPoints<'g> {
    contact_points(&c.folded)
}
fn vector<'g>(names: Vec<String>, unit: &str, values: Vec<Sym<'g>>) -> Quantity<'g> {
    let units = vec![unit.to_owned(); names.len()];
    Quantity::named(names, units, values)
}
fn directions<'g>(tree: &Tree, names: Vec<String>, rows: &[Vec<Sym<'g>>]) -> Quantity<'g> {
    let columns = (0..names.len()).map(|k| rows.iter().map(|row| row[k]).collect()).collect();
    let units = (0..tree.nv).map(|r| if tree.row_is_linear(r) { "1" } else { "m" }.to_owned()).collect();
    Quantity::matrix(tree.row_names(), units, names, columns)
}

pub fn distances<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    vector(normal_names(c.folded.tree), "m", points(c).normal)
}
pub fn positions<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    vector(tangential_names(c.folded.tree), "m", points(c).tangential)
}
pub fn normal_directions<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    directions(c.folded.tree, normal_names(c.folded.tree), &points(c).normal_directions)
}
pub fn tangential_directions<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    directions(c.folded.tree, tangential_names(c.folded.tree), &points(c).tangential_directions)
}
pub fn normal_rate<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    vector(normal_names(c.folded.tree), "m/s²", points(c).normal_rate)
}
pub fn tangential_rate<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    vector(tangential_names(c.folded.tree), "m/s²", points(c).tangential_rate)
}

/// A motion in the order of `v`, then what the ground does.
fn stacked<'g>(
    c: &Context<'g, '_>,
    motion: (Vec<String>, Vec<Sym<'g>>),
    ground: (&Constraints<'g>, &str, Vec<Sym<'g>>),
) -> Quantity<'g> {
    let (mut units, mut values) = motion;
    let (constraints, per, forces) = ground;
    let mut names = c.folded.tree.row_names();
    names.extend(constraints.names.iter().cloned());
    units.extend(constraints.units.iter().map(|unit| format!("{unit}{per}")));
    values.extend(forces);
    Quantity::named(names, units, values)
}

pub fn constrained_dynamics<'g>(c: &Context<'g, '_>, phase: &Phase) -> Result<Quantity<'g>, Diagnostic> {
    let constraints = Constraints::new(&c.folded, &c.description.feet, &phase.contacts)?;
    let solution = match c.laws.is_empty() {
        true => constrained(&c.folded, &constraints),
        false => constrained_with_effects(&c.folded, &constraints, c.laws),
    };
    let motion = (acceleration_units(c.folded.tree), solution.acceleration);
    Ok(stacked(c, motion, (&constraints, "", solution.forces)))
}

pub fn impact_map<'g>(c: &Context<'g, '_>, phase: &Phase) -> Result<Quantity<'g>, Diagnostic> {
    let tree = c.folded.tree;
    let constraints = Constraints::new(&c.folded, &c.description.feet, &phase.impact)?;
    let solution = match c.laws.is_empty() {
        true => impact(&c.folded, &constraints),
        false => impact_with_effects(&c.folded, &constraints, c.laws),
    };
    let units =
        (0..tree.nv).map(|r| if tree.row_is_linear(r) { "m/s" } else { "rad/s" }.to_owned()).collect();
    Ok(stacked(c, (units, solution.velocity), (&constraints, " s", solution.impulse)))
}

pub fn relabelled_configuration<'g>(c: &Context<'g, '_>) -> Result<Quantity<'g>, Diagnostic> {
    let tree = c.folded.tree;
    let q: Vec<Sym<'g>> = (0..tree.nq).map(|k| c.folded.input(Argument::Q, k)).collect();
    let (names, units) = configuration_names(tree);
    let mut relabelled = Relabelling::new(tree, c.description)?.configuration(&q);
    // Positions come in as true ones; they go out as the other leg's encoders report them.
    for (x, &offset) in relabelled.iter_mut().zip(&c.folded.offsets) {
        *x = *x + offset;
    }
    Ok(Quantity::named(names, units, relabelled))
}

pub fn relabelled_velocity<'g>(c: &Context<'g, '_>) -> Result<Quantity<'g>, Diagnostic> {
    let tree = c.folded.tree;
    let v: Vec<Sym<'g>> = (0..tree.nv).map(|k| c.folded.input(Argument::V, k)).collect();
    let relabelled = Relabelling::new(tree, c.description)?.velocity(&v);
    Ok(Quantity::named(tree.row_names(), velocity_units(tree), relabelled))
}
