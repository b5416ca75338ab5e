//! The hash of a file's bytes, found while they are read for something else.
use std::io::{self, Read};
use std::sync::{Arc, OnceLock};

/// FNV-1a of a file's bytes, once somebody has read all of them; all clones of a log share it.
pub(super) type Hash = Arc<OnceLock<u64>>;

/// Passes bytes on and tells their hash when they end.
pub(super) struct Hashing<R> {
    source: R,
    state: u64,
    found: Hash,
}

impl<R: Read> Hashing<R> {
    /// `source` stands at its beginning.
    pub fn new(source: R, found: &Hash) -> Self {
        Self { source, state: 0xcbf2_9ce4_8422_2325, found: Arc::clone(found) }
    }
}

impl<R: Read> Read for Hashing<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.source.read(buffer)?;
        if count == 0 && !buffer.is_empty() {
            self.found.get_or_init(|| self.state);
        }
        for byte in &buffer[..count] {
            self.state = (self.state ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_told_at_the_end_and_not_before() {
        let found = Hash::default();
        let mut source = Hashing::new(&b"foobar"[..], &found);
        source.read_exact(&mut [0; 6]).unwrap();
        assert_eq!((source.read(&mut []).unwrap(), found.get()), (0, None));
        assert_eq!(source.read(&mut [0; 8]).unwrap(), 0);
        // From the tables of those who invented it.
        assert_eq!(found.get(), Some(&0x8594_4171_f739_67e8));
    }
}
