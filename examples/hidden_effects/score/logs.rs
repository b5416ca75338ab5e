//! Reading logs of hanging robots, as written by the generator or by others.
use crate::generator::oracle::{HangingLog, JointLog};
use crate::generator::{Failure, failure};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

/// Reads a log, gzip or not.
///
/// # Errors
/// It cannot be read, has other columns, or cells that are no numbers.
pub fn read(path: &Path, joints: &[String]) -> Result<HangingLog, Failure> {
    let error = |what: String| failure(format!("{}: {what}", path.display()));
    let bytes = std::fs::read(path).map_err(|e| error(e.to_string()))?;
    let mut text = String::new();
    if bytes.starts_with(&[0x1f, 0x8b]) {
        flate2::read::GzDecoder::new(&bytes[..])
            .read_to_string(&mut text)
            .map_err(|e| error(e.to_string()))?;
    } else {
        text = String::from_utf8(bytes).map_err(|e| error(e.to_string()))?;
    }
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut columns: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (row, line) in lines.enumerate() {
        for (name, cell) in header.iter().zip(line.split(',')) {
            let value =
                cell.parse().map_err(|_| error(format!("line {}: `{cell}` is no number", row + 2)))?;
            columns.entry(name).or_default().push(value);
        }
    }
    let mut take = |name: &str| columns.remove(name).ok_or_else(|| error(format!("no column `{name}`")));
    let time = take("time")?;
    let joints = joints.iter().map(|name| {
        Ok(JointLog {
            name: name.clone(),
            position: take(&format!("{name}/position"))?,
            effort: take(&format!("{name}/effort"))?,
            motor: take(&format!("{name}/motor_position")).unwrap_or_default(),
        })
    });
    let joints = joints.collect::<Result<Vec<_>, Failure>>()?;
    let step = time.get(1).zip(time.first()).map_or(0.0, |(b, a)| b - a);
    if step <= 0.0 {
        return Err(error("time does not increase".to_owned()));
    }
    Ok(HangingLog { rate: (1.0 / step).round(), time, joints })
}
