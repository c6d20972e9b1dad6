//! Contacts as measured by the camera, and the forces sensed at them.

use super::{COARSE, last, prepared, scene, steps};
use finray_contact::outline::ContactOutline;
use finray_contact::press::{ContactScene, HalfSpan, NotSensed, SeenContact, read_contact, seen_contacts};
use finray_contact::{Touch, TouchedPart, Wall};
use finray_model::finger::{Plate, PlatePosition};
use finray_model::scene::ObjectDescription;
use finray_model::sensing::{Contact, ContactPosition};
use finray_model::{NodeId, Scene, Vector};
use finray_tests::CAMERA_NOISE_MM;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The camera does not see the distribution of the force: other forces at the same touches give the same contacts.
#[test]
fn contacts_are_seen_alike_whatever_they_carry() {
    let finger = scene("shape = \"disc\"\nradius_mm = 1\nat_mm = 1\ntravel_mm = 1").finger;
    let touch = |s_mm: f64, angle_deg: f64, force_n: f64| {
        let normal = finger.direction(angle_deg);
        let point = finger.plate_point(Plate::Front, s_mm);
        let (part, force) = (TouchedPart::On(Wall::Front, s_mm), normal * force_n);
        Touch { part, clamped: false, point, normal, force, overlap_mm: 0.0 }
    };
    let seen = |forces_n: [f64; 2]| {
        let touches = [touch(80.0, -4.0, forces_n[0]), touch(82.0, 6.0, forces_n[1])];
        let seen = seen_contacts(&finger, &touches, |_| 10.0);
        assert_eq!(seen.len(), 1);
        seen[0]
    };
    let (one, other) = (seen([3.0, 1.0]), seen([1.0, 3.0]));
    assert_eq!((one.contact, one.point), (other.contact, other.point));
    assert!((one.contact.angle_deg - 1.0).abs() < 1e-9, "the middle: {:?}", one.contact);
    assert!(matches!(one.contact.position, ContactPosition::At(at) if (at.s_mm - 81.0).abs() < 1e-9));
}

/// The camera reads a finely sampled polygon as the curve that it samples, and not by the ends of one short side. An octagon and a box touch with flat
/// faces, and so does the long side of a box whose corners are finely sampled arcs.
#[test]
fn facets_of_a_sampled_curve_are_no_flat_faces() {
    const RADIUS_MM: f64 = 20.0;
    const ROD_MM: f64 = 1.5;
    let finger = scene("shape = \"disc\"\nradius_mm = 1\nat_mm = 1\ntravel_mm = 1").finger;
    let node = finger.contact_nodes().next().expect("a rod");
    let baseline_mm = |outline: &ContactOutline, at: [f64; 2], part: TouchedPart| {
        let (object, normal) = (Vector::new(70.0, 40.0), Vector::new(0.0, -1.0));
        let point = object + Vector::from(at);
        let touch = Touch { part, clamped: false, point, normal, force: normal, overlap_mm: 0.0 };
        finray_contact::press::baseline_mm(&finger, ROD_MM, outline, object, &touch)
    };
    let around = |count: usize| {
        let corner = |i: usize| {
            let (sin, cos) =
                (std::f64::consts::TAU * (i as f64 + 0.5) / count as f64 - 0.5 * std::f64::consts::PI).sin_cos();
            Vector::new(cos, sin) * RADIUS_MM
        };
        ContactOutline::polygon(&(0..count).map(corner).collect::<Vec<_>>())
    };
    let lowest = |count: usize| [0.0, -RADIUS_MM * (std::f64::consts::PI / count as f64).cos()];
    let (rod, wall) = (TouchedPart::Rod(node), TouchedPart::On(Wall::Front, 70.0));
    let disc = ContactOutline::disc(RADIUS_MM);
    for part in [rod, wall] {
        let of_disc_mm = baseline_mm(&disc, [0.0, -RADIUS_MM], part);
        for count in [30, 90, 360] {
            let corner = around(count).corners().0[0];
            for at in [lowest(count), corner.into()] {
                let found_mm = baseline_mm(&around(count), at, part);
                // Half the side over the sine of half the turn is the radius; the sine differs by 0.2 % at 30 sides.
                assert!(
                    (found_mm / of_disc_mm - 1.0).abs() < 2e-3,
                    "{count} sides at {at:?}: {found_mm}, {of_disc_mm} mm"
                );
            }
        }
        let side_mm = 2.0 * RADIUS_MM * (std::f64::consts::PI / 8.0).sin();
        assert!((baseline_mm(&around(8), lowest(8), part) - side_mm).abs() < 1e-9);
    }
    let halved = [[-10.0, -8.0], [-2.0, -8.0], [2.0, -8.0], [10.0, -8.0], [10.0, 8.0], [-10.0, 8.0]].map(Vector::from);
    let halved = ContactOutline::polygon(&halved);
    assert!((baseline_mm(&halved, [0.5, -8.0], rod) - 20.0).abs() < 1e-9, "three sides on one line are one face");
    let arc = |middle: [f64; 2], from_deg: f64| {
        (0..=9).map(move |i| {
            let (sin, cos) = (from_deg + 10.0 * f64::from(i)).to_radians().sin_cos();
            Vector::from(middle) + Vector::new(cos, sin) * 2.0
        })
    };
    let corners: Vec<Vector> = arc([10.0, 6.0], 0.0)
        .chain(arc([-10.0, 6.0], 90.0))
        .chain(arc([-10.0, -6.0], 180.0))
        .chain(arc([10.0, -6.0], 270.0))
        .collect();
    let rounded = ContactOutline::polygon(&corners);
    assert!((baseline_mm(&rounded, [3.0, -8.0], rod) - 20.0).abs() < 1e-9, "the flat face between two arcs");
    let on_arc = [10.0 + 2.0 * 45.0_f64.to_radians().sin(), -6.0 - 2.0 * 45.0_f64.to_radians().cos()];
    assert!((baseline_mm(&rounded, on_arc, rod) - 3.5).abs() < 0.01, "the middle of the arc and that of the rod");
}

/// Positions and directions read by the camera scatter about the true values with the stated standard deviations.
#[test]
fn read_contacts_scatter_as_stated() {
    const READINGS: usize = 4000;
    let object = "shape = \"disc\"\nradius_mm = 20\nat_mm = 76.5\ntravel_mm = 1\nsteps = 1";
    let (step, finger) = (last(object, COARSE), scene(object).finger);
    let seen = step.contacts[0];
    assert_eq!(seen.baseline_mm, 21.5, "from the middle of the disc to that of the rod");
    let plate = SeenContact { contact: Contact { position: ContactPosition::at(70.0), ..seen.contact }, ..seen };
    let mut noise = ChaCha8Rng::seed_from_u64(7);
    let mut normal = || StandardNormal.sample(&mut noise);
    let (mut turns, mut shifts) = (0.0, 0.0);
    let mut stated = [0.0; 2];
    for _ in 0..READINGS {
        let read = read_contact(&finger, &plate, CAMERA_NOISE_MM, &mut normal);
        let ContactPosition::At(PlatePosition { s_mm, .. }) = read.contact.position else { panic!("a position") };
        turns += (read.contact.angle_deg - plate.contact.angle_deg).to_radians().powi(2) / READINGS as f64;
        shifts += (s_mm - 70.0).powi(2) / READINGS as f64;
        stated = [read.direction_sd_rad, read.position_sd_mm];
    }
    // Tolerance: four standard errors of a variance.
    let chance = 4.0 * (2.0 / READINGS as f64).sqrt();
    for (found, stated) in [(turns, stated[0]), (shifts, stated[1])] {
        assert!((found / stated.powi(2) - 1.0).abs() < chance, "{found}, {} stated", stated.powi(2));
    }
    assert!((stated[0] - 2.0_f64.sqrt() * CAMERA_NOISE_MM / 21.5).abs() < 1e-12);
    let exact = read_contact(&finger, &plate, 0.0, &mut normal);
    assert_eq!((exact.contact, exact.position_sd_mm), (plate.contact, 0.0));
    assert!(
        exact.direction_sd_rad < 1e-15,
        "{}: the direction is a unit vector up to rounding",
        exact.direction_sd_rad
    );
}

/// A force on a rib is no force on a plate, so none is sensed, and the message names the place.
#[test]
fn forces_on_ribs_are_not_sensed() {
    let object = "shape = \"disc\"\nradius_mm = 20\nat_mm = 76.5\ntravel_mm = 1\nsteps = 1";
    let mut step = last(object, COARSE);
    step.contacts[0].wall = Wall::Rib(3);
    step.contacts[0].contact.position = ContactPosition::at(12.5);
    let refused = prepared(&scene(object)).sense(&step, CAMERA_NOISE_MM, || 0.0);
    assert_eq!(refused.err(), Some(NotSensed::Elsewhere { name: "rib4:12.5".to_owned() }));
}

/// Two rods are separate contacts at any distance. A touch of the plate close behind a rod, counted from the base, belongs to the contact of this
/// rod. The distribution of the force within the contact is unknown.
#[test]
fn two_rods_are_two_contacts() {
    let text =
        finray_fixtures::PAPER_SCENE.replace("count = 11", "positions_mm = [[40, 40], [75, 75], [78, 78], [120, 120]]");
    let finger = Scene::from_toml(&text).expect("a good scene").finger;
    let touch = |part, angle_deg: f64, force_n: f64| {
        let normal = finger.direction(angle_deg);
        Touch { part, clamped: false, point: Vector::zeros(), normal, force: normal * force_n, overlap_mm: 0.0 }
    };
    // Nodes 9 and 8 are at 75 and 78 mm.
    let touches = [
        touch(TouchedPart::Rod(NodeId(9)), 0.0, 3.0),
        touch(TouchedPart::On(Wall::Front, 75.2), 90.0, 4.0),
        touch(TouchedPart::Rod(NodeId(8)), -10.0, 1.0),
        touch(TouchedPart::On(Wall::Front, 100.0), 0.0, 1.0),
    ];
    let seen = seen_contacts(&finger, &touches, |_| 10.0);
    let positions: Vec<ContactPosition> = seen.iter().map(|seen| seen.contact.position).collect();
    let expected = [ContactPosition::at(75.1), ContactPosition::Node(NodeId(8)), ContactPosition::at(100.0)];
    assert_eq!(positions, expected);
    assert!((seen[0].contact.angle_deg - 45.0).abs() < 1e-9 && (seen[1].contact.angle_deg + 10.0).abs() < 1e-9);
    let half = seen[0].half_span;
    assert!(
        (half.along_mm - 0.1).abs() < 1e-9 && (half.turn_rad - std::f64::consts::FRAC_PI_4).abs() < 1e-9,
        "{half:?}"
    );
    assert_eq!(seen[1].half_span, HalfSpan::default());
    // Without noise, the standard deviation of the position equals the standard deviation of a uniform distribution over the contact's span.
    let read = read_contact(&finger, &seen[0], 0.0, || 0.0);
    assert!((read.position_sd_mm - 0.1 / 3.0_f64.sqrt()).abs() < 1e-9 && read.direction_sd_rad > 0.4, "{read:?}");
    // The forces are 3 N at 0 degrees and 4 N at 90 degrees, and the contact's direction is at 45 degrees. The expected values are the components of
    // the resultant along and across the contact's direction.
    let [along_n, across_n] = [7.0, 1.0].map(|sum_n| sum_n / 2.0_f64.sqrt());
    assert!((seen[0].normal_n - along_n).abs() < 1e-12 && (seen[0].friction_n - across_n).abs() < 1e-12, "{seen:?}");
}

/// Without friction, no friction is reported at contacts of rods, plate and tip, and the force is sensed.
#[test]
fn smooth_objects_have_no_friction() {
    for object in [
        "shape = \"disc\"\nradius_mm = 5\nat_mm = 152\ntravel_mm = 4\nsteps = 1",
        "shape = \"box\"\nwidth_mm = 20\nheight_mm = 20\nrotation_deg = 30\nat_mm = 70\nforce_n = 2\nsteps = 1",
    ] {
        let prepared = prepared(&scene(object)).with_fineness(2);
        let step = steps(&prepared).pop().expect("a step");
        assert!(step.contacts.iter().all(|seen| seen.friction_n.abs() < 1e-9), "{:?}", step.contacts);
        let sensed = prepared.sense(&step, 0.0, || 0.0).expect("an answer").expect("a contact");
        assert!(sensed.total.relative_error().abs() < 0.03, "{:?}", sensed.total);
    }
}

/// A force on the clamp is not sensed, but is part of the force on the base.
#[test]
fn a_force_on_the_clamp_is_separate() {
    let step = last("shape = \"disc\"\nradius_mm = 60\nat_mm = 6.5\nforce_n = 3\nsteps = 1", 2);
    assert!(step.contacts.iter().any(|seen| seen.clamped) && step.contacts.iter().any(|seen| !seen.clamped));
    let whole = step.pressed.contact_force();
    assert!((step.pressed.base_force - whole).norm() < 1e-3 * whole.norm());
    assert!((step.pressed.hand_force - whole).norm() < 1e-3 * whole.norm());
    let prepared = prepared(&scene("shape = \"disc\"\nradius_mm = 60\nat_mm = 6.5\nforce_n = 3\nsteps = 1"));
    let sensed = prepared.sense(&step, 0.0, || 0.0).expect("an answer").expect("a contact");
    assert_eq!(sensed.contacts.len(), 1);
    assert!(sensed.total.true_n < 0.9 * 3.0, "{:?}", sensed.total);
}

/// A non-convex outline touches only with its prongs, and not with the gap between them.
#[test]
fn a_fork_touches_with_its_prongs() {
    let scene = Scene::from_toml(finray_fixtures::FORK_SCENE).expect("a good scene");
    let object = ObjectDescription { steps: 1, ..scene.object.clone().expect("an object") };
    let corner = |line: &str| {
        let (x, y) = line.split_once(',').expect("two numbers");
        Vector::new(x.trim().parse().expect("a number"), y.trim().parse().expect("a number"))
    };
    let corners: Vec<Vector> = finray_fixtures::FORK_OUTLINE.lines().skip(1).map(corner).collect();
    let prepared = ContactScene::new(&scene, &object, &corners).expect("an outline").with_fineness(COARSE);
    let step = steps(&prepared).pop().expect("a step");
    assert_eq!(step.contacts.len(), 2, "{:?}", step.contacts);
    let positions: Vec<f64> =
        step.contacts.iter().map(|seen| seen.contact.position_mm(&scene.finger).expect("a position")).collect();
    // The prongs are 28 to 44 mm apart, so the nearest rods carry the force.
    assert!((28.0..44.0).contains(&(positions[1] - positions[0])), "{positions:?}");
}
