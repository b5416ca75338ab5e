//! The thesis' simplified model (8.3.2): some first moments are zero by the robot's shape.
use crate::identify::BaseSet;
use crate::robot::inertial_parameters::element_of;

/// What is left of a row below this, in units of its largest element, is rounding.
const ROUNDING: f64 = 1e-9;

/// Base parameters when the parameters for which `zero` holds (index among ten per body) are zero: the sums without them,
/// those that have become dependent grouped again.
///
/// With `β = S p` and some of p zero the remaining columns of S are brought to reduced row echelon form: its rows are the
/// new sums, and each has its own leading parameter, with factor 1, that stands in no other sum. `names` are those of all
/// inertial parameters, `units` of the ten of a body.
pub fn simplified(base: &BaseSet, names: &[String], zero: &dyn Fn(usize) -> bool) -> BaseSet {
    let order = columns(base, zero);
    let mut rows: Vec<Vec<f64>> = base
        .sums
        .iter()
        .map(|sum| {
            let mut row = vec![0.0; order.len()];
            for (k, factor) in sum {
                if let Some(place) = order.iter().position(|o| o == k) {
                    row[place] += factor;
                }
            }
            row
        })
        .collect();
    let pivots = echelon(&mut rows, order.len());
    let mut new = BaseSet::default();
    for (row, pivot) in rows.iter().zip(&pivots) {
        let mut sum = vec![(order[*pivot], 1.0)];
        let others = row.iter().enumerate().filter(|(k, x)| k != pivot && **x != 0.0);
        sum.extend(others.map(|(k, x)| (order[k], *x)));
        new.names.push(text(&sum, names));
        new.units.push(["kg", "kg m", "kg m²"][element_of(order[*pivot]).div_ceil(3).min(2)]);
        new.sums.push(sum);
    }
    new
}

/// Parameters that may be other than zero: those that lead first, because they are the preferred representatives.
fn columns(base: &BaseSet, zero: &dyn Fn(usize) -> bool) -> Vec<usize> {
    let mut order: Vec<usize> = (0..base.sums.len()).filter_map(|k| base.leading(k)).collect();
    for (k, _) in base.sums.iter().flatten() {
        if !order.contains(k) {
            order.push(*k);
        }
    }
    order.retain(|k| !zero(*k));
    order
}

/// Reduced row echelon form in place; the columns of the leading ones. Rows without one are dropped.
fn echelon(rows: &mut Vec<Vec<f64>>, width: usize) -> Vec<usize> {
    let mut pivots = Vec::new();
    for column in 0..width {
        let first = pivots.len();
        let best =
            (first..rows.len()).max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()));
        let Some(best) = best.filter(|&row| rows[row][column].abs() > ROUNDING) else {
            continue;
        };
        rows.swap(first, best);
        let lead = rows[first][column];
        rows[first].iter_mut().for_each(|x| *x /= lead);
        let pivot = rows[first].clone();
        for row in rows.iter_mut().enumerate().filter(|(k, _)| *k != first).map(|(_, row)| row) {
            let factor = row[column];
            if factor != 0.0 {
                row.iter_mut().zip(&pivot).for_each(|(x, p)| *x = clean(*x - factor * p));
                row[column] = 0.0;
            }
        }
        pivots.push(column);
    }
    rows.truncate(pivots.len());
    pivots
}

/// Lengths are of the order of 1: what is far smaller is rounding.
fn clean(x: f64) -> f64 {
    if x.abs() < ROUNDING { 0.0 } else { x }
}

fn text(sum: &[(usize, f64)], names: &[String]) -> String {
    let mut text = String::new();
    for (n, (k, factor)) in sum.iter().enumerate() {
        let name = names.get(*k).map_or("?", String::as_str);
        let size = (factor.abs() * 1e9).round() / 1e9;
        let size = if size == 1.0 { String::new() } else { format!("{size} ") };
        let sign = match (n, *factor < 0.0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        text.push_str(&format!("{sign}{size}{name}"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// β₀ = p₁ + 2 p₂ - p₁₁, β₁ = p₃ + p₂, β₂ = p₁₂ + 0.5 p₁₁.
    fn base() -> BaseSet {
        BaseSet {
            names: vec![String::new(); 3],
            units: vec!["kg m"; 3],
            sums: vec![
                vec![(1, 1.0), (2, 2.0), (11, -1.0)],
                vec![(3, 1.0), (2, 1.0)],
                vec![(12, 1.0), (11, 0.5)],
            ],
        }
    }

    fn names() -> Vec<String> {
        (0..20).map(|k| format!("p{k}")).collect()
    }

    #[test]
    fn without_zeros_nothing_changes() {
        let same = simplified(&base(), &names(), &|_| false);
        assert_eq!(same.sums, base().sums);
        assert_eq!(same.names[0], "p1 + 2 p2 - p11");
        assert_eq!(same.units, ["kg m"; 3]);
    }

    #[test]
    fn what_becomes_dependent_is_grouped() {
        // p1 and p3 gone: β₀ and β₁ both show p2.
        let less = simplified(&base(), &names(), &|k| k == 1 || k == 3 || k == 12);
        assert_eq!(less.sums.len(), 2);
        for (k, sum) in less.sums.iter().enumerate() {
            assert_eq!(sum[0].1, 1.0);
            let others = less.sums.iter().enumerate().filter(|(other, _)| *other != k);
            assert!(others.flat_map(|(_, s)| s).all(|(p, _)| *p != sum[0].0), "leads alone");
        }
        // The span is kept: β of any parameters without the zeros follows from the new sums.
        let p: Vec<f64> =
            (0..20).map(|k| if [1, 3, 12].contains(&k) { 0.0 } else { (k as f64).sin() }).collect();
        let gamma = less.values(&p);
        for (k, beta) in base().values(&p).into_iter().enumerate() {
            // Columns of the leading parameters carry the new regressor.
            let of = |lead: usize| base().sums[k].iter().find(|(c, _)| *c == lead).map_or(0.0, |(_, f)| *f);
            let again: f64 = less.sums.iter().zip(&gamma).map(|(sum, g)| of(sum[0].0) * g).sum();
            assert!((again - beta).abs() < 1e-14, "{again} {beta}");
        }
    }
}
