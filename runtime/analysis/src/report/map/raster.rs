//! A raster of colours as a small picture inside another one.
use crate::gait::Reason;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Crc;
use flate2::write::ZlibEncoder;
use std::io::Write;

/// Shades of the scale of speeds; the other entries of a palette are reasons. A palette of bytes has 256 entries: with one more, browsers show nothing.
const SHADES: usize = 256 - Reason::ALL.len();
/// Colours of the scale at equal distances, from slow to fast: lightness grows evenly, for all eyes (viridis).
const SCALE: [[u8; 3]; 9] = [
    [0x44, 0x01, 0x54],
    [0x47, 0x2d, 0x7b],
    [0x3b, 0x52, 0x8b],
    [0x2c, 0x72, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x28, 0xae, 0x80],
    [0x5e, 0xc9, 0x62],
    [0xad, 0xdc, 0x30],
    [0xfd, 0xe7, 0x25],
];

/// The colour of a part of the scale, from 0 to 1.
pub(super) fn shade(part: f64) -> [u8; 3] {
    let place = part.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let below = (place as usize).min(SCALE.len() - 2);
    let rest = place - below as f64;
    std::array::from_fn(|k| {
        let (a, b) = (f64::from(SCALE[below][k]), f64::from(SCALE[below + 1][k]));
        (a + rest * (b - a)).round() as u8
    })
}

/// The colour of a reason: greys where the step does not come about, warm colours where an assumption does not hold.
pub(super) fn colour(reason: Reason) -> [u8; 3] {
    match reason {
        Reason::Passes | Reason::NotComputed => [0xff, 0xff, 0xff],
        Reason::FallsBack => [0xdd, 0xdd, 0xdd],
        Reason::GuardNotReached => [0xb4, 0xb4, 0xb4],
        Reason::NoPosture => [0x8c, 0x8c, 0x8c],
        Reason::NotFinite => [0x60, 0x60, 0x60],
        Reason::NotOnTheGround => [0x9c, 0x8a, 0x7c],
        Reason::OutputsJump => [0x7a, 0x5c, 0x44],
        Reason::NoPhaseLeft => [0xc4, 0xb0, 0x9c],
        Reason::TurnsBack => [0xb0, 0x88, 0xa8],
        Reason::Singular => [0x38, 0x38, 0x38],
        Reason::PhaseWithoutEnd => [0x88, 0x9c, 0x7c],
        Reason::OutputsMissed => [0x5c, 0x70, 0x8c],
        Reason::Slips => [0xe6, 0x9f, 0x00],
        Reason::Pulls => [0xd5, 0x5e, 0x00],
        Reason::Scuffs => [0xf4, 0xb6, 0xc8],
        Reason::Torque => [0x8b, 0x1e, 0x3f],
        Reason::Stop => [0xb8, 0x3c, 0x8c],
        Reason::Velocity => [0x5b, 0x3a, 0x9e],
    }
}

/// As style sheets have it.
pub(super) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Values in the scale's colours, reasons in theirs where they are not [`Reason::Passes`], as the address of a PNG. The first row is
/// the lowest one of the picture.
pub(super) fn raster(values: &[f64], reasons: &[Reason], columns: usize, [low, high]: [f64; 2]) -> String {
    let index = |value: f64, reason: Reason| {
        let shade =
            ((value - low) / (high - low) * (SHADES - 1) as f64).round().clamp(0.0, (SHADES - 1) as f64);
        let of_reason = Reason::ALL.iter().position(|known| *known == reason).unwrap_or(0);
        if reason == Reason::Passes { shade as usize } else { SHADES + of_reason }
    };
    let pixels: Vec<u8> = values.iter().zip(reasons).map(|(&v, &r)| index(v, r) as u8).collect();
    let shades = (0..SHADES).map(|k| shade(k as f64 / (SHADES - 1) as f64));
    let palette: Vec<u8> = shades.chain(Reason::ALL.map(colour)).flatten().collect();
    let png = png(&pixels, columns, &palette);
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// A PNG of one byte per pixel. Rows are stored from below.
fn png(pixels: &[u8], columns: usize, palette: &[u8]) -> Vec<u8> {
    let rows = pixels.len().checked_div(columns).unwrap_or(0);
    let mut file = vec![0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n'];
    let size = [columns, rows].map(|x| (x as u32).to_be_bytes()).concat();
    // Eight bits, a palette, the only compression and filter there are, not interlaced.
    chunk(&mut file, b"IHDR", &[&size[..], &[8, 3, 0, 0, 0]].concat());
    chunk(&mut file, b"PLTE", palette);
    let mut packed = ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    let mut whole = true;
    for row in pixels.chunks(columns.max(1)).rev() {
        // No row is stored as a difference.
        whole &= packed.write_all(&[0]).and_then(|()| packed.write_all(row)).is_ok();
    }
    // Nothing fails in memory.
    let data = packed.finish().unwrap_or_default();
    debug_assert!(whole);
    chunk(&mut file, b"IDAT", &data);
    chunk(&mut file, b"IEND", &[]);
    file
}

fn chunk(file: &mut Vec<u8>, name: &[u8; 4], data: &[u8]) {
    file.extend((data.len() as u32).to_be_bytes());
    file.extend(name);
    file.extend(data);
    let mut sum = Crc::new();
    sum.update(name);
    sum.update(data);
    file.extend(sum.sum().to_be_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn a_raster_is_a_png_with_its_lowest_row_last() {
        let reasons = [Reason::Passes, Reason::Passes, Reason::FallsBack, Reason::Passes];
        let address = raster(&[0.0, 1.0, f64::NAN, 0.5], &reasons, 2, [0.0, 1.0]);
        let file = STANDARD.decode(address.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
        assert_eq!(&file[..8], b"\x89PNG\r\n\x1a\n");
        assert_eq!(&file[16..24], [0, 0, 0, 2, 0, 0, 0, 2]);
        let place = file.windows(4).position(|name| name == b"IDAT").unwrap();
        let length = u32::from_be_bytes(file[place - 4..place].try_into().unwrap()) as usize;
        let mut pixels = Vec::new();
        flate2::read::ZlibDecoder::new(&file[place + 4..place + 4 + length])
            .read_to_end(&mut pixels)
            .unwrap();
        let fallen = SHADES as u8 + 1;
        let middle = (0.5 * (SHADES - 1) as f64).round() as u8;
        assert_eq!(pixels, [0, fallen, middle, 0, 0, SHADES as u8 - 1]);
        // All entries of a palette of bytes, and not one more.
        let place = file.windows(4).position(|name| name == b"PLTE").unwrap();
        assert_eq!(file[place - 4..place], (3_u32 * 256).to_be_bytes());
        assert_eq!(file[place + 4 + 3 * 255..][..3], colour(Reason::ALL[Reason::ALL.len() - 1]));
    }

    #[test]
    fn every_reason_has_a_colour_of_its_own() {
        let colours: std::collections::BTreeSet<[u8; 3]> = Reason::ALL.map(colour).into_iter().collect();
        // What passes has the scale; it shares white with what is missing.
        assert_eq!(colours.len(), Reason::ALL.len() - 1);
        assert_eq!((shade(0.0), shade(1.0), shade(2.0)), (SCALE[0], SCALE[8], SCALE[8]));
    }
}
