//! Force sensors that show nothing below zero. While their foot carries nothing, what is left of their noise has a mean that no ground
//! pushes with: some tenths of a newton, as much as a payload of some grams.
use super::columns::FootColumns;
use crate::log::Block;

/// Part of the weight below which a foot may carry nothing.
const LIGHT: f64 = 0.01;
/// Fewer readings of exactly zero are chance.
const ENOUGH: usize = 5;
/// With more of them than this part there is no noise.
const SILENT: f64 = 0.7;

/// What was taken away from the readings of a foot.
#[derive(Debug, Default)]
pub(super) struct Removed {
    sum: f64,
    samples: usize,
}

impl Removed {
    /// In words; nothing if nothing was.
    pub fn told(&self, foot: &str) -> Option<String> {
        let mean = self.sum / self.samples as f64;
        (self.samples > 0).then(|| {
            format!(
                "`{foot}` shows no force below zero: while it carries nothing, the mean of its noise ({mean:.3} N) is taken away"
            )
        })
    }
}

/// The columns of a block without the mean of what the vertical forces of feet, whole and by corner, show while they carry nothing;
/// `None` if none of them is one-sided. `weight` in N.
pub(super) fn without_means(
    feet: &[FootColumns],
    block: &Block<'_>,
    weight: f64,
    removed: &mut [Removed],
) -> Option<Vec<Vec<f64>>> {
    let mut all = None;
    for (foot, removed) in feet.iter().zip(removed) {
        let vertical = foot.force[2].iter().chain(foot.corners.iter().flatten());
        for &column in vertical {
            for range in silent(&block.columns[column], LIGHT * weight) {
                let values = &mut all.get_or_insert_with(|| block.columns.to_vec())[column][range];
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                values.iter_mut().for_each(|value| *value -= mean);
                removed.sum += mean * values.len() as f64;
                removed.samples += values.len();
            }
        }
    }
    all
}

/// Stretches, from one reading of exactly zero to another, in which a sensor without readings below zero shows noise and nothing else.
fn silent(force: &[f64], light: f64) -> Vec<std::ops::Range<usize>> {
    if force.iter().any(|f| *f < 0.0) {
        return Vec::new();
    }
    let mut found = Vec::new();
    let mut begin = 0;
    for stretch in force.split(|f| *f > light) {
        let is_zero = |&i: &usize| stretch[i] == 0.0;
        let (first, last) = ((0..stretch.len()).find(is_zero), (0..stretch.len()).rfind(is_zero));
        if let (Some(first), Some(last)) = (first, last) {
            let zeros = (first..=last).filter(is_zero).count();
            if zeros >= ENOUGH && (zeros as f64) < SILENT * (last + 1 - first) as f64 {
                found.push(begin + first..begin + last + 1);
            }
        }
        begin += stretch.len() + 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_about_nothing_is_found_and_a_light_touch_is_not() {
        let noise = |i: usize| (7.1 * i as f64).sin().max(0.0);
        let stands = |i: usize| if (100..200).contains(&i) { 80.0 } else { noise(i) };
        let force: Vec<f64> = (0..300).map(stands).collect();
        let found = silent(&force, 2.0);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(
            found[0].start < 3 && found[0].end > 95 && found[1].start < 205 && found[1].end > 295,
            "{found:?}"
        );
        // Of a sensor that is centred on zero nothing is taken.
        let both: Vec<f64> = (0..300).map(|i| (7.1 * i as f64).sin()).collect();
        assert!(silent(&both, 2.0).is_empty());
        // Without noise.
        let touch: Vec<f64> = (0..300).map(|i| if (140..160).contains(&i) { 1.0 } else { 0.0 }).collect();
        assert!(silent(&touch, 2.0).is_empty());
    }
}
