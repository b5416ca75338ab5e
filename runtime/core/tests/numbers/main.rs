//! Sine, cosine, exp and tanh against exact values; the same bits in lanes, arrays and scalars.
#![allow(missing_docs)]
mod exponential;
mod lanes;
mod levels;
mod sin_cos;

/// Lines of a packed table.
fn unpacked(table: &[u8]) -> Vec<String> {
    std::io::BufRead::lines(std::io::BufReader::new(flate2::read::GzDecoder::new(table)))
        .map(|line| line.unwrap())
        .collect()
}
