//! Distribution of elements over the lines of a mesh: plate members, ribs and base line.

/// Distributes `total` elements over lines in proportion to their lengths by largest remainder (Hamilton's method). Each line gets at least one
/// element. Equal remainders favour the earlier line. `total` must be at least the number of lines.
pub(super) fn by_largest_remainder(total: usize, lengths: &[f64]) -> Vec<usize> {
    // A line whose proportional share (its quota) is below one element gets one element. The lines with larger quotas share the remaining elements.
    // Some of their new quotas may fall below one, so the loop repeats.
    let mut shares = vec![1; lengths.len()];
    let mut sharing: Vec<usize> = (0..lengths.len()).collect();
    loop {
        let left = total - (lengths.len() - sharing.len());
        let length: f64 = sharing.iter().map(|&i| lengths[i]).sum();
        let quota = |i: usize| left as f64 * lengths[i] / length;
        let (enough, too_short): (Vec<usize>, Vec<usize>) = sharing.iter().partition(|&&i| quota(i) >= 1.0);
        if too_short.is_empty() || enough.is_empty() {
            for &i in &sharing {
                shares[i] = (quota(i).floor() as usize).max(1);
            }
            let mut by_remainder = sharing.clone();
            // Rounding may give equal plates slightly different lengths, so remainders are compared to nine decimal places.
            let remainder = |i: usize| (quota(i).fract() * 1e9).round() as i64;
            by_remainder.sort_by_key(|&i| (-remainder(i), i));
            let given: usize = sharing.iter().map(|&i| shares[i]).sum();
            for &i in by_remainder.iter().take(left.saturating_sub(given)) {
                shares[i] += 1;
            }
            return shares;
        }
        sharing = enough;
    }
}

#[cfg(test)]
#[path = "../../tests/units/apportion.rs"]
mod tests;
