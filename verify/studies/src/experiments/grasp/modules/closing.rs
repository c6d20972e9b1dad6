//! Closing of a finger on caps: steps of the motor, and the contact forces at which no rod penetrates its cap.

use super::ExperimentError;
use crate::experiments::table_two::FORCES_N;
use crate::prelude::*;
use crate::sampling::bound::linearised_markers;
use finray_model::scene::ROD_RADIUS_MM;
use finray_model::statics::Ladder;

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
    let statics = Statics::ladder(mesh, Kinematics::Corotational);
    let mut caps = Caps { mesh, statics, plane_mm, forces_n: vec![0.0; nodes.len()], nodes };
    let mut steps = Vec::new();
    for turned_deg in (1..=MOST_STEPS).map(|step| STEP_DEG * step as f64) {
        let Some(placement) = right(turned_deg) else { break };
        let Some((motion, gaps_mm)) = caps.press(&placement)? else { break };
        let true_n = caps.forces_n.clone();
        if true_n.iter().any(|force_n| *force_n > FORCES_N[1]) {
            break;
        }
        if true_n.iter().any(|force_n| *force_n > 0.0) {
            let displacements = Measurement::of_shape(finger, &mesh.shape(&motion));
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

/// A finger in front of its caps, with the forces of the last step.
struct Caps<'m> {
    mesh: &'m Mesh,
    statics: Statics<Ladder<'m>>,
    nodes: Vec<NodeId>,
    /// Position of the caps' plane, mm from the middle of the gripper.
    plane_mm: f64,
    forces_n: Vec<f64>,
}

impl Caps<'_> {
    /// Newton's method on the gaps: finds forces at which no rod penetrates its cap, and only rods on their caps carry a force. Returns the motion of the
    /// finger, and the gap between each node's rod and its cap, mm. `None` if the finger has no equilibrium or the method does not converge.
    fn press(&mut self, placement: &Placement) -> Result<Option<(FrameMotion, Vec<f64>)>, LoadError> {
        let finger = self.mesh.finger();
        let across = across(placement);
        let angle_deg = finger.angle_deg(across);
        let contacts: Vec<Contact> =
            self.nodes.iter().map(|&node| Contact { angle_deg, ..Contact::at_node(node) }).collect();
        let rows = self.nodes.iter().filter_map(|node| finger.marked_nodes().position(|marked| marked == *node));
        let rows: Vec<usize> = rows.collect();
        for _ in 0..MOST_NEWTON_STEPS {
            let found = linearised_markers(&mut self.statics, self.mesh, &contacts, &self.forces_n)?;
            let Some((motion, by_force)) = found else { return Ok(None) };
            let gap_mm = |node: &NodeId| {
                let at = finger.position(*node) + motion.displacements[self.mesh.marker_node(*node)];
                placement.outwards(at).x - ROD_RADIUS_MM - self.plane_mm
            };
            let gaps_mm: Vec<f64> = self.nodes.iter().map(gap_mm).collect();
            let is_settled = |(gap_mm, force_n): (&f64, &f64)| match *force_n > 0.0 {
                true => gap_mm.abs() <= ON_CAP_MM,
                false => *gap_mm >= -ON_CAP_MM,
            };
            if gaps_mm.iter().zip(&self.forces_n).all(is_settled) {
                return Ok(Some((motion, gaps_mm)));
            }
            let pressed: Vec<usize> =
                (0..gaps_mm.len()).filter(|&i| self.forces_n[i] > 0.0 || gaps_mm[i] < 0.0).collect();
            let compliance = DMatrix::from_fn(pressed.len(), pressed.len(), |row, column| {
                by_force.fixed_view::<2, 1>(2 * rows[pressed[row]], pressed[column]).dot(&across)
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
