//! The fingerprint of a finger depends on the finger's numbers, not on how these numbers are written.

use finray_model::finger::{Fillets, FingerDescription, Joints, Part, RibPositions, SideFaces, Strip, Zone};
use finray_model::sensing::network::Fingerprint;
use finray_model::{Finger, Scene};
use finray_tests::paper;

fn changed(change: impl Fn(&mut FingerDescription)) -> Fingerprint {
    let mut description = paper().description().clone();
    change(&mut description);
    Fingerprint::of(&Finger::new(description).expect("a finger"))
}

#[test]
fn a_fingerprint_is_that_of_the_numbers() {
    let fingerprint = Fingerprint::of(&paper());
    let position = |i: usize| 153.0 * i as f64 / 12.0;
    let by_hand =
        changed(|d| d.ribs.positions = RibPositions::Positions((1..=11).map(|i| [position(i), position(i)]).collect()));
    assert_eq!(by_hand, fingerprint);
    let third =
        changed(|d| d.ribs.positions = RibPositions::Positions((1..=11).map(|i| [51.0 * i as f64 / 4.0; 2]).collect()));
    assert_eq!(third, fingerprint);
    let renamed = finray_fixtures::PAPER_SCENE.replace("name = \"paper\"", "name = \"mine\"");
    assert_eq!(Fingerprint::of(&Scene::from_toml(&renamed).expect("a scene").finger), fingerprint);
    assert_eq!(fingerprint.to_string().parse(), Ok(fingerprint));
    assert!("0123".parse::<Fingerprint>().is_err());
    // Thickness and modulus enter the fingerprint through EA and EI. Fingers with equal E / (1 - nu^2) therefore have equal fingerprints.
    let plane_strain = changed(|d| {
        d.poissons_ratio = 0.4;
        let softer = |strip: &mut Strip| strip.youngs_modulus_mpa *= 1.0 - 0.16;
        softer(&mut d.front);
        softer(&mut d.back);
        d.ribs.strip.as_mut().into_iter().for_each(softer);
    });
    assert_eq!(plane_strain, fingerprint);
    // Arms equal to their defaults.
    let arms = |rib_arm_mm, clamp_arm_mm| {
        changed(|d| (d.rod_arm_mm, d.rib_arm_mm, d.clamp_arm_mm) = (0.5, rib_arm_mm, clamp_arm_mm))
    };
    assert_eq!(arms(Some(0.5), Some(0.5)), arms(None, None));
}

#[test]
fn every_number_counts_in_a_fingerprint() {
    let zone = |part, from_mm, to_mm, modulus_factor| Zone { part, from_mm, to_mm, modulus_factor };
    let fillets = |plates_mm, base_mm| Fillets { plates_mm, base_mm };
    let a_bit = 1.0 + 1e-8;
    let ribs = |i: usize, j: usize| {
        move |d: &mut FingerDescription| {
            let mut positions: Vec<[f64; 2]> = (1..=11).map(|k| [12.75 * k as f64; 2]).collect();
            positions[i][j] *= 1.0 + 1e-8;
            d.ribs.positions = RibPositions::Positions(positions);
        }
    };
    let fingers = [
        changed(|_| {}),
        changed(|d| d.base_width_mm *= a_bit),
        changed(|d| d.front_length_mm *= a_bit),
        changed(|d| d.back_length_mm *= a_bit),
        changed(|d| d.depth_mm *= a_bit),
        changed(|d| d.rod_arm_mm = 1e-3),
        changed(|d| d.rib_arm_mm = Some(1e-3)),
        changed(|d| d.clamp_arm_mm = Some(1e-3)),
        changed(|d| (d.rod_arm_mm, d.rib_arm_mm) = (1e-3, Some(0.0))),
        changed(|d| (d.rod_arm_mm, d.clamp_arm_mm) = (1e-3, Some(0.0))),
        changed(|d| d.fillets = Some(fillets([0.0; 2], 0.0))),
        changed(|d| d.fillets = Some(fillets([0.5, 0.0], 0.0))),
        changed(|d| d.fillets = Some(fillets([0.0, 0.5], 0.0))),
        changed(|d| d.fillets = Some(fillets([0.0; 2], 0.5))),
        changed(|d| d.poissons_ratio = 1e-3),
        changed(|d| (d.poissons_ratio, d.side_faces) = (1e-3, Some(SideFaces::Free))),
        changed(|d| (d.poissons_ratio, d.side_faces) = (0.4, Some(SideFaces::Free))),
        changed(|d| (d.poissons_ratio, d.side_faces) = (0.4 * a_bit, Some(SideFaces::Free))),
        changed(|d| d.shear_correction = 0.8),
        changed(|d| d.shear_correction = 0.8 * a_bit),
        changed(|d| d.front.thickness_mm *= a_bit),
        changed(|d| d.front.youngs_modulus_mpa *= a_bit),
        changed(|d| d.back.thickness_mm *= a_bit),
        changed(|d| d.back.youngs_modulus_mpa *= a_bit),
        changed(|d| d.ribs.strip.as_mut().expect("elastic ribs").thickness_mm *= a_bit),
        changed(|d| d.ribs.strip.as_mut().expect("elastic ribs").youngs_modulus_mpa *= a_bit),
        changed(|d| d.ribs.strip = None),
        changed(|d| d.ribs.joints = Joints::Hinged),
        changed(|d| d.ribs.positions = RibPositions::Count(10)),
        changed(ribs(4, 0)),
        changed(ribs(4, 1)),
        changed(|d| d.zones = vec![zone(Part::Front, 10.0, 20.0, 0.5)]),
        changed(|d| d.zones = vec![zone(Part::Back, 10.0, 20.0, 0.5)]),
        changed(|d| d.zones = vec![zone(Part::Ribs, 10.0, 20.0, 0.5)]),
        changed(|d| d.zones = vec![zone(Part::Front, 10.0 * a_bit, 20.0, 0.5)]),
        changed(|d| d.zones = vec![zone(Part::Front, 10.0, 20.0 * a_bit, 0.5)]),
        changed(|d| d.zones = vec![zone(Part::Front, 10.0, 20.0, 0.5 * a_bit)]),
        changed(|d| d.zones = vec![zone(Part::Front, 10.0, 20.0, 0.5); 2]),
    ];
    for (i, one) in fingers.iter().enumerate() {
        for (j, other) in fingers.iter().enumerate().skip(i + 1) {
            assert_ne!(one, other, "{i} and {j}");
        }
    }
    let (a, b) = (zone(Part::Front, 10.0, 20.0, 0.5), zone(Part::Ribs, 30.0, 90.0, 2.0));
    assert_eq!(changed(|d| d.zones = vec![a, b]), changed(|d| d.zones = vec![b, a]));
}
