//! Lines of constant value over a grid (marching squares).

/// A point in units of the grid: column and row.
pub(super) type Point = [f64; 2];

/// The level's lines as short pieces, through every square whose four corners are numbers. In a saddle the mean of the corners
/// says which corners belong together.
pub(super) fn contour(values: &[f64], columns: usize, level: f64) -> Vec<[Point; 2]> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    let mut lines = Vec::new();
    for row in 0..rows.saturating_sub(1) {
        for column in 0..columns.saturating_sub(1) {
            let at = |x: usize, y: usize| values[(row + y) * columns + column + x] - level;
            // Around the square: along the first row, up, back, down.
            let corners = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            if corners.iter().all(|x| x.is_finite()) {
                square(corners, [column as f64, row as f64], &mut lines);
            }
        }
    }
    lines
}

/// Places of the corners of a square.
const PLACES: [Point; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

fn square(corners: [f64; 4], origin: Point, lines: &mut Vec<[Point; 2]>) {
    // The edge from corner k to the next one, where it is crossed.
    let crossed = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        ((a < 0.0) != (b < 0.0)).then(|| {
            let (part, from, to) = (a / (a - b), PLACES[k], PLACES[(k + 1) % 4]);
            std::array::from_fn(|i| origin[i] + from[i] + part * (to[i] - from[i]))
        })
    };
    let found: Vec<Point> = (0..4).filter_map(crossed).collect();
    match found[..] {
        [a, b] => lines.push([a, b]),
        [a, b, c, d] => {
            let middle = corners.iter().sum::<f64>();
            // Edges 0 and 3 meet in corner 0: it is cut off unless it belongs to the middle.
            if (corners[0] < 0.0) == (middle < 0.0) {
                lines.extend([[a, b], [c, d]]);
            } else {
                lines.extend([[a, d], [b, c]]);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_is_a_closed_line_of_its_radius() {
        // Through no point of the grid: there lines of no length meet.
        let (count, radius) = (41, 14.77);
        let values: Vec<f64> = (0..count * count)
            .map(|k| (((k % count) as f64 - 20.0).powi(2) + ((k / count) as f64 - 20.0).powi(2)).sqrt())
            .collect();
        let lines = contour(&values, count, radius);
        for point in lines.iter().flatten() {
            assert!(((point[0] - 20.0).hypot(point[1] - 20.0) - radius).abs() < 0.02, "{point:?}");
        }
        let length: f64 = lines.iter().map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum();
        assert!((length / (2.0 * std::f64::consts::PI * radius) - 1.0).abs() < 2e-3, "{length}");
        // Closed: every end is the end of exactly two pieces.
        let ends: Vec<[i64; 2]> =
            lines.iter().flatten().map(|p| p.map(|x| (x * 1e6).round() as i64)).collect();
        assert!(ends.iter().all(|end| ends.iter().filter(|other| *other == end).count() == 2));
    }

    #[test]
    fn squares_with_a_gap_have_no_line() {
        assert_eq!(contour(&[0.0, 1.0, f64::NAN, 1.0], 2, 0.5).len(), 0);
        assert_eq!(contour(&[0.0, 1.0, 0.0, 1.0], 2, 0.5), [[[0.5, 0.0], [0.5, 1.0]]]);
        assert_eq!(contour(&[0.0, 1.0, 1.0, 0.0], 2, 0.4).len(), 2);
        assert_eq!(contour(&[], 0, 0.0).len(), 0);
    }
}
