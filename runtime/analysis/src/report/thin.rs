//! Fewer samples that look the same: extremes are kept.

/// Which samples stay.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Thinned {
    /// Indices of the samples, increasing.
    pub kept: Vec<usize>,
    /// Indices into `kept` of samples that were chosen for their place alone: a fair choice for scatter plots, which
    /// extremes would spoil.
    pub fair: Vec<usize>,
}

/// At most about `most` of `count` samples: from each stretch its first, and the least and largest value of each
/// track. A value that is not finite stays too, so that a gap is seen.
pub(super) fn thin(count: usize, tracks: &[Vec<f64>], most: usize) -> Thinned {
    if count <= most {
        return Thinned { kept: (0..count).collect(), fair: (0..count).collect() };
    }
    let stretches = (most / (1 + 2 * tracks.len())).max(1);
    let mut thinned = Thinned::default();
    for k in 0..stretches {
        let (from, to) = (k * count / stretches, (k + 1) * count / stretches);
        let mut chosen = vec![from];
        for track in tracks {
            let values = (from..to).map(|i| (i, track.get(i).copied().unwrap_or(f64::NAN)));
            let finite = || values.clone().filter(|(_, x)| x.is_finite());
            let extremes =
                [finite().min_by(|a, b| a.1.total_cmp(&b.1)), finite().max_by(|a, b| a.1.total_cmp(&b.1))];
            let gap = values.clone().find(|(_, x)| !x.is_finite());
            chosen.extend(extremes.into_iter().chain([gap]).flatten().map(|(i, _)| i));
        }
        chosen.sort_unstable();
        chosen.dedup();
        thinned.fair.push(thinned.kept.len());
        thinned.kept.extend(chosen);
    }
    thinned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_and_gaps_survive() {
        let mut track: Vec<f64> = (0..10_000).map(|i| (0.01 * f64::from(i)).sin()).collect();
        track[1234] = 7.0;
        track[4321] = -9.0;
        track[7777] = f64::NAN;
        let thinned = thin(track.len(), &[track.clone()], 300);
        assert!(thinned.kept.len() <= 301);
        assert!(thinned.kept.is_sorted());
        for i in [0, 1234, 4321, 7777] {
            assert!(thinned.kept.contains(&i), "{i}");
        }
        assert_eq!(thinned.fair.len(), 100);
        assert_eq!(thin(5, &[], 10).kept, [0, 1, 2, 3, 4]);
        assert_eq!(thin(0, &[], 10), Thinned::default());
    }
}
