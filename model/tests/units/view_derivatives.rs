//! Tests of private items of `calibration::views::derivatives`.

use super::super::{Sought, View, ViewModel};
use super::*;
use crate::calibration::Quantity;
use crate::finger::Plate;
use crate::measurement::{BaseUncertainty, MarkerErrors, Measurement};
use crate::sensing::{ForceUnknowns, Lean, Normal, Pad};
use crate::{Scene, Vector};
use nalgebra::Isometry2;

/// Steps of the central differences, in the unit of each unknown. Equilibria have ten correct digits, and the differences are of second order.
const STEP: f64 = 1e-3;
/// Largest deviation of a derivative, as a share of the largest derivative by the same unknown. Central differences with [`STEP`] deviate by 1e-4,
/// because lengths strain stiff beams.
const TOLERANCE: f64 = 1e-3;

/// Derivatives from the factored tangent equal central differences of equilibria that start from rest, for measured and sought forces, for directions
/// that follow the plate and those that do not, with and without a pad.
#[test]
fn derivatives_are_those_of_equilibria() {
    let finger = Scene::from_toml(finray_fixtures::BRACKETED_SCENE).expect("a scene").finger;
    let quantities = [
        Quantity::Modulus,
        Quantity::PlateModulus(Plate::Front),
        Quantity::Bracket(Plate::Front),
        Quantity::OwnBracket(Plate::Back, 1),
        Quantity::PlateClip(Plate::Front),
        Quantity::RibPosition(Plate::Front, 2),
        Quantity::RibPosition(Plate::Back, 0),
        Quantity::MarkerHeight,
        Quantity::BaseX,
        Quantity::BaseTurn,
        Quantity::Preload,
        Quantity::Lean,
    ];
    let sought = quantities.map(|quantity| Sought { quantity, prior_sd: Some(0.3) });
    let base = BaseUncertainty { sd_mm: 0.5, sd_rad: 0.01, turn_rad_per_n: 1e-3, turn_sd_rad_per_n: 5e-4 };
    let view = |force: Option<Vector>| View {
        name: String::new(),
        measurement: Measurement::at_rest(&finger),
        noise_mm: 0.05,
        base,
        eye: Vector::new(70.0, 10.0),
        force,
        position: None,
    };
    let all = [view(None), view(Some(finger.direction(12.0) * 3.0))];
    let normals = [Normal::Undeformed, Normal::Deformed { over_mm: 0.0 }, Normal::Deformed { over_mm: 8.0 }];
    let pads = [None, Some(Pad { length_mm: 4.0, thickness_mm: 1.5 })];
    for (from, pad) in normals.into_iter().flat_map(|from| pads.map(|pad| (from, pad))) {
        let model = ViewModel {
            elements: 2,
            camera_height_mm: 250.0,
            marker_height_mm: 1.0,
            lean: Lean { angle_deg: 10.0, sd_deg: 5.0, build_up_n: 2.0, from },
            pad,
            preload_nmm: 3.0,
            model_error: 0.0,
        };
        let errors = MarkerErrors { calibration_error_mm: 0.02, ..MarkerErrors::default() };
        let (views, sought, scatter) = (&all[..], &sought[..], Some(0.01));
        let mut problem =
            Problem { finger: &finger, views, sought, model: &model, errors, scatter, shapes: Vec::new() };
        let base = Isometry2::new(Vector::new(0.3, -0.6), 0.02);
        let own = [(66.0, 4.0, 3.0), (93.0, 3.0, 0.0)];
        let own = own.map(|(s_mm, force_n, further_lean_deg)| ForceUnknowns {
            base,
            further_lean_deg,
            ..ForceUnknowns::at(s_mm, force_n)
        });
        let point = Point { shared: vec![0.04; quantities.len()], own: own.to_vec() };
        let residual = problem.residual(&point).expect("an equilibrium");
        let found = problem.jacobian(&point, &residual).expect("a stable equilibrium");
        for k in 0..found.ncols() {
            let [before, after] = [-STEP, STEP].map(|step| {
                let mut steps = DVector::zeros(found.ncols());
                steps[k] = step;
                problem.shapes.clear();
                problem.residual(&problem.moved(&point, &steps)).expect("an equilibrium")
            });
            let expected = (after - before) / (2.0 * STEP);
            let off = (found.column(k) - &expected).amax() / expected.amax();
            assert!(off < TOLERANCE, "unknown {k} of {from:?} with {pad:?}: {off:.1e}");
        }
    }
}
