//! Models of the finger for sensing: with known or unknown zones, and calibrated or true modulus.

use crate::experiments::ExperimentError;
use crate::prelude::*;
use crate::truths::Truth;
use finray_model::calibration::{CalibrationCase, FactorModel, Unknown, factors};
use finray_model::finger::{Part, Zone};

/// Standard gravity, m/s^2 (CGPM 1901).
const STANDARD_GRAVITY: f64 = 9.80665;
/// Forces of the paper's weights of 50 to 300 g, N (sec. V-A and V-B).
pub const WEIGHTS_N: [f64; 6] = {
    const fn of_grams(weight_g: f64) -> f64 {
        weight_g * 1e-3 * STANDARD_GRAVITY
    }
    [of_grams(50.0), of_grams(100.0), of_grams(150.0), of_grams(200.0), of_grams(250.0), of_grams(300.0)]
};

/// An end of the finger, which may have zones of other stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Base,
    Tip,
}

/// Kinematics of the models. Every model has [`ELEMENTS`] elements per member, as the nonlinear estimator has. The linear model is exact at the key nodes
/// with any number of elements.
const KINEMATICS: [Kinematics; 2] = [Kinematics::Linear, Kinematics::Corotational];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Known {
    /// Whether the zones at the base are known.
    pub base: bool,
    /// Whether the zones at the tip are known.
    pub tip: bool,
    /// Whether Young's modulus is known; otherwise it is calibrated.
    pub modulus: bool,
    /// Kinematics of calibration and sensing.
    pub kinematics: Kinematics,
}

/// Models of the finger, one for each combination of known properties.
pub(super) struct Models {
    finger: Finger,
    meshes: Vec<Mesh>,
}

impl Models {
    /// All models of a true finger. Unknown moduli are calibrated on the true finger's shapes under weights (N) at three nodes: a third, half and two
    /// thirds of the way from tip to base. On the paper's finger, the three loaded nodes are 17, 19 and 21 (sec. V-A).
    pub fn of(finger: &Finger, truth: &dyn Truth, weights_n: &[f64]) -> Result<Models, ExperimentError> {
        let cases = weighed(finger, truth, weights_n);
        let mesh = |number: usize| {
            let known = Known::numbered(number);
            let zoned = with_zones(finger, known.base, known.tip)?;
            let model = if known.modulus { zoned } else { calibrated(&zoned, &cases, known.kinematics)? };
            Ok(Mesh::with_elements_per_member(&model, ELEMENTS))
        };
        let meshes = (0..Known::COUNT).into_par_iter().map(mesh).collect::<Result<_, ExperimentError>>()?;
        Ok(Models { finger: finger.clone(), meshes })
    }

    pub fn mesh(&self, known: Known) -> &Mesh {
        &self.meshes[known.number()]
    }

    pub fn finger(&self) -> &Finger {
        &self.finger
    }
}

impl Known {
    const COUNT: usize = 16;

    fn numbered(number: usize) -> Known {
        let bit = |position: usize| number >> position & 1;
        let is = |position: usize| bit(position) == 1;
        Known { base: is(0), tip: is(1), modulus: is(2), kinematics: KINEMATICS[bit(3)] }
    }

    fn number(self) -> usize {
        let is_corotational = self.kinematics == Kinematics::Corotational;
        let bits = [self.base, self.tip, self.modulus, is_corotational];
        bits.into_iter().enumerate().map(|(position, bit)| usize::from(bit) << position).sum()
    }
}

/// The end of the finger that is nearer to the middle of a zone.
fn end_of(finger: &Finger, zone: &Zone) -> End {
    let plate = if zone.part == Part::Back { Plate::Back } else { Plate::Front };
    // The comparison avoids a division: twice the middle of the zone is compared with the full length of the plate.
    if zone.from_mm + zone.to_mm < finger.plate_length_mm(plate) { End::Base } else { End::Tip }
}

pub(super) fn has_zones(finger: &Finger, end: End) -> bool {
    finger.description().zones.iter().any(|zone| end_of(finger, zone) == end)
}

/// The finger with only its known zones; unknown zones are removed.
pub(super) fn with_zones(finger: &Finger, base: bool, tip: bool) -> Result<Finger, ExperimentError> {
    let mut description = finger.description().clone();
    description.zones.retain(|zone| match end_of(finger, zone) {
        End::Base => base,
        End::Tip => tip,
    });
    Ok(Finger::new(description)?)
}

/// Shapes under ascending weights (N) along the normal. For each loaded node, the list of shapes ends before the first weight without equilibrium.
pub(super) fn weighed(finger: &Finger, truth: &dyn Truth, weights_n: &[f64]) -> Vec<CalibrationCase> {
    let nodes: Vec<NodeId> = finger.contact_nodes().collect();
    let mut loaded = [nodes.len() / 3, nodes.len() / 2, 2 * nodes.len() / 3].map(|i| nodes[i]).to_vec();
    loaded.dedup();
    let under = |node: NodeId| {
        let contact = Contact::at_node(node);
        let case = |(shape, weight_n): (FingerShape, &f64)| CalibrationCase {
            load: contact.load(finger, *weight_n),
            measurement: Measurement::of_shape(finger, &shape),
        };
        truth.shapes(&contact, weights_n).into_iter().zip(weights_n).map(case).collect::<Vec<_>>()
    };
    loaded.into_iter().flat_map(under).collect()
}

/// The finger with the modulus that best fits the shapes. A shape is omitted if this finger has no equilibrium under the shape's load; if no shape
/// remains, the finger is returned unchanged.
pub(super) fn calibrated(
    finger: &Finger,
    cases: &[CalibrationCase],
    kinematics: Kinematics,
) -> Result<Finger, ExperimentError> {
    let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
    let is_carried = |case: &&CalibrationCase| statics::solve(&mesh, &[case.load], kinematics).is_ok();
    let cases: Vec<CalibrationCase> = cases.iter().filter(is_carried).cloned().collect();
    if cases.is_empty() {
        return Ok(finger.clone());
    }
    let model = FactorModel { kinematics, elements: ELEMENTS, noise_mm: None };
    Ok(factors(finger, &cases, &[Unknown::Modulus], &model)?.finger)
}
