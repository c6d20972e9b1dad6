//! Closing of a finger on caps: steps of the motor, and the contact forces at which no rod penetrates its cap.

use super::ExperimentError;
use crate::experiments::table_two::FORCES_N;
use crate::prelude::*;
use crate::response::RespondingFinger;
use finray_model::scene::ROD_RADIUS_MM;

/// Starting angle of the motor, degrees. At this angle, the sensor's axis is 12.4 degrees off the plate's normal (in the paper: at most 12.5).
const START_DEG: f64 = 360.0;
/// Rotation of the motor from one step at rest to the next, degrees (section V-C).
const STEP_DEG: f64 = 22.5;
/// Largest number of steps: 900 degrees, the end of the paper's figures.
const MOST_STEPS: usize = 40;
/// Rotation of the motor at which the first node meets its cap, degrees.
const TOUCH_DEG: f64 = 45.0;
/// A rod counts as touching its cap up to this gap, mm, which allows for rounding of the equilibrium.
const ON_CAP_MM: f64 = 1e-9;
/// Largest number of Newton steps to find the touched caps and their forces.
const MOST_NEWTON_STEPS: usize = 60;

/// Equilibrium of the finger after one step of the motor, before sensing.
#[derive(Debug, Clone)]
pub struct ClosedStep {
    /// Motor angle by which the gripper has closed, degrees.
    pub turned_deg: f64,
    /// Direction of the sensors' axis, degrees from the plate's undeformed inward normal, positive towards the tip.
    pub axis_deg: f64,
    /// True force on each node along the sensors' axis, N.
    pub true_n: Vec<f64>,
    /// Displacements of the markers relative to the undeformed finger at the motor angle.
    pub displacements: Measurement,
    /// Gap between each node's rod and its cap, mm.
    pub gaps_mm: Vec<f64>,
}

/// Closes a finger on caps in front of its nodes. Returns the steps with a force, until a force exceeds the paper's range or a step has no
/// equilibrium.
///
/// # Errors
/// [`ExperimentError`] for nodes that are not on the finger.
pub fn closing(mesh: &Mesh, gripper: &Gripper, nodes: &[usize]) -> Result<Vec<ClosedStep>, ExperimentError> {
    let finger = mesh.finger();
    let right = |turned_deg: f64| Some(gripper.fingers(&gripper.pose(START_DEG - turned_deg)?)[1]);
    let nodes: Vec<NodeId> = nodes.iter().copied().map(NodeId).collect();
    let Some(at_touch) = right(TOUCH_DEG) else { return Ok(Vec::new()) };
    let reached_mm = |node: &NodeId| at_touch.outwards(finger.position(*node)).x - ROD_RADIUS_MM;
    let plane_mm = nodes.iter().map(reached_mm).fold(f64::INFINITY, f64::min);
    let mut caps =
        Caps { bent: RespondingFinger::new(mesh), finger, plane_mm, forces_n: vec![0.0; nodes.len()], nodes };
    let mut steps = Vec::new();
    for turned_deg in (1..=MOST_STEPS).map(|step| STEP_DEG * step as f64) {
        let Some(placement) = right(turned_deg) else { break };
        let Some(Pressed { displacements_mm, gaps_mm }) = caps.press(&placement)? else { break };
        let true_n = caps.forces_n.clone();
        if true_n.iter().any(|force_n| *force_n > FORCES_N[1]) {
            break;
        }
        if true_n.iter().any(|force_n| *force_n > 0.0) {
            let markers = finger.marked_nodes().zip(displacements_mm.as_slice().chunks_exact(2));
            let marker = |(node, moved): (NodeId, &[f64])| Marker {
                node,
                displacement: Vector::new(moved[0], moved[1]),
                weight: 1.0,
            };
            let displacements = Measurement::new(finger, markers.map(marker))?;
            let axis_deg = finger.angle_deg(across(&placement));
            steps.push(ClosedStep { turned_deg, axis_deg, true_n, displacements, gaps_mm });
        }
    }
    Ok(steps)
}

/// Unit vector from the module to the right finger, in the finger's frame.
fn across(placement: &Placement) -> Vector {
    placement.axes().transpose() * Vector::x()
}

struct Pressed {
    /// Displacements, mm, two coordinates per marker.
    displacements_mm: DVector<f64>,
    /// Gap between each node's rod and its cap, mm.
    gaps_mm: Vec<f64>,
}

/// A finger in front of its caps, with the forces of the last step.
struct Caps<'m> {
    bent: RespondingFinger<'m>,
    finger: &'m Finger,
    nodes: Vec<NodeId>,
    /// Position of the caps' plane, mm from the middle of the gripper.
    plane_mm: f64,
    forces_n: Vec<f64>,
}

impl Caps<'_> {
    /// Newton's method on the gaps: finds forces at which no rod penetrates its cap, and only rods on their caps carry a force. `None` if the finger has no
    /// equilibrium or the method does not converge.
    fn press(&mut self, placement: &Placement) -> Result<Option<Pressed>, LoadError> {
        let across = across(placement);
        let angle_deg = self.finger.angle_deg(across);
        let rows: Vec<usize> = self
            .nodes
            .iter()
            .filter_map(|node| self.finger.marked_nodes().position(|marked| marked == *node))
            .collect();
        for _ in 0..MOST_NEWTON_STEPS {
            let at = |node: &NodeId| Contact { angle_deg, ..Contact::at_node(*node) };
            let forces: Vec<(Contact, f64)> = self.nodes.iter().map(at).zip(self.forces_n.iter().copied()).collect();
            let Some(response) = self.bent.under(&forces)? else { return Ok(None) };
            let of_node = |moved: &DVector<f64>, i: usize| Vector::new(moved[2 * rows[i]], moved[2 * rows[i] + 1]);
            let gap_mm = |(i, node): (usize, &NodeId)| {
                let at = self.finger.position(*node) + of_node(&response.displacements_mm, i);
                placement.outwards(at).x - ROD_RADIUS_MM - self.plane_mm
            };
            let gaps_mm: Vec<f64> = self.nodes.iter().enumerate().map(gap_mm).collect();
            let is_settled = |(gap_mm, force_n): (&f64, &f64)| match *force_n > 0.0 {
                true => gap_mm.abs() <= ON_CAP_MM,
                false => *gap_mm >= -ON_CAP_MM,
            };
            if gaps_mm.iter().zip(&self.forces_n).all(is_settled) {
                return Ok(Some(Pressed { displacements_mm: response.displacements_mm, gaps_mm }));
            }
            let pressed: Vec<usize> =
                (0..gaps_mm.len()).filter(|&i| self.forces_n[i] > 0.0 || gaps_mm[i] < 0.0).collect();
            let compliance = DMatrix::from_fn(pressed.len(), pressed.len(), |row, column| {
                of_node(&response.along[pressed[column]], pressed[row]).dot(&across)
            });
            let missing = DVector::from_iterator(pressed.len(), pressed.iter().map(|&i| -gaps_mm[i]));
            let Some(change) = compliance.lu().solve(&missing) else { return Ok(None) };
            pressed.iter().zip(change.iter()).for_each(|(&i, change)| {
                self.forces_n[i] = (self.forces_n[i] + change).max(0.0);
            });
        }
        Ok(None)
    }
}
