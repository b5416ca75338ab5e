//! What steps are acceptable: pairs of violation and barrier function that none may be worse than in both.

/// Pairs (θ, φ) that were left behind.
#[derive(Debug, Clone)]
pub(super) struct Filter {
    entries: Vec<[f64; 2]>,
    largest: f64,
}

/// By how much a step has to be better.
const MARGIN: f64 = 1e-5;

impl Filter {
    /// Violations above `largest` are never acceptable.
    pub fn below(largest: f64) -> Self {
        Self { entries: Vec::new(), largest }
    }

    /// Whether no entry is better in both.
    pub fn accepts(&self, violation: f64, barrier: f64) -> bool {
        violation <= self.largest
            && violation.is_finite()
            && barrier.is_finite()
            && self.entries.iter().all(|&[v, b]| violation <= (1.0 - MARGIN) * v || barrier <= b - MARGIN * v)
    }

    /// Remembers a pair.
    pub fn add(&mut self, violation: f64, barrier: f64) {
        self.entries.retain(|&[v, b]| v < violation || b < barrier);
        self.entries.push([violation, barrier]);
    }

    /// Forgets all pairs.
    pub fn clear(&mut self) {
        self.entries.clear();
    }

    /// Whether a step is sufficiently better than where it began.
    pub fn improves([violation, barrier]: [f64; 2], [v, b]: [f64; 2]) -> bool {
        violation <= (1.0 - MARGIN) * v || barrier <= b - MARGIN * v
    }
}
