//! Whether what is controlled settles the legs: a determinant that vanishes where they are in line.
use crate::derive::RobotModel;
use crate::description::model::{Foot, RobotDescription};
use crate::expression::{Input, Sym, gradient, inputs};
use bipedc_runtime::Argument;

/// By foot: how far its leg is from where its joints do not settle the foot's place and pitch under the base (a knee that is straight), as a determinant of
/// slopes; 0 where that is no question: where what the outputs fix within the leg does not leave as many joints as a point (two) or a sole (three) needs.
pub(super) fn regularity<'g>(
    model: &RobotModel<'g, '_>,
    description: &RobotDescription,
    [places, heights]: [&[Sym<'g>]; 2],
    outputs: &[Sym<'g>],
) -> Vec<Sym<'g>> {
    let joints: Vec<usize> = model.tree.joints.iter().map(|joint| joint.v_index).collect();
    let moved = |of: Sym<'g>| -> Vec<usize> {
        let known = inputs(of);
        joints
            .iter()
            .copied()
            .filter(|&k| known.contains(&Input { argument: Argument::Q, index: k as u32 }))
            .collect()
    };
    let points = |foot: &Foot| -> Vec<usize> {
        let own = |k: &usize| model.tree.points[*k].name.split('/').next() == Some(&foot.name);
        (0..model.tree.points.len()).filter(own).collect()
    };
    let of_foot = |foot: &Foot| {
        let zero = heights[0].zero();
        let own = points(foot);
        let Some(&first) = own.first() else { return zero };
        let others = description.feet.iter().filter(|other| other.name != foot.name).flat_map(points);
        let shared: Vec<usize> = others.flat_map(|point| moved(heights[point])).collect();
        let leg: Vec<usize> = moved(heights[first]).into_iter().filter(|k| !shared.contains(k)).collect();
        // Of the leg alone: what also turns with the base, as a foot's pitch does, fixes nothing within it.
        let fixed: Vec<&Sym<'g>> = (outputs.iter())
            .filter(|output| {
                let known = inputs(**output);
                let mut places = known.iter().filter(|input| input.argument == Argument::Q).peekable();
                places.peek().is_some() && places.all(|input| leg.contains(&(input.index as usize)))
            })
            .collect();
        let slopes = |of: Sym<'g>| {
            let found = gradient(of);
            let along = |&k: &usize| found.get(&Input { argument: Argument::Q, index: k as u32 }).copied();
            leg.iter().map(|k| along(k).unwrap_or(zero)).collect::<Vec<_>>()
        };
        let needs = if own.len() > 1 { 3 } else { 2 };
        if leg.len() != needs + fixed.len() {
            return zero;
        }
        let mut rows: Vec<Vec<Sym<'g>>> = Vec::new();
        if let Some(&second) = own.get(1) {
            let along = [places[second] - places[first], heights[second] - heights[first]];
            let turned = slopes(along[1]).into_iter().zip(slopes(along[0]));
            rows.push(turned.map(|(up, on)| along[0] * up - along[1] * on).collect());
        }
        rows.extend([slopes(places[first]), slopes(heights[first])]);
        rows.extend(fixed.into_iter().map(|output| slopes(*output)));
        determinant(&rows, &(0..leg.len()).collect::<Vec<_>>(), zero)
    };
    description.feet.iter().map(of_foot).collect()
}

/// Of these columns of the rows, as many as there are, expanded by the first row; there are few.
fn determinant<'g>(rows: &[Vec<Sym<'g>>], columns: &[usize], zero: Sym<'g>) -> Sym<'g> {
    let Some((row, others)) = rows.split_first() else { return zero + 1.0 };
    let mut sum = zero;
    for (place, &column) in columns.iter().enumerate() {
        let left: Vec<usize> = columns.iter().copied().filter(|other| *other != column).collect();
        let part = row[column] * determinant(others, &left, zero);
        sum = if place % 2 == 0 { sum + part } else { sum - part };
    }
    sum
}
