//! Forces on the back plate are sensed as forces on the front plate of the finger's mirror image.

use finray_model::finger::{Plate, PlatePosition};
use finray_model::measurement::{BaseUncertainty, Marker, Measurement};
use finray_model::mesh::Load;
use finray_model::observation::Observation;
use finray_model::scene::{ObjectFrame, ObjectPlace, TouchedDescription};
use finray_model::sensing::{
    AssemblyErrors, Contact, ContactPosition, ContactQuestion, Direction, ForcePrior, Lean, LinearEstimator,
    MeasuredContact, NonlinearEstimator, Normal, Pad, TouchedOutline,
};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};
use finray_model::{Finger, Kinematics, Mesh, NodeId, Scene, Vector, statics};
use finray_tests::{built_finger, cases, contact_node, force_for_deflection, mirrored, noisy, random_stream, seen};
use nalgebra::{Isometry2, UnitComplex};
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
            [contact.into(), at(Direction::Auto), at(Direction::NORMAL), ContactQuestion { pad: Some(pad), ..at(Direction::NORMAL) }, measured.question(0.3, pad)]
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

/// An ellipse that is not symmetric about the normal of the plate, so that a wrong sign of its rotation moves the point that touches.
const SEMI_AXES_MM: [f64; 2] = [30.0, 20.0];
const ELLIPSE_TURN_RAD: f64 = 0.4;
const POSE_SD_MM: f64 = 0.2;

/// Point of the ellipse, from its centre, at which the outward normal is `normal`.
fn facing(normal: Vector) -> Vector {
    let turn = UnitComplex::new(ELLIPSE_TURN_RAD);
    let ([a, b], along) = (SEMI_AXES_MM, turn.inverse() * normal);
    turn * Vector::new(a * a * along.x, b * b * along.y) / (a * along.x).hypot(b * along.y)
}

proptest! {
    #![proptest_config(cases(12))]

    /// `Sensor` finds the same force on both fingers if an object of known shape touches the plate, if the contact is measured, and if the finger was
    /// assembled with errors.
    #[test]
    fn objects_measured_contacts_and_errors_of_the_assembly_mirror(finger in built_finger(), at in 0.4..0.8, has_errors in any::<bool>()) {
        let (image, node) = (mirrored(&finger), contact_node(&finger, 1.0 - at));
        let s_mm = Contact { position: ContactPosition::Node(node), angle_deg: 0.0 }.position_mm(&finger).expect("on the plate");
        let contact = Contact { position: ContactPosition::at(s_mm), angle_deg: 0.0 };
        let force_n = force_for_deflection(&finger, node, 0.0, 0.02).norm();
        let mesh = Mesh::with_elements_per_member(&finger, 8);
        let load = Load::at_position(s_mm, finger.direction(0.0) * force_n);
        let Ok(shape) = statics::solve(&mesh, &[load], Kinematics::Corotational) else {
            return Err(TestCaseError::reject("no equilibrium"));
        };
        let clean = Measurement::of_shape(&finger, &shape);
        prop_assume!(clean.displacement_rms_mm() < BUCKLED * finger.plate_length_mm(Plate::Front));
        let moved = shape.motion(node);
        let inward = UnitComplex::new(moved.rotation) * finger.direction(0.0);
        let surface = moved.position + moved.displacement - inward * (0.5 * finger.description().front.thickness_mm);
        let centre = surface - facing(inward);
        let assembly = AssemblyErrors { joint_sd_mm: 0.1, preload_nmm: 1.0, preload_sd_nmm: 2.0, ..AssemblyErrors::default() };
        let scene = |finger: &Finger, centre: Vector, turn_rad: f64| {
            let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("a scene");
            let pose = Isometry2::new(centre, turn_rad);
            let place = ObjectPlace { pose, sd_mm: POSE_SD_MM, sd_rad: 0.02, frame: ObjectFrame::Base };
            let touched = TouchedDescription { shape: TouchedOutline::Ellipse { semi_axes_mm: SEMI_AXES_MM }, place: Some(place) };
            let preload_nmm = if finger == &image { -assembly.preload_nmm } else { assembly.preload_nmm };
            let assembly = has_errors.then(|| AssemblyErrors { preload_nmm, ..assembly.clone() });
            Scene { finger: finger.clone(), touched: Some(touched), assembly, ..scene }
        };
        let ours = scene(&image, Vector::new(centre.x, -centre.y), -ELLIPSE_TURN_RAD);
        let theirs = scene(&finger, centre, ELLIPSE_TURN_RAD);
        let asked = |contact: Contact| {
            let lean = Lean { from: Normal::Object, ..Lean::NONE };
            let measured = MeasuredContact { contact, direction_sd_rad: 0.03, position_sd_mm: 0.5 };
            [
                SensorContacts::Asked(vec![ContactQuestion::new(Some(contact.position), Direction::Leaning(lean))]),
                SensorContacts::Measured { contacts: vec![measured], friction: 0.3 },
                SensorContacts::known(&[contact]),
            ]
        };
        let options = SensorOptions { noise_mm: Some(NOISE * finger.plate_length_mm(Plate::Front)), ..SensorOptions::default() };
        for (ours_asked, asked) in asked(across(contact)).into_iter().zip(asked(contact)) {
            let sense = |scene: &Scene, asked: &SensorContacts, measurement: &Measurement| {
                let sensor = Sensor::new(scene.clone(), asked.clone(), options.clone()).expect("contacts");
                sensor.sense(&Observation::of_displacements(measurement))
            };
            let Ok(expected) = sense(&theirs, &asked, &clean) else { continue };
            let found = sense(&ours, &ours_asked, &flipped(&image, &clean)).expect("identifiable");
            let [found, expected] = [&found, &expected].map(|sensed| sensed.forces[0]);
            for (found, expected) in [(found.force_n, expected.force_n), (found.sigma_n, expected.sigma_n)] {
                prop_assert!((found - expected).abs() <= SAME_MINIMUM * force_n, "{found} against {expected} N of {force_n} N for {asked:?}");
            }
            prop_assert_eq!(found.contact.position.plate(), Plate::Back);
            prop_assert!((found.contact.angle_deg - expected.contact.angle_deg).abs() <= SAME_MINIMUM.to_degrees());
            if matches!(asked, SensorContacts::Asked(_)) && !has_errors {
                prop_assert!((expected.force_n / force_n - 1.0).abs() < 0.1, "{} of {force_n} N", expected.force_n);
            }
        }
    }
}
