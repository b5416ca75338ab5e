//! `ros2 topic echo --csv` of joint states: rows without a header, in which the joints' names stand themselves.
//!
//! One message is one row, its fields in the order of `sensor_msgs/JointState`: seconds, nanoseconds, the frame, then the
//! arrays of names, positions, velocities and efforts, one number after the other; an array without numbers leaves one field
//! empty (`message_to_csv` of rosidl_runtime_py).
use bipedc_analysis::log::{Field, RawRow};

/// Seconds, nanoseconds and frame of the stamp.
const HEAD: usize = 3;

/// Names for the columns if a row looks like a joint state.
pub(super) fn columns(row: &RawRow<'_>) -> Option<Vec<String>> {
    let whole = |k: usize| matches!(row.field(k), Field::Number(x) if x >= 0.0 && x.fract() == 0.0);
    let stamped = whole(0) && whole(1) && matches!(row.field(1), Field::Number(x) if x < 1e9);
    if !stamped || matches!(row.field(2), Field::Number(_)) {
        return None;
    }
    let is_name = |k: usize| matches!(row.field(k), Field::Text(_));
    let joints: Vec<&str> = (HEAD..row.width()).take_while(|&k| is_name(k)).map(|k| row.text(k)).collect();
    if joints.is_empty() {
        return None;
    }
    let head = ["header/stamp/sec", "header/stamp/nanosec", "header/frame_id"].map(str::to_owned);
    let mut names: Vec<String> = head.to_vec();
    names.extend((0..joints.len()).map(|k| format!("name[{k}]")));
    for quantity in ["position", "velocity", "effort"] {
        let at = names.len();
        if row.width() > at && matches!(row.field(at), Field::Absent) && row.text(at).is_empty() {
            names.push(format!("{quantity}[]"));
        } else {
            names.extend(joints.iter().map(|joint| format!("{joint}/{quantity}")));
        }
    }
    (names.len() == row.width()).then_some(names)
}

/// Whether the row has the same joints at the same places as the first one had.
pub(super) fn same_joints(names: &[String], row: &RawRow<'_>) -> bool {
    let joints = names.iter().skip(HEAD).take_while(|name| name.starts_with("name[")).count();
    let first = HEAD + joints;
    row.width() == names.len()
        && (0..joints).all(|k| match names.get(first + k) {
            Some(name) if name.ends_with("/position") => {
                name.strip_suffix("/position") == Some(row.text(HEAD + k))
            }
            _ => true,
        })
}
