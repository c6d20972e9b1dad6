//! Fast detection of forces that clearly exceed the finger's limit load. The detection uses the estimator's mesh, which is coarser than the true
//! finger's mesh.

use crate::prelude::*;
use crate::sampling::bound::loads;
use finray_model::statics::Ladder;
use std::sync::OnceLock;

/// Forces are clearly too large if the estimator's mesh carries less than this fraction of them. Over 432 random pairs of forces on two fingers, the
/// limit load on the true finger's mesh is 0.990 to 1.001 times the limit load on the estimator's mesh.
const CLEARLY_TOO_LARGE: f64 = 0.98;
/// Limit loads known within this angle (rad) on both sides of the forces' ratio can replace a solve.
const NEIGHBOURS: f64 = 0.1;
/// Factor for a margin around the limit loads of the two neighbouring force ratios. Forces count as carried below this factor times the smaller limit
/// load, and as too large above the larger limit load divided by this factor.
const BETWEEN_NEIGHBOURS: f64 = 0.9;

/// Largest angle, rad, between neighbouring force ratios. The limit loads of these ratios are computed once for all blocks of cases.
const SPREAD: f64 = 0.05;

/// Limit loads on the estimator's mesh, for force ratios over the whole range of drawn forces. The limit loads are computed at the first request.
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

    pub(super) fn scout(&self) -> Scout<'m> {
        let statics = Statics::ladder(self.mesh, self.kinematics);
        let mut scout = Scout { mesh: self.mesh, contacts: self.contacts, statics, limits: Vec::new() };
        let limits = self.limits.get_or_init(|| {
            let limit = |forces_n: Vec<f64>| match scout.sees(&forces_n) {
                // If the finger carries the largest forces of the range, its limit load is beyond the range.
                LoadClass::Carried => Ray::of(&forces_n).map(|ray| Limit { ray, size_n: f64::INFINITY }),
                LoadClass::AtTheLimit | LoadClass::TooLarge => scout.limits.drain(..).next(),
            };
            self.largest_forces().into_iter().filter_map(limit).collect()
        });
        scout.limits.clone_from(limits);
        scout
    }

    /// Largest forces (N) of the range for each ratio. Empty if the range includes forces of zero or less, or if there are more than two contacts.
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

/// The finger on a coarser mesh than the true finger's, with the limit loads found so far.
pub(super) struct Scout<'m> {
    mesh: &'m Mesh,
    contacts: &'m [Contact],
    statics: Statics<Ladder<'m>>,
    limits: Vec<Limit>,
}

/// Result of the scout for given forces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LoadClass {
    /// The scout's finger carries the forces.
    Carried,
    /// The scout's finger does not carry the forces, but the true finger's finer mesh may.
    AtTheLimit,
    /// The forces clearly exceed the limit.
    TooLarge,
}

/// Largest forces of one ratio that the finger carries; `size_n` is their Euclidean norm, N.
#[derive(Clone, Copy)]
struct Limit {
    ray: Ray,
    size_n: f64,
}

/// Ratio of two forces, as an angle, rad; for a single force, 0 or pi by its sign. Along a load path, the forces keep their ratio from rest to full
/// load.
#[derive(Clone, Copy)]
struct Ray(f64);

impl Ray {
    /// Ratio of the forces; `None` for more than two.
    fn of(forces_n: &[f64]) -> Option<Ray> {
        match *forces_n {
            [force] => Some(Ray(if force < 0.0 { std::f64::consts::PI } else { 0.0 })),
            [first, second] => Some(Ray(second.atan2(first))),
            _ => None,
        }
    }
}

impl Scout<'_> {
    /// Load class of forces (N), from the limit loads of neighbouring ratios or from a solve. If a solve finds no equilibrium, its limit load is
    /// stored.
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
        let Ok(loads) = loads(self.mesh, self.contacts, forces_n) else { return LoadClass::AtTheLimit };
        match self.statics.equilibrium(&loads) {
            Ok(_) => LoadClass::Carried,
            Err(StaticsError::NoEquilibrium { converged_fraction }) => {
                self.limits.extend(ray.map(|ray| Limit { ray, size_n: converged_fraction * size_n }));
                if converged_fraction < CLEARLY_TOO_LARGE { LoadClass::TooLarge } else { LoadClass::AtTheLimit }
            }
            Err(_) => LoadClass::AtTheLimit,
        }
    }

    /// Limit loads (N) of the nearest known ratios on both sides of a ratio, the smaller limit load first; `None` if one side has no known ratio
    /// nearby.
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

#[cfg(test)]
#[path = "../../../tests/units/scout.rs"]
mod tests;
