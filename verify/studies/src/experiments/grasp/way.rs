//! The gripper's path: a polyline from the origin.

use finray_model::Vector;

/// Lengths of a path's segments, mm.
fn lengths(path: &[Vector]) -> Vec<f64> {
    let from = std::iter::once(Vector::zeros()).chain(path.iter().copied());
    from.zip(path).map(|(from, to)| (to - from).norm()).collect()
}

/// Index of the segment at a share (0 to 1) of a path's length.
pub(super) fn part_of_way(path: &[Vector], share: f64) -> usize {
    let lengths = lengths(path);
    let mut left = share * lengths.iter().sum::<f64>() * (1.0 - 1e-12);
    for (part, length) in lengths.iter().enumerate() {
        if left <= *length {
            return part;
        }
        left -= length;
    }
    path.len().saturating_sub(1)
}

/// Point at a share (0 to 1) of a path's length, mm.
pub(super) fn on_way(path: &[Vector], share: f64) -> Vector {
    let part = part_of_way(path, share);
    let (lengths, end) = (lengths(path), path[part]);
    let from = if part == 0 { Vector::zeros() } else { path[part - 1] };
    let before: f64 = lengths[..part].iter().sum();
    let left = share * lengths.iter().sum::<f64>() - before;
    if lengths[part] > 0.0 { from.lerp(&end, (left / lengths[part]).min(1.0)) } else { end }
}
