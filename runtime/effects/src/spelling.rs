//! Names that are nearly right.

/// Likeness (Jaro–Winkler) from which on a name may be a likely misspelling: beginnings count most.
const ALIKE: f64 = 0.8;

/// The candidate that was probably meant: the one with fewest wrong letters if these are few, else one that begins alike.
pub fn did_you_mean<'c>(written: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    let limit = written.chars().count().div_ceil(3).clamp(1, 4);
    let (mut nearest, mut likest) = (None, None);
    for candidate in candidates {
        let distance = strsim::damerau_levenshtein(written, candidate);
        let near = distance <= limit && candidate.len() > distance;
        if near && nearest.is_none_or(|(least, _)| distance < least) {
            nearest = Some((distance, candidate));
        }
        let likeness = strsim::jaro_winkler(written, candidate);
        if likeness > likest.map_or(ALIKE, |(most, _)| most) {
            likest = Some((likeness, candidate));
        }
    }
    nearest.map(|(_, name)| name).or(likest.map(|(_, name)| name))
}

/// "did you mean `x`?", or what else there is to say.
pub fn suggest<'c>(
    written: &str,
    candidates: impl IntoIterator<Item = &'c str>,
    otherwise: impl FnOnce() -> String,
) -> String {
    did_you_mean(written, candidates).map_or_else(otherwise, |meant| format!("did you mean `{meant}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn likely_misspellings() {
        assert_eq!(did_you_mean("left_kne", ["right_knee", "left_knee", "left_hip"]), Some("left_knee"));
        assert_eq!(
            did_you_mean("left_knee/pos", ["left_hip/position", "left_knee/position"]),
            Some("left_knee/position")
        );
        assert_eq!(did_you_mean("wheel", ["right_knee", "left_knee"]), None);
        assert_eq!(did_you_mean("", ["x", "torso"]), None);
    }
}
