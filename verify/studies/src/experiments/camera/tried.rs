//! A force at one node under one condition: displacements are observed, and the force is sensed from them.

use super::conditions::{Change, Condition, ImageChange};
use super::{Bent, ExperimentError};
use crate::prelude::*;
use finray_imaging::locate::Observer;
use finray_imaging::render::{RenderRequest, render};

/// Displacements observed by a camera, mm, and their stated standard deviation, mm.
struct Seen {
    displacements: Vec<(NodeId, Vector)>,
    sd_mm: Option<f64>,
}

/// Results for one deformed finger under one condition.
pub(super) struct Tried {
    /// Errors of the observed coordinates, mm.
    pub errors_mm: Vec<f64>,
    /// Stated standard deviation of a coordinate, mm; `None` if no marker states one.
    pub sd_mm: Option<f64>,
    /// Number of markers found.
    pub found: usize,
    /// Error sensed / true - 1. The next field, `first_order`, is the error sensed / true - 1 to first order.
    pub sensed: Option<f64>,
    pub first_order: Option<f64>,
}

/// Observes and senses one deformed finger; `None` if the camera does not see the finger, or if the finer finger has no equilibrium.
pub(super) fn tried(
    mesh: &Mesh,
    (number, bent): (usize, &Bent),
    condition: &Condition,
    camera: &Camera,
    markers: &Markers,
) -> Result<Option<Tried>, ExperimentError> {
    let finger = mesh.finger();
    let mut shape = &bent.shape;
    let finer;
    let seen = match &condition.change {
        Change::Image(change) => change
            .applied(camera, markers)
            .and_then(|(camera, markers)| in_image(finger, shape, &camera, &markers, change, number as u64)),
        Change::Assumed(change) => {
            let seen_by = (camera, markers.height_mm);
            let read = change.applied(camera, markers);
            read.and_then(|read| projected(finger, shape, seen_by, read, condition.is_rest_seen))
        }
        Change::FinerFinger(times) => {
            let Ok(bent) = statics::solve(&mesh.refined(*times), &[bent.load], Kinematics::Corotational) else {
                return Ok(None);
            };
            finer = bent;
            shape = &finer;
            let displacements =
                finger.marked_nodes().map(|node| (node, shape.motion(node).marker_displacement(finger)));
            Some(Seen { displacements: displacements.collect(), sd_mm: None })
        }
    };
    let Some(seen) = seen else { return Ok(None) };
    let of_node = |node: NodeId| shape.motion(node).marker_displacement(finger);
    let error = |(node, displacement): &(NodeId, Vector)| displacement - of_node(*node);
    let is_seen = !matches!(condition.change, Change::FinerFinger(_));
    let coordinates = seen.displacements.iter().filter(|_| is_seen).flat_map(|one| [error(one).x, error(one).y]);
    // First-order least squares: the displacement errors are projected onto the response and divided by the squared norm of the response.
    let (mut product, mut squares) = (0.0, 0.0);
    for one in &seen.displacements {
        let along = bent.along.iter().find(|(node, _)| *node == one.0).map_or_else(Vector::zeros, |(_, along)| *along);
        product += along.dot(&error(one));
        squares += along.norm_squared();
    }
    let mut tried = Tried {
        errors_mm: coordinates.collect(),
        sd_mm: seen.sd_mm,
        found: seen.displacements.len(),
        sensed: None,
        first_order: None,
    };
    let marker = |&(node, displacement): &(NodeId, Vector)| Marker { node, displacement, weight: 1.0 };
    let Ok(measurement) = Measurement::new(finger, seen.displacements.iter().map(marker)) else {
        return Ok(Some(tried));
    };
    let mut estimator = NonlinearEstimator::new(mesh, &[Contact::at_node(bent.node).into()])?;
    // Without stated noise, the estimator computes the noise from the residual.
    if let Ok(estimate) = estimator.estimate(&measurement, seen.sd_mm) {
        tried.sensed = Some(estimate.forces.forces_n[0] / bent.force_n - 1.0);
        tried.first_order = is_seen.then_some(product / squares / bent.force_n);
    }
    Ok(Some(tried))
}

/// Displacements of markers located in an image; `None` if the locator refuses the image, or the markers are too small, grey or out of view.
fn in_image(
    finger: &Finger,
    shape: &FingerShape,
    camera: &Camera,
    markers: &Markers,
    change: &ImageChange,
    seed: u64,
) -> Option<Seen> {
    let disturbances = change.disturbances(seed);
    let image = render(&RenderRequest { disturbances, ..RenderRequest::of(camera, finger, shape, markers) }).ok()?;
    let mut observer = Observer::with(finger, camera, markers, None).ok()?;
    let observed = observer.observe(&change.compressed(image)?).ok()?;
    let clamped = finger.clamped_nodes();
    let free: Vec<_> = observed.markers.iter().filter(|marker| !clamped.contains(&marker.node)).collect();
    Some(Seen {
        displacements: free.iter().filter_map(|marker| Some((marker.node, marker.displacement?))).collect(),
        sd_mm: rms(free.iter().filter_map(|marker| marker.sd_mm)),
    })
}

/// Displacements of points that one camera projects and a second camera reads; `None` if either camera does not see the finger.
fn projected(
    finger: &Finger,
    shape: &FingerShape,
    (camera, height_mm): (&Camera, f64),
    (read, read_height_mm): (Camera, f64),
    is_rest_seen: bool,
) -> Option<Seen> {
    let seen = |at: Vector| read.on_plane(&camera.project(&at.push(height_mm)).ok()?, read_height_mm).ok();
    let displacement = |node: NodeId| {
        let rest = finger.marker_position(node);
        let from = if is_rest_seen { seen(rest)? } else { rest };
        Some((node, seen(rest + shape.motion(node).marker_displacement(finger))? - from))
    };
    let displacements = finger.marked_nodes().map(displacement).collect::<Option<Vec<_>>>()?;
    Some(Seen { displacements, sd_mm: None })
}
