//! Nuisance parameters that displace the markers by a fixed pattern, at their optimum for a shape.
//!
//! A shape and such patterns trade off along a curved valley of the misfit: a step of all unknowns together would have to be short. The misfit with the
//! patterns at their optimum has no such valley (variable projection; Golub and Pereyra, Inverse Problems 19, 2003).

use super::linearised::Linearised;
use super::marker_motion::{Posed, fixed_pattern};
use super::priors::{PriorRow, Priors};
use super::touching::Touching;
use super::unknowns::Unknown;
use super::values::Nuisances;
use crate::measurement::{Measurement, SharedError};
use crate::mesh::Mesh;
use crate::optimise::GramSchmidt;

/// The nuisance parameters of `shape`, but with shared errors and the position of the base at their optimum. `None` without shared errors, or if they
/// are not identifiable. The conditions of contact with an object are linear in these parameters to first order.
pub(super) fn project(
    (unknowns, shared_errors, priors): (&[Unknown], &[SharedError], &Priors),
    (mesh, object): (&Mesh, Option<&Touching>),
    linearised: &Linearised,
    shape: Posed,
    measurement: &Measurement,
) -> Option<Nuisances> {
    shared_errors.first()?;
    let pattern = |unknown: Unknown, key_node: usize| fixed_pattern(unknown, shared_errors, key_node);
    let sought: Vec<usize> = (0..unknowns.len()).filter(|&j| pattern(unknowns[j], 0).is_some()).collect();
    let rows: Vec<PriorRow> =
        priors.rows(shape.nuisances, shape.forces_n).filter(|row| sought.contains(&row.index)).collect();
    let markers = measurement.markers();
    let coordinates = measurement.coordinate_count();
    let below_priors = coordinates + rows.len();
    let misses_mm: Vec<f64> =
        object.iter().flat_map(|object| object.misses_mm(mesh, shape, priors.marker_noise_mm())).collect();
    let mut problem = GramSchmidt::default();
    problem.reset(below_priors + misses_mm.len(), sought.len());
    for (column, &j) in sought.iter().enumerate() {
        let column = problem.column_mut(column);
        for (marker, of_marker) in markers.iter().zip(column.chunks_exact_mut(2)) {
            let pattern_mm = pattern(unknowns[j], marker.node.0 - 1).unwrap_or_default();
            of_marker.copy_from_slice((pattern_mm * linearised.weight(marker)).as_slice());
        }
        for (value, row) in column[coordinates..].iter_mut().zip(&rows) {
            *value = if row.index == j { row.by_unknown } else { 0.0 };
        }
        column[below_priors..].copy_from_slice(linearised.touch_rates(j));
    }
    let right = problem.column_mut(sought.len());
    for (marker, of_marker) in markers.iter().zip(right.chunks_exact_mut(2)) {
        of_marker.copy_from_slice(linearised.distance(marker, shape).as_slice());
    }
    for (value, row) in right[coordinates..].iter_mut().zip(&rows) {
        *value = row.left_mm;
    }
    right[below_priors..].iter_mut().zip(&misses_mm).for_each(|(value, missed_mm)| *value = -missed_mm);
    let mut nuisances = shape.nuisances.clone();
    for (&j, &by) in sought.iter().zip(problem.solve()?) {
        nuisances.change(unknowns[j], by, shared_errors);
    }
    Some(nuisances)
}
