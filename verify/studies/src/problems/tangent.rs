//! Compares analytical derivatives with central differences: nodal forces with differences of the energy, and the tangent stiffness with differences
//! of the nodal forces. The derivatives are checked for one element, for a load between the ends of an element, and for a whole finger.
//!
//! Source: differences of fourth order, (8 (f(h) - f(-h)) - (f(2h) - f(-2h))) / (12 h).

use super::ProblemError;
use crate::prelude::*;
use finray_model::element::{Beam, EndMotion, Response};
use finray_model::finger::FingerDescription;
use finray_model::statics::Assembly;
use finray_model::validity::SHEAR_CORRECTION;

const KINEMATICS: [Kinematics; 3] = [Kinematics::Linear, Kinematics::Corotational, Kinematics::CorotationalChord];
/// End displacements (mm) and rotations (rad) of a strongly bent and elongated beam: x, y and rotation of each end.
const BENT: [f64; 6] = [0.3, -0.2, 0.4, -0.5, 0.9, -0.3];
/// Step of the differences, mm and rad. Truncation error (proportional to the fourth power of the step) and rounding error (inversely proportional to
/// the step) are below the tolerance.
const STEP: f64 = 2e-3;
/// Tolerance of the difference between an analytical derivative and finite differences, relative to the largest derivative.
pub const TOLERANCE: f64 = 1e-9;

/// Derivative at 0 by finite differences of fourth order.
fn slope(f: impl Fn(f64) -> DVector<f64>) -> DVector<f64> {
    ((f(STEP) - f(-STEP)) * 8.0 - (f(2.0 * STEP) - f(-2.0 * STEP))) / (12.0 * STEP)
}

/// Largest difference of two vectors, relative to the largest entry of the second.
fn difference(ours: &DVector<f64>, theirs: &DVector<f64>) -> f64 {
    (ours - theirs).amax() / theirs.amax()
}

/// Relative errors of an element's gradient and tangent against finite differences.
fn of_element(scalar: impl Fn(&[EndMotion; 2]) -> Response) -> [f64; 2] {
    let response = |coordinate: usize, by: f64| {
        let mut x = BENT;
        x[coordinate] += by;
        scalar(&[0, 3].map(|i| EndMotion { displacement: Vector::new(x[i], x[i + 1]), rotation: x[i + 2] }))
    };
    let at = response(0, 0.0);
    let gradient = DVector::from_fn(6, |i, _| slope(|by| DVector::from_element(1, response(i, by).energy))[0]);
    let tangent = (0..6).map(|i| {
        let column = slope(|by| DVector::from_column_slice(response(i, by).gradient.as_slice()));
        // The tangent of a load on the linear beam is zero; the load's nodal forces then give the scale.
        let size = at.tangent.amax().max(at.gradient.amax());
        (column - DVector::from_column_slice(at.tangent.column(i).as_slice())).amax() / size
    });
    [difference(&DVector::from_column_slice(at.gradient.as_slice()), &gradient), worst(tangent)]
}

/// Relative errors of a bent finger's residual and tangent against finite differences, in a direction that moves every unknown.
fn of_finger(mesh: &Mesh, loads: &[FrameLoad], kinematics: Kinematics) -> [f64; 2] {
    let assembly = Assembly::new(mesh.frame(), kinematics);
    let unknowns = assembly.equations().count();
    let bent: Vec<f64> = (0..unknowns).map(|i| 0.05 * (1.7 * i as f64).sin()).collect();
    let along = DVector::from_fn(unknowns, |i, _| (2.3 * i as f64).cos());
    let at = |by: f64, loads: &[FrameLoad]| {
        let mut assembly = assembly.clone();
        let mut motion = FrameMotion::at_rest(mesh.frame());
        let moved: Vec<f64> = bent.iter().zip(&along).map(|(x, v)| x + by * v).collect();
        let linear = kinematics == Kinematics::Linear;
        assembly.equations().clone().advance(mesh.frame(), &mut motion, &moved, linear);
        assembly.evaluate(&motion, loads, 1.0);
        assembly
    };
    let residual = |by: f64, loads: &[FrameLoad]| DVector::from_column_slice(at(by, loads).residual());
    // The differentiated energy is the elastic energy of the beams, without the loads.
    let power = slope(|by| DVector::from_element(1, at(by, &[]).elastic_energy()));
    let mut change = DVector::zeros(unknowns);
    for (value, (row, column)) in at(0.0, loads).stiffness() {
        change[row] += value * along[column];
    }
    [
        difference(&DVector::from_element(1, residual(0.0, &[]).dot(&along)), &power),
        difference(&change, &slope(|by| residual(by, loads))),
    ]
}

/// Two checks for each of three subjects: an element, a load between its ends, and the finger. Each check covers all kinematics, without and with
/// shear deformation.
pub(crate) fn checks(finger: &Finger) -> Result<Vec<Check>, ProblemError> {
    // The first beam has no shear deformation. In sway, the second beam deflects as much by shear as by bending.
    let beams = [1.0, 0.5].map(|sway_factor| Beam {
        direction: Vector::new(0.8, 0.6),
        length_mm: 10.0,
        axial_rigidity_n: 1440.0,
        bending_rigidity_nmm2: 270.0,
        sway_factor,
        axis_mm: [0.3, -0.2],
    });
    let force = Vector::new(-0.4, 1.9);
    let with_shear = FingerDescription { shear_correction: SHEAR_CORRECTION, ..finger.description().clone() };
    let with_shear = Finger::new(with_shear).map_err(|error| ProblemError::Reference(error.to_string()))?;
    let meshes = [finger, &with_shear].map(|finger| Mesh::with_elements_per_member(finger, 2));
    let tip = Load::Node { node: finger.tip(), force, moment_nmm: 3.0 };
    let between = Load::at_position(0.4 * finger.description().front_length_mm, force);
    let loads = [tip, between]
        .iter()
        .map(|load| meshes[0].frame_load(load))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|e| ProblemError::Statics(e.into()))?;
    let of_all = |figures: &dyn Fn(Kinematics, usize) -> [f64; 2]| {
        let all = KINEMATICS.map(|kinematics| [0, 1].map(|shear| figures(kinematics, shear)));
        [0, 1].map(|i| worst(all.iter().flatten().map(|figures| figures[i])))
    };
    let parts = [
        (
            "one bent element",
            of_all(&|kinematics, shear| of_element(|motion| beams[shear].response(kinematics, motion))),
        ),
        (
            "load between the ends of an element",
            of_all(&|kinematics, shear| {
                of_element(|motion| beams[shear].interior_work(kinematics, 0.3, force, motion))
            }),
        ),
        (
            "bent finger with loads at and between nodes",
            of_all(&|kinematics, shear| of_finger(&meshes[shear], &loads, kinematics)),
        ),
    ];
    Ok(parts
        .into_iter()
        .flat_map(|(problem, [forces, tangent])| {
            [("forces from energy", forces), ("tangent from forces", tangent)].map(|(what, ours)| {
                let quantity = format!("{what}: largest difference / largest");
                Check::new(Kind::Internal, problem, "central differences", quantity, 0.0, ours, TOLERANCE)
            })
        })
        .collect())
}
