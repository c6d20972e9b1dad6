//! Which forces are clearly more than a finger carries, found at little cost on the estimator's mesh.

use crate::prelude::*;
use finray_model::statics::Ladder;
use std::sync::OnceLock;

/// Forces of which the finger of this mesh carries no more than this share are clearly too large: of 432 limit loads of random pairs of forces
/// on two fingers, those of the true finger's mesh are 0.990 to 1.001 times those of the estimator's.
const CLEARLY_TOO_LARGE: f64 = 0.98;
/// Between two ratios of forces that differ by less than this angle, rad, ...
const NEIGHBOURS: f64 = 0.1;
/// ... forces are too large if the larger of both limits is within this share of them, and carried if within it of the smaller.
const BETWEEN_NEIGHBOURS: f64 = 0.9;

/// Ratios of forces whose limits all blocks of cases share: this far apart, rad, over those of the range.
const SPREAD: f64 = 0.05;

/// Limits of the ratios of forces that are drawn, on the estimator's mesh; found when one asks for them first.
pub(super) struct RatioLimits<'m> {
    mesh: &'m Mesh,
    kinematics: Kinematics,
    contacts: &'m [Contact],
    range_n: [f64; 2],
    limits: OnceLock<Vec<Limit>>,
}

impl<'m> RatioLimits<'m> {
    pub(super) fn new(
        mesh: &'m Mesh,
        kinematics: Kinematics,
        contacts: &'m [Contact],
        range_n: [f64; 2],
    ) -> RatioLimits<'m> {
        RatioLimits { mesh, kinematics, contacts, range_n, limits: OnceLock::new() }
    }

    /// A scout that knows these limits.
    pub(super) fn scout(&self) -> Scout<'m> {
        let statics = Statics::ladder(self.mesh, self.kinematics);
        let mut scout = Scout { mesh: self.mesh, contacts: self.contacts, statics, limits: Vec::new() };
        let limits = self.limits.get_or_init(|| {
            let limit = |forces_n: Vec<f64>| match scout.sees(&forces_n) {
                // The limit of what is carried whole is beyond the range.
                LoadClass::Carried => Ray::of(&forces_n).map(|ray| Limit { ray, size_n: f64::INFINITY }),
                LoadClass::AtTheLimit | LoadClass::TooLarge => scout.limits.drain(..).next(),
            };
            self.largest_forces().into_iter().filter_map(limit).collect()
        });
        scout.limits.clone_from(limits);
        scout
    }

    /// The largest forces of each ratio that are drawn; none where a ratio is more than an angle.
    fn largest_forces(&self) -> Vec<Vec<f64>> {
        let [least, most] = self.range_n;
        if least <= 0.0 || self.contacts.len() > 2 {
            return Vec::new();
        }
        if self.contacts.len() == 1 {
            return vec![vec![most]];
        }
        let [low, high] = [least.atan2(most), most.atan2(least)];
        let parts = ((high - low) / SPREAD).ceil();
        let forces = |i: usize| {
            let (second, first) = (low + (high - low) * i as f64 / parts).sin_cos();
            let size = most / first.max(second);
            vec![size * first, size * second]
        };
        (0..=parts as usize).map(forces).collect()
    }
}

/// A finger on a coarser mesh than the true one, and what was found of the forces that it carries.
pub(super) struct Scout<'m> {
    mesh: &'m Mesh,
    contacts: &'m [Contact],
    statics: Statics<Ladder<'m>>,
    limits: Vec<Limit>,
}

/// What a scout sees of some forces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LoadClass {
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

impl Scout<'_> {
    /// What the finger carries of some forces.
    pub(super) fn sees(&mut self, forces_n: &[f64]) -> LoadClass {
        let size_n = forces_n.iter().map(|force| force * force).sum::<f64>().sqrt();
        let ray = Ray::of(forces_n);
        if let Some([lower_n, higher_n]) = ray.and_then(|ray| self.known_limits_n(ray)) {
            if higher_n < BETWEEN_NEIGHBOURS * size_n {
                return LoadClass::TooLarge;
            }
            if size_n < BETWEEN_NEIGHBOURS * lower_n {
                return LoadClass::Carried;
            }
        }
        let Some(loads) = loads(self.mesh, self.contacts, forces_n) else { return LoadClass::AtTheLimit };
        match self.statics.equilibrium(&loads) {
            Ok(_) => LoadClass::Carried,
            Err(StaticsError::NoEquilibrium { converged_fraction }) => {
                self.limits.extend(ray.map(|ray| Limit { ray, size_n: converged_fraction * size_n }));
                if converged_fraction < CLEARLY_TOO_LARGE { LoadClass::TooLarge } else { LoadClass::AtTheLimit }
            }
            Err(_) => LoadClass::AtTheLimit,
        }
    }

    /// Limits of the nearest known ratios to both sides, the lower one first; `None` if one of them is too far.
    fn known_limits_n(&self, Ray(angle): Ray) -> Option<[f64; 2]> {
        let nearest = |side: f64| {
            let away = |limit: &Limit| side * (limit.ray.0 - angle);
            let on_this_side = self.limits.iter().filter(|limit| (0.0..NEIGHBOURS).contains(&away(limit)));
            on_this_side.min_by(|a, b| away(a).total_cmp(&away(b))).map(|limit| limit.size_n)
        };
        let (below, above) = (nearest(-1.0)?, nearest(1.0)?);
        Some([below.min(above), below.max(above)])
    }
}

/// Forces at contacts as loads on a mesh; `None` for contacts that are not on it.
pub(super) fn loads(mesh: &Mesh, contacts: &[Contact], forces_n: &[f64]) -> Option<Vec<FrameLoad>> {
    let load = |(c, f): (&Contact, &f64)| mesh.frame_load(&c.load(mesh.finger(), *f)).ok();
    contacts.iter().zip(forces_n).map(load).collect()
}

#[cfg(test)]
#[path = "../../../tests/units/scout.rs"]
mod tests;
