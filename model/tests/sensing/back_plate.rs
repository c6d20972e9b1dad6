//! Forces on the back plate are sensed as forces on the front plate of the finger's mirror image.

use finray_model::finger::{Plate, PlatePosition};
use finray_model::measurement::{BaseUncertainty, Marker, Measurement};
use finray_model::sensing::{
    Contact, ContactPosition, ContactQuestion, Direction, ForcePrior, LinearEstimator, MeasuredContact,
    NonlinearEstimator, Pad,
};
use finray_model::{Finger, Kinematics, Mesh, NodeId, Vector};
use finray_tests::{built_finger, cases, contact_node, force_for_deflection, mirrored, noisy, random_stream, seen};
use nalgebra::UnitComplex;
use proptest::prelude::*;

/// Noise of a marker coordinate, relative to the length of the plate.
const NOISE: f64 = 1e-4;
/// Largest difference of two estimates, relative to the force; both are least-squares solutions of the same problem up to rounding.
const SAME_SOLUTION: f64 = 1e-6;
/// The same for the nonlinear estimator, whose search ends at a relative change of the forces.
const SAME_MINIMUM: f64 = 1e-3;

/// Root mean square of the displacements of a finger that has buckled, relative to the length of the plate: several times the intended deflection.
const BUCKLED: f64 = 0.1;

/// Rotation of the base in half of the cases, rad: far more than the largest difference of two directions.
const BASE_TURN_RAD: f64 = 0.01;

/// The mirror image of a measurement, on the finger `image`.
fn flipped(image: &Finger, measurement: &Measurement) -> Measurement {
    let last = image.key_node_count() + 1;
    let flipped = |marker: &Marker| Marker {
        node: NodeId(last - marker.node.0),
        displacement: Vector::new(marker.displacement.x, -marker.displacement.y),
        ..*marker
    };
    Measurement::new(image, measurement.markers().iter().map(flipped)).expect("the same markers")
}

/// The same contact on the other plate.
fn across(contact: Contact) -> Contact {
    let ContactPosition::At(PlatePosition { plate, s_mm }) = contact.position else { panic!("a position") };
    let plate = if plate == Plate::Front { Plate::Back } else { Plate::Front };
    Contact { position: ContactPosition::At(PlatePosition { plate, s_mm }), ..contact }
}

/// A contact at a share of the front plate's length, with a force that deflects the finger by `share` of this length.
fn pushed(finger: &Finger, at: f64, angle_deg: f64, share: f64) -> (Contact, f64) {
    let contact = Contact { position: ContactPosition::at(at * finger.plate_length_mm(Plate::Front)), angle_deg };
    (contact, force_for_deflection(finger, contact_node(finger, 1.0 - at), angle_deg, share).norm())
}

proptest! {
    #![proptest_config(cases(48))]

    /// Least squares finds the same forces on both fingers, also if one force acts on each plate.
    #[test]
    fn least_squares_mirrors(finger in built_finger(), at in prop::collection::vec((0.3..0.9, -40.0..40.0), 1..=2), case in 0..u64::MAX) {
        let (image, mesh) = (mirrored(&finger), Mesh::key_nodes(&finger));
        let (mut contacts, forces_n): (Vec<Contact>, Vec<f64>) = at.iter().map(|&(at, angle)| pushed(&finger, at, angle, 0.02)).unzip();
        contacts.iter_mut().skip(1).for_each(|contact| *contact = across(*contact));
        prop_assume!(contacts.iter().all(|contact| contact.position_mm(&finger) < Some(finger.plate_length_mm(contact.position.plate()))));
        let noise_mm = NOISE * finger.plate_length_mm(Plate::Front);
        let theirs = noisy(&seen(&mesh, &contacts, &forces_n, Kinematics::Linear).expect("linear"), noise_mm, &mut random_stream(1, case));
        let sensed = |finger: &Finger, contacts: &[Contact], measurement: &Measurement| {
            let estimator = LinearEstimator::new(finger, contacts, measurement)?;
            Ok::<_, finray_model::sensing::SensingError>(estimator.estimate(measurement, Some(noise_mm), ForcePrior::None))
        };
        let Ok(expected) = sensed(&finger, &contacts, &theirs) else { return Err(TestCaseError::reject("not identifiable")) };
        let other: Vec<Contact> = contacts.iter().map(|contact| across(*contact)).collect();
        let found = sensed(&image, &other, &flipped(&image, &theirs)).expect("identifiable");
        let span = expected.singular_values[0] / expected.singular_values[contacts.len() - 1];
        for (found, expected) in [(&found.forces_n, &expected.forces_n), (&found.sigmas_n, &expected.sigmas_n)] {
            for (found, expected) in found.iter().zip(expected) {
                prop_assert!((found - expected).abs() <= SAME_SOLUTION * span * expected.abs(), "{found} against {expected}, span {span:e}");
            }
        }
    }

    /// The nonlinear estimator finds the same force and direction on both fingers: for known, unknown, leaning and measured directions, with a pad, and
    /// for a base that turns under the force.
    #[test]
    fn the_nonlinear_estimator_mirrors(finger in built_finger(), at in 0.4..0.9, angle in -20.0..20.0, turns in any::<bool>(), case in 0..u64::MAX) {
        let image = mirrored(&finger);
        let (contact, force_n) = pushed(&finger, at, angle, 0.05);
        let noise_mm = NOISE * finger.plate_length_mm(Plate::Front);
        let [mesh, image_mesh] = [&finger, &image].map(|finger| Mesh::with_elements_per_member(finger, 2));
        let Ok(clean) = seen(&mesh, &[contact], &[force_n], Kinematics::Corotational) else {
            return Err(TestCaseError::reject("no equilibrium"));
        };
        // A search for the shape of a finger that has buckled depends on rounding.
        prop_assume!(clean.displacement_rms_mm() < BUCKLED * finger.plate_length_mm(Plate::Front));
        let turn = UnitComplex::new(if turns { BASE_TURN_RAD } else { 0.0 });
        let turned = |marker: &Marker| {
            let rest = finger.marker_position(marker.node);
            Marker { displacement: turn * (rest + marker.displacement) - rest, ..*marker }
        };
        let clean = Measurement::new(&finger, clean.markers().iter().map(turned)).expect("the same markers");
        let theirs = noisy(&clean, noise_mm, &mut random_stream(2, case));
        // A force on the other plate turns the base the other way.
        let base = turns.then(|| BaseUncertainty { sd_mm: noise_mm, sd_rad: BASE_TURN_RAD, turn_rad_per_n: 2e-3 / force_n, turn_sd_rad_per_n: 1e-3 / force_n });
        let ours = flipped(&image, &theirs).with_base(base);
        let theirs = theirs.with_base(base);
        let asked = |contact: Contact| {
            let pad = Pad { length_mm: 0.1 * at * finger.plate_length_mm(Plate::Front), thickness_mm: 2.0 };
            let at = |direction| ContactQuestion::new(Some(contact.position), direction);
            let measured = MeasuredContact { contact, direction_sd_rad: 0.03, position_sd_mm: 0.5 };
            [contact.into(), at(Direction::Auto), at(Direction::NORMAL), ContactQuestion { pad, ..at(Direction::NORMAL) }, measured.question(0.3, pad)]
        };
        for (ours_asked, asked) in asked(across(contact)).into_iter().zip(asked(contact)) {
            let sense = |mesh: &Mesh, question, measurement: &Measurement| {
                NonlinearEstimator::new(mesh, &[question])?.estimate(measurement, Some(noise_mm))
            };
            let Ok(expected) = sense(&mesh, asked, &theirs) else { continue };
            // If the asked direction does not explain the measurement, there are several minima.
            if expected.forces.warning.is_some() {
                continue;
            }
            let found = sense(&image_mesh, ours_asked, &ours).expect("identifiable");
            let pairs = [(found.forces.forces_n[0], expected.forces.forces_n[0]), (found.forces.sigmas_n[0], expected.forces.sigmas_n[0])];
            for (found, expected) in pairs {
                prop_assert!((found - expected).abs() <= SAME_MINIMUM * force_n, "{found} against {expected} N for {asked:?}");
            }
            let [found, expected] = [&found, &expected].map(|estimate| estimate.contacts[0]);
            prop_assert_eq!(found.position.plate(), Plate::Back);
            prop_assert!((found.angle_deg - expected.angle_deg).abs() <= SAME_MINIMUM.to_degrees(), "{:?} against {:?}", found, expected);
        }
    }
}
