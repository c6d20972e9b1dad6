//! Effects of noise, blur, resolution, markers, compression, lens, pose and height on the displacements and forces derived from images.
//!
//! A known force at a node deforms the finger. The scene's camera sees the finger in a rendered image, in which the markers are located. The
//! estimator uses the same beam model as the simulated finger, so all errors come from the camera. Errors in the assumed camera (lens, pose, height)
//! need no image: points are projected by the true camera and read with the assumed camera.

mod conditions;
mod tried;

use super::{Context, Evidence, ExperimentError};
use crate::prelude::*;
use crate::sampling::bound::linearised_markers;
use conditions::{CONDITIONS, Change, Condition};
use finray_imaging::locate::Locator;
use finray_imaging::render::{RenderRequest, render};
use finray_model::scene::MarkerLook;
use finray_model::statics::Ladder;
use tried::{Tried, tried};

/// Relative error of a force that a user accepts, dimensionless.
pub const ASKED_ERROR: f64 = 0.01;
/// Tolerance of the root mean square error of a displacement coordinate in images of the scene's camera, mm. It is a fiftieth of the largest position
/// error in the paper.
pub const GOOD_POSITION_MM: f64 = 0.004;

/// Name of the condition with the scene's camera unchanged.
pub const AS_IT_IS: &str = "as it is";

/// Errors of displacements and forces under one condition of the camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraRow {
    /// Property that the condition changes: "noise", "lens", ... of the camera, or "mesh" of the finger.
    pub item: &'static str,
    /// Size of the difference, in words.
    pub setting: &'static str,
    /// Whether markers were located in rendered images; false if points were projected or no camera was used.
    pub in_images: bool,
    /// Whether displacements are relative to the undeformed finger seen by the same camera; otherwise they are relative to the scene's undeformed
    /// positions.
    pub is_rest_seen: bool,
    /// Number of markers on free (not clamped) nodes, summed over all deformed shapes.
    pub markers: usize,
    /// Number of markers that were found.
    pub found: usize,
    /// Root mean square error of a displacement's coordinate, mm; `None` for exact displacements.
    pub displacement_rms_mm: Option<f64>,
    /// Largest error of a displacement's coordinate, mm; `None` for exact displacements.
    pub displacement_largest_mm: Option<f64>,
    /// Root mean square of the stated standard deviations of a coordinate, mm.
    pub stated_mm: Option<f64>,
    /// Number of forces to sense.
    pub forces: usize,
    /// Number of forces that the estimator refused.
    pub refused: usize,
    /// Root mean square of sensed / true - 1 over the nodes whose force was sensed.
    pub force_rms_error: Option<f64>,
    /// Largest |sensed / true - 1| over the nodes whose force was sensed.
    pub force_largest_error: Option<f64>,
    /// First-order estimate of the root mean square relative force error: displacement errors are projected onto the finger's response to the force.
    pub first_order_rms_error: Option<f64>,
}

/// Noise of a coordinate at which the Cramer-Rao bound of a force at a node equals [`ASKED_ERROR`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NeededNoise {
    /// Node at which the force acts.
    pub node: NodeId,
    /// Standard deviation of a coordinate, mm.
    pub noise_mm: f64,
}

/// Errors of displacements measured by a camera, and the resulting errors of the force.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraStudy {
    /// Errors under each condition; the first is the scene's camera unchanged.
    pub rows: Vec<CameraRow>,
    /// Force along the normal that is applied to one node at a time, N.
    pub force_n: f64,
    /// Nodes at which forces were sensed.
    pub nodes: Vec<NodeId>,
    /// Largest acceptable noise for every loaded contact node, from tip to base.
    pub needed: Vec<NeededNoise>,
    /// Size of the scene's images, px.
    pub size_px: [u32; 2],
    /// Scale at the middle of the undeformed finger, px/mm; `None` if the camera does not see the finger.
    pub px_a_mm: Option<f64>,
    /// Processing times of an image in memory, on one core; `None` if the image shows no finger.
    pub times: Option<FrameTimes>,
}

/// Median times from an image in memory to node positions, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameTimes {
    /// Time with a search of the whole image, s.
    pub search_s: f64,
    /// Time with a search near the markers' previous positions, s.
    pub track_s: f64,
}

/// Camera study for scenes with a camera and coloured markers, and for the paper's finger with an assumed camera. `None` for grey markers.
pub(crate) fn run(context: &Context) -> Result<Option<CameraStudy>, ExperimentError> {
    let assumed = context.is_paper.then(|| Scene::from_toml(finray_fixtures::CAMERA_SCENE).ok()).flatten();
    let scene = &context.given.scene;
    let seen_by = |scene: &Scene| {
        let described = scene.camera?;
        let markers = scene.markers.filter(|markers| matches!(markers.look, MarkerLook::Coloured { .. }))?;
        Some((Camera { lens: described.lens, pose: described.pose? }, markers))
    };
    let Some((camera, markers)) = seen_by(scene).or_else(|| seen_by(&assumed?)) else { return Ok(None) };
    let force_n = context.checked_forces().half_n();
    CameraStudy::of(context.finger, force_n, context.effort, context.progress, (&camera, &markers)).map(Some)
}

/// A deformed finger, with the response of its free nodes to the force.
struct Bent {
    node: NodeId,
    force_n: f64,
    load: Load,
    shape: FingerShape,
    /// Derivative of each free node's displacement with respect to the force, mm/N.
    along: Vec<(NodeId, Vector)>,
}

impl CameraStudy {
    /// Studies a finger with `markers`, seen by `camera`, under a force of `force_n` (N) at one node at a time.
    ///
    /// # Errors
    /// [`ExperimentError`] if the finger's response or the estimator cannot be computed for a force.
    pub fn of(
        finger: &Finger,
        force_n: f64,
        effort: Effort,
        progress: &dyn Progress,
        (camera, markers): (&Camera, &Markers),
    ) -> Result<CameraStudy, ExperimentError> {
        let mesh = Mesh::key_nodes(finger);
        let (most_nodes, most_conditions) = effort.choose((2, 9), (6, usize::MAX));
        let conditions = &CONDITIONS[..most_conditions.min(CONDITIONS.len())];
        progress.part("camera", conditions.len());
        let loaded: Vec<NodeId> = finger.contact_nodes().filter(|node| *node != finger.tip()).collect();
        let mut statics = Statics::ladder(&mesh, Kinematics::Corotational);
        let mut all = Vec::new();
        for &node in &loaded {
            all.extend(bent(&mut statics, &mesh, node, force_n)?);
        }
        let needed = |bent: &Bent| {
            let squares: f64 = bent.along.iter().map(|(_, along)| along.norm_squared()).sum();
            NeededNoise { node: bent.node, noise_mm: ASKED_ERROR * force_n * squares.sqrt() }
        };
        let needed = all.iter().map(needed).collect();
        let every = (all.len().div_ceil(most_nodes)).max(1);
        // The selection of nodes starts at the base, where forces deform the finger least.
        let asked: Vec<&Bent> = all.iter().rev().step_by(every).collect();
        let nodes = finger.key_node_count();
        let middle = (1..=nodes).map(|node| finger.position(NodeId(node))).sum::<Vector>() / nodes as f64;
        let by_point =
            camera.project_with_derivatives(&middle.push(markers.height_mm)).ok().map(|(_, by_point)| by_point);
        let px_a_mm = by_point.map(|by_point| by_point.fixed_columns::<2>(0).determinant().abs().sqrt());
        let row = |condition: &Condition| {
            let row = condition_row(&mesh, &asked, condition, camera, markers);
            progress.step();
            row
        };
        let rows: Result<Vec<CameraRow>, ExperimentError> = conditions.par_iter().with_max_len(1).map(row).collect();
        let rows = rows?;
        // Times are measured one after the other, because parallel computations would affect them.
        let times = asked.first().and_then(|bent| frame_times(finger, &bent.shape, camera, markers));
        let nodes = asked.iter().map(|bent| bent.node).collect();
        Ok(CameraStudy { rows, force_n, nodes, needed, size_px: camera.lens.size_px(), px_a_mm, times })
    }

    /// Row of the scene's camera without a change.
    pub fn as_it_is(&self) -> Option<&CameraRow> {
        self.rows.first()
    }

    /// Relative force error at the Cramer-Rao bound for independent noise of `noise_mm` (mm): root mean square over the nodes of the rows.
    pub fn bound_rms(&self, noise_mm: f64) -> Option<f64> {
        let asked = self.needed.iter().filter(|needed| self.nodes.contains(&needed.node));
        rms(asked.map(|needed| ASKED_ERROR * noise_mm / needed.noise_mm))
    }

    /// The node that requires the smallest noise.
    pub fn worst(&self) -> Option<NeededNoise> {
        self.needed.iter().copied().min_by(|a, b| a.noise_mm.total_cmp(&b.noise_mm))
    }
}

/// Deformed finger under `force_n` (N) at a node; `None` if the finger has no equilibrium.
fn bent(
    statics: &mut Statics<Ladder>,
    mesh: &Mesh,
    node: NodeId,
    force_n: f64,
) -> Result<Option<Bent>, ExperimentError> {
    let finger = mesh.finger();
    let contact = Contact::at_node(node);
    let Some((motion, by_force)) = linearised_markers(statics, mesh, &[contact], &[force_n])? else { return Ok(None) };
    let along = finger.marked_nodes().zip(by_force.as_slice().chunks_exact(2));
    let along = along.map(|(node, along)| (node, Vector::new(along[0], along[1]))).collect();
    Ok(Some(Bent { node, force_n, load: contact.load(finger, force_n), shape: mesh.shape(&motion), along }))
}

fn condition_row(
    mesh: &Mesh,
    asked: &[&Bent],
    condition: &Condition,
    camera: &Camera,
    markers: &Markers,
) -> Result<CameraRow, ExperimentError> {
    let on_node = |(number, bent): (usize, &&Bent)| tried(mesh, (number, bent), condition, camera, markers);
    let tried: Vec<Option<Tried>> =
        asked.par_iter().enumerate().with_max_len(1).map(on_node).collect::<Result<_, _>>()?;
    let tried = || tried.iter().flatten();
    let errors_mm: Vec<f64> = tried().flat_map(|one| one.errors_mm.iter().copied()).collect();
    let sensed: Vec<f64> = tried().filter_map(|one| one.sensed).collect();
    let free = mesh.finger().marked_nodes().count();
    let size = |largest: f64, error: &f64| largest.max(error.abs());
    Ok(CameraRow {
        item: condition.item,
        setting: condition.setting,
        in_images: matches!(condition.change, Change::Image(_)),
        is_rest_seen: condition.is_rest_seen,
        markers: free * asked.len(),
        found: tried().map(|one| one.found).sum(),
        displacement_rms_mm: rms(errors_mm.iter().copied()),
        displacement_largest_mm: (!errors_mm.is_empty()).then(|| errors_mm.iter().fold(0.0, size)),
        stated_mm: rms(tried().filter_map(|one| one.sd_mm)),
        forces: asked.len(),
        refused: asked.len() - sensed.len(),
        force_rms_error: rms(sensed.iter().copied()),
        force_largest_error: (!sensed.is_empty()).then(|| sensed.iter().fold(0.0, size)),
        first_order_rms_error: rms(tried().filter_map(|one| one.first_order)),
    })
}

/// Processing times, measured by alternating between two images that differ only in their noise. The first run of searching and the first run of
/// tracking are excluded.
fn frame_times(finger: &Finger, shape: &FingerShape, camera: &Camera, markers: &Markers) -> Option<FrameTimes> {
    const TIMED: usize = 9;
    let image = |seed: u64| {
        let disturbances = conditions::ORDINARY.disturbances(seed);
        render(&RenderRequest { disturbances, ..RenderRequest::of(camera, finger, shape, markers) }).ok()
    };
    let (first, second) = rayon::join(|| image(1), || image(2));
    let images = [first?, second?];
    let mut locator = Locator::new(finger, camera, markers).ok()?;
    let mut median = |is_tracked: bool| {
        let mut seconds = Vec::with_capacity(TIMED);
        for (run, image) in images.iter().cycle().take(TIMED + 1).enumerate() {
            let start = Instant::now();
            let located = if is_tracked { locator.track(image) } else { locator.locate(image) };
            let time = start.elapsed().as_secs_f64();
            located.ok()?;
            if run > 0 {
                seconds.push(time);
            }
        }
        Some(*seconds.select_nth_unstable_by(TIMED / 2, f64::total_cmp).1)
    };
    Some(FrameTimes { search_s: median(false)?, track_s: median(true)? })
}

impl Evidence for CameraStudy {
    fn checks(&self, context: &Context) -> Vec<Check> {
        let Some(row) = self.as_it_is().filter(|_| context.is_paper) else { return Vec::new() };
        let unfound = (row.markers - row.found) as f64;
        let internal = |quantity: &str, ours: Option<f64>, tolerance: f64| {
            let ours = ours.unwrap_or(f64::NAN);
            Check::new(Kind::Internal, "node positions in rendered images", "render", quantity, 0.0, ours, tolerance)
        };
        vec![
            internal("rms error of a coordinate, mm", row.displacement_rms_mm, GOOD_POSITION_MM),
            // A tolerance below one marker admits no missing marker.
            internal("markers of free nodes that were not found", Some(unfound), 0.5),
        ]
    }
}
