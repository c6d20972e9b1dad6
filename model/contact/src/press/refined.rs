//! Automatic refinement of a scene's mesh: the elements are halved until the total contact force of every step hardly changes.

use super::{ContactScene, SceneStep};
use crate::ContactError;
use crate::pressing::{Pressing, Push};
use crate::world::Moment;
use finray_model::Mesh;
use std::cell::OnceCell;

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

/// Steps on one mesh up to the end or to an error, each with the finger and the object in equilibrium.
struct Pressed<'m> {
    steps: Vec<SceneStep>,
    pressing: Option<Pressing<'m>>,
    at_rest: Vec<Moment>,
    stopped: Option<ContactError>,
}

impl ContactScene {
    /// Runs the scene and passes every step to `each`. Without a requested fineness, elements are halved until no total changes by more than
    /// [`TOTAL_TOLERANCE`], or until the largest number of elements is reached.
    ///
    /// # Errors
    /// [`ContactError`] if the object overlaps the finger at the start, or a step has no equilibrium. On an error, `each` has received the steps
    /// before the failed step.
    pub fn run(&self, mut each: impl FnMut(SceneStep)) -> Result<Refinement, ContactError> {
        let members = self.finger().rib_count() + 1;
        let first = self.elements.unwrap_or_else(|| FIRST_ELEMENTS.div_ceil(members));
        let levels = match self.elements {
            Some(_) => 1,
            None => 1 + (1..).take_while(|level| (first << level) * members <= MOST_ELEMENTS).count(),
        };
        let meshes: Vec<OnceCell<Mesh>> = vec![OnceCell::new(); levels];
        let mesh =
            |level: usize| meshes[level].get_or_init(|| Mesh::with_elements_per_member(self.finger(), first << level));
        let mut found = self.press(mesh(0), None);
        let (mut elements, mut change) = (first, None);
        for level in 1..levels {
            let is_half = elements == first << (level - 1);
            let finer = self.press(mesh(level), is_half.then_some(&found));
            let their_change = TotalChange::largest(&found.steps, &finer.steps);
            // Near a change of contacts, a step can fail on one mesh and succeed on the other mesh.
            if finer.steps.len() >= found.steps.len() {
                (found, elements, change) = (finer, first << level, their_change);
            }
            if their_change.is_none_or(|change| change.share <= TOTAL_TOLERANCE) {
                break;
            }
        }
        found.steps.into_iter().for_each(&mut each);
        found.stopped.map_or(Ok(Refinement { elements, change }), Err)
    }

    /// Presses the object on one mesh. `coarse` is the same press on a mesh with half as many elements per member; without friction, each of its
    /// equilibria is the start for the equilibrium on this mesh.
    fn press<'m>(&self, mesh: &'m Mesh, coarse: Option<&Pressed>) -> Pressed<'m> {
        let mut pressed = Pressed { steps: Vec::new(), pressing: None, at_rest: Vec::new(), stopped: None };
        pressed.stopped = self.press_each(mesh, coarse, &mut pressed).err();
        pressed
    }

    fn press_each<'m>(
        &self,
        mesh: &'m Mesh,
        coarse: Option<&Pressed>,
        pressed: &mut Pressed<'m>,
    ) -> Result<(), ContactError> {
        let object = (self.object.outline.clone(), self.object.friction);
        let (start, rod_radius_mm) = (self.object.start, self.scene.contact.rod_radius_mm);
        let pressing = pressed.pressing.insert(Pressing::new(mesh, rod_radius_mm, object, start, self.object.along)?);
        let near = coarse.filter(|_| self.object.friction == 0.0);
        let near = near.and_then(|coarse| Some((coarse.pressing.as_ref()?, &coarse.at_rest)));
        let (mut travel_mm, mut last) = (0.0, start);
        for (index, step) in self.object.steps.iter().enumerate() {
            if self.is_stopped() {
                return Err(ContactError::Stopped);
            }
            let near = near.and_then(|(coarse, at_rest)| Some((coarse, at_rest.get(index)?)));
            let found = match near.and_then(|(coarse, there)| pressing.push_near(coarse, there, step.end)) {
                Some(found) => found,
                None => {
                    step.corners.iter().try_for_each(|corner| pressing.pass(Push::To(*corner)))?;
                    pressing.push(step.end)?
                }
            };
            for at in step.corners.iter().chain([&found.object]) {
                travel_mm += (at - last).norm();
                last = *at;
            }
            let baseline_mm =
                |touch: &_| super::baseline_mm(self.finger(), rod_radius_mm, &self.object.outline, found.object, touch);
            let contacts = super::seen_contacts(self.finger(), &found.touches, baseline_mm);
            let stopped_mm = if let Push::To(told) = step.end { (told - found.object).norm() } else { 0.0 };
            pressed.steps.push(SceneStep { travel_mm, stopped_mm, along: step.along, contacts, pressed: found });
            if self.elements.is_none() {
                pressed.at_rest.push(pressing.moment());
            }
        }
        Ok(())
    }
}
