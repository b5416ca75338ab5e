//! Time stepping against closed forms, identities, and another solver.
mod allocation;
mod bodies;
mod cone_program;
mod impacts;
mod joints;
mod landing;
mod motion;
mod motors;
mod rest;
mod sharing;
mod soft;
mod soles;
mod solver;
mod torques;
mod walkers;

/// Random numbers in -1 to 1, the same every time (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
    fn fill(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.next()).collect()
    }
}
