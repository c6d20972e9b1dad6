//! Automatic refinement of a scene's mesh: the elements are halved until the total contact force of every step hardly changes.

use super::{ContactScene, SceneStep};
use crate::ContactError;
use crate::pressing::{Pressing, Push};
use finray_model::Mesh;

/// Largest relative difference of a total contact force between a sufficiently fine mesh and a mesh half as fine.
pub const TOTAL_TOLERANCE: f64 = 1e-3;
/// The change of a total is divided by the total, but at least by this share of the scene's largest total.
const SMALL: f64 = 0.1;
/// Number of elements of the front plate in the first mesh.
const FIRST_ELEMENTS: usize = 24;
/// Largest number of elements of the front plate.
const MOST_ELEMENTS: usize = 400;

/// Mesh on which the steps of a scene are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    /// Number of elements of each member.
    pub elements: usize,
    /// Largest change of a total compared with the mesh half as fine; `None` if the coarser mesh was not computed.
    pub change: Option<TotalChange>,
}

/// Difference of a step's total, or of its travel under a prescribed force, between two meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TotalChange {
    /// Number of the step, from 1.
    pub step: usize,
    /// Difference relative to the total or to the travel.
    pub share: f64,
}

impl TotalChange {
    /// Largest change of a step's total or travel from a mesh to a finer mesh. A step that only one of the two meshes reaches counts as a change of 100
    /// %.
    pub fn largest(coarse: &[SceneStep], fine: &[SceneStep]) -> Option<TotalChange> {
        let largest_n = fine.iter().map(|step| step.total_n().abs()).fold(0.0, f64::max);
        let farthest_mm = fine.iter().map(|step| step.travel_mm).fold(0.0, f64::max);
        let share = |(coarse, fine): (&SceneStep, &SceneStep)| {
            let change_n = (coarse.total_n() - fine.total_n()).abs();
            let of_total = if change_n == 0.0 { 0.0 } else { change_n / fine.total_n().abs().max(SMALL * largest_n) };
            let change_mm = (coarse.travel_mm - fine.travel_mm).abs();
            of_total.max(if change_mm == 0.0 { 0.0 } else { change_mm / fine.travel_mm.max(SMALL * farthest_mm) })
        };
        let shares = coarse.iter().zip(fine).map(share);
        let changes = shares.enumerate().map(|(index, share)| TotalChange { step: index + 1, share });
        let missing =
            (coarse.len() != fine.len()).then_some(TotalChange { step: coarse.len().min(fine.len()) + 1, share: 1.0 });
        changes.chain(missing).max_by(|a, b| a.share.total_cmp(&b.share))
    }
}

/// Steps up to the end or to an error, together with the error if there is one.
type Pressed = (Vec<SceneStep>, Option<ContactError>);

impl ContactScene {
    /// Runs the scene and passes every step to `each`. Without a requested fineness, elements are halved until no total changes by more than
    /// [`TOTAL_TOLERANCE`], or until the largest number of elements is reached.
    ///
    /// # Errors
    /// [`ContactError`] if the object overlaps the finger at the start, or a step has no equilibrium. On an error, `each` has received the steps
    /// before the failed step.
    pub fn run(&self, mut each: impl FnMut(SceneStep)) -> Result<Refinement, ContactError> {
        let members = self.finger().rib_count() + 1;
        let mut elements = self.elements.unwrap_or_else(|| FIRST_ELEMENTS.div_ceil(members));
        let (mut steps, mut stopped) = self.press(elements);
        let (mut change, mut finer) = (None, 2 * elements);
        while self.elements.is_none() && finer * members <= MOST_ELEMENTS {
            let (their_steps, their_end) = self.press(finer);
            let their_change = TotalChange::largest(&steps, &their_steps);
            // Near a change of contacts, a step can fail on one mesh and succeed on the other mesh.
            if their_steps.len() >= steps.len() {
                (steps, stopped, elements, change) = (their_steps, their_end, finer, their_change);
            }
            if their_change.is_none_or(|change| change.share <= TOTAL_TOLERANCE) {
                break;
            }
            finer *= 2;
        }
        steps.into_iter().for_each(&mut each);
        stopped.map_or(Ok(Refinement { elements, change }), Err)
    }

    fn press(&self, elements: usize) -> Pressed {
        let mut steps = Vec::new();
        let outcome = self.press_each(elements, &mut steps);
        (steps, outcome.err())
    }

    fn press_each(&self, elements: usize, pressed: &mut Vec<SceneStep>) -> Result<(), ContactError> {
        let mesh = Mesh::with_elements_per_member(self.finger(), elements);
        let object = (self.object.outline.clone(), self.object.friction);
        let (start, rod_radius_mm) = (self.object.start, self.scene.contact.rod_radius_mm);
        let mut pressing = Pressing::new(&mesh, rod_radius_mm, object, start, self.object.along)?;
        let (mut travel_mm, mut last) = (0.0, start);
        for step in &self.object.steps {
            for &corner in &step.corners {
                pressing.pass(Push::To(corner))?;
                travel_mm += (corner - last).norm();
                last = corner;
            }
            let found = pressing.push(step.end)?;
            travel_mm += (found.object - last).norm();
            last = found.object;
            let baseline_mm =
                |touch: &_| super::baseline_mm(self.finger(), rod_radius_mm, &self.object.outline, found.object, touch);
            let contacts = super::seen_contacts(self.finger(), &found.touches, baseline_mm);
            let stopped_mm = if let Push::To(told) = step.end { (told - found.object).norm() } else { 0.0 };
            pressed.push(SceneStep { travel_mm, stopped_mm, along: step.along, contacts, pressed: found });
        }
        Ok(())
    }
}
