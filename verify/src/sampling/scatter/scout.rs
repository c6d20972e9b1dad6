//! Which forces are clearly more than a finger carries, found at little cost on the estimator's mesh.

use finray_model::frame::FrameLoad;
use finray_model::sensing::Contact;
use finray_model::statics::{Ladder, Statics, StaticsError};
use finray_model::{Kinematics, Mesh};

/// Forces of which the finger of this mesh carries no more than this share are clearly too large: of 432 limit loads of random pairs of forces
/// on two fingers, those of the true finger's mesh are 0.990 to 1.001 times those of the estimator's.
const CLEARLY_TOO_LARGE: f64 = 0.98;
/// Between two ratios of forces that differ by less than this angle, rad, ...
const NEIGHBOURS: f64 = 0.1;
/// ... forces are too large of which the larger of both limits is no more than this share.
const BETWEEN_NEIGHBOURS: f64 = 0.9;

/// A finger on a coarser mesh than the true one, and what was found of the forces that it carries.
pub(super) struct Scout<'m> {
    mesh: &'m Mesh,
    contacts: &'m [Contact],
    statics: Statics<Ladder<'m>>,
    limits: Vec<Limit>,
}

/// What a scout sees of some forces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Seen {
    /// Its finger carries them.
    Carried,
    /// Its finger does not carry them, but a finer mesh may.
    AtTheLimit,
    /// Its finger carries much less.
    TooLarge,
}

/// The largest forces of one ratio that the finger carries.
#[derive(Clone, Copy)]
struct Limit {
    ray: Ray,
    size_n: f64,
}

/// Ratio of one or two forces, as an angle, rad; forces of one ratio are followed from rest in a straight line.
#[derive(Clone, Copy)]
struct Ray(f64);

impl Ray {
    /// `None` for more than two forces.
    fn of(forces_n: &[f64]) -> Option<Ray> {
        match *forces_n {
            [force] => Some(Ray(if force < 0.0 { std::f64::consts::PI } else { 0.0 })),
            [first, second] => Some(Ray(second.atan2(first))),
            _ => None,
        }
    }
}

impl<'m> Scout<'m> {
    pub(super) fn new(mesh: &'m Mesh, kinematics: Kinematics, contacts: &'m [Contact]) -> Scout<'m> {
        Scout { mesh, contacts, statics: Statics::ladder(mesh, kinematics), limits: Vec::new() }
    }

    /// What the finger carries of some forces.
    pub(super) fn sees(&mut self, forces_n: &[f64]) -> Seen {
        let size_n = forces_n.iter().map(|force| force * force).sum::<f64>().sqrt();
        let ray = Ray::of(forces_n);
        if let Some(limit_n) = ray.and_then(|ray| self.known_limit_n(ray))
            && limit_n < BETWEEN_NEIGHBOURS * size_n
        {
            return Seen::TooLarge;
        }
        let Some(loads) = loads(self.mesh, self.contacts, forces_n) else { return Seen::AtTheLimit };
        match self.statics.equilibrium(&loads) {
            Ok(_) => Seen::Carried,
            Err(StaticsError::NoEquilibrium { converged_fraction }) => {
                self.limits.extend(ray.map(|ray| Limit { ray, size_n: converged_fraction * size_n }));
                if converged_fraction < CLEARLY_TOO_LARGE { Seen::TooLarge } else { Seen::AtTheLimit }
            }
            Err(_) => Seen::AtTheLimit,
        }
    }

    /// The larger of the limits of the nearest known ratios to both sides; `None` if one of them is too far.
    fn known_limit_n(&self, Ray(angle): Ray) -> Option<f64> {
        let nearest = |side: f64| {
            let away = |limit: &Limit| side * (limit.ray.0 - angle);
            let on_this_side = self.limits.iter().filter(|limit| (0.0..NEIGHBOURS).contains(&away(limit)));
            on_this_side.min_by(|a, b| away(a).total_cmp(&away(b))).map(|limit| limit.size_n)
        };
        Some(f64::max(nearest(-1.0)?, nearest(1.0)?))
    }
}

/// Forces at contacts as loads on a mesh; `None` for contacts that are not on it.
pub(super) fn loads(mesh: &Mesh, contacts: &[Contact], forces_n: &[f64]) -> Option<Vec<FrameLoad>> {
    let load = |(c, f): (&Contact, &f64)| mesh.frame_load(&c.load(mesh.finger(), *f)).ok();
    contacts.iter().zip(forces_n).map(load).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use finray_model::Scene;

    /// Over a grid of pairs of forces on two nodes near the tip of a finger that carries only the smaller of them, the scout refuses none
    /// that the finger carries, and none that it carries nearly; most of the others without following them.
    #[test]
    fn forces_that_are_carried_are_never_refused() -> Result<(), Box<dyn std::error::Error>> {
        let finger = Scene::from_toml(finray_fixtures::SOFT_SCENE)?.finger;
        let mesh = Mesh::with_elements_per_member(&finger, 4);
        let nodes: Vec<_> = finger.contact_nodes().take(2).collect();
        let contacts: Vec<Contact> = nodes.into_iter().map(Contact::at_node).collect();
        let mut scout = Scout::new(&mesh, Kinematics::Corotational, &contacts);
        let mut statics = Statics::ladder(&mesh, Kinematics::Corotational);
        let (mut refused, mut carried) = (0, 0);
        for first in 1..=14 {
            for second in 1..=14 {
                // In an order that has nothing to do with their size.
                let forces_n = [first * 5 % 14, second * 3 % 14].map(|n| 0.1 + 0.2 * f64::from(n));
                let loads = loads(&mesh, &contacts, &forces_n).ok_or("the contacts are on the mesh")?;
                let share = match statics.equilibrium(&loads) {
                    Ok(_) => 1.0,
                    Err(StaticsError::NoEquilibrium { converged_fraction }) => converged_fraction,
                    Err(other) => return Err(other.into()),
                };
                let refuses = scout.sees(&forces_n) == Seen::TooLarge;
                assert!(
                    !refuses || share < CLEARLY_TOO_LARGE,
                    "{forces_n:?} N are refused, {share} of them are carried"
                );
                refused += usize::from(refuses);
                carried += usize::from(share == 1.0);
            }
        }
        assert!(carried > 10 && refused > 100, "{carried} carried, {refused} refused");
        assert!(scout.limits.len() < refused / 2, "{} limits for {refused} refusals", scout.limits.len());
        Ok(())
    }
}
