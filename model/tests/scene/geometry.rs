//! Scenes with impossible fingers are refused with one message that names line, key and expected value.

use super::refused::{assert_all_refused, assert_refused, changed, refused};
use finray_fixtures::PAPER_SCENE;
use finray_model::{Kinematics, Load, Mesh, NodeId, Scene, Vector, statics};

/// Checks that the finger of a scene carries a small force, which needs all of its members.
fn assert_solved(scene: &str, node: NodeId) {
    let mesh = Mesh::key_nodes(&Scene::from_toml(scene).unwrap_or_else(|error| panic!("{error}: {scene}")).finger);
    statics::solve(&mesh, &[Load::at_node(node, Vector::new(0.0, -0.1))], Kinematics::Linear).expect("an equilibrium");
}

#[test]
fn sizes_must_be_positive_finite_numbers() {
    let depth =
        |key: &str, value: &str| changed(PAPER_SCENE, "depth_mm = 20.0", &format!("depth_mm = 20.0\n{key} = {value}"));
    for value in ["0", "0.0", "-0.0", "-1.5", "nan", "-nan", "inf", "1e400", "1e-310", "5e-324"] {
        for (i, line) in PAPER_SCENE.lines().enumerate() {
            let Some((key, _)) = line.split_once(" = ") else { continue };
            let quantity = match key {
                "youngs_modulus_mpa" => "modulus in MPa",
                key if key.ends_with("_mm") => "length in mm",
                _ => continue,
            };
            let mut lines: Vec<String> = PAPER_SCENE.lines().map(str::to_owned).collect();
            lines[i] = format!("{key} = {value}");
            let message = refused(&lines.join("\n"));
            assert!(message.starts_with(&format!("line {}: finger.", i + 1)) && message.len() < 200, "{message}");
            assert!(message.contains(&format!("{key}: expected a positive {quantity}")), "{message}");
        }
    }
    for value in ["-0.1", "nan", "inf"] {
        for key in ["rod_arm_mm", "rib_arm_mm", "clamp_arm_mm"] {
            assert_refused(&depth(key, value), &format!("finger.{key}: expected a length in mm, zero or more"));
        }
        let camera = changed(PAPER_SCENE, "\n[finger]", &format!("[camera]\nnoise_mm = {value}\n[finger]"));
        assert_refused(&camera, "camera.noise_mm: expected a length in mm, zero or more");
    }
    for value in ["-0.1", "nan", "inf", "1e-310", "[3.0, -1.0]", "[nan, 1.0]"] {
        let bracket = changed(PAPER_SCENE, "count = 11", &format!("count = 11\nbracket_mm = {value}"));
        assert_refused(&bracket, "finger.ribs.bracket_mm: expected");
    }
    // Members of the paper's plates are 12.75 mm long. The material of rigid ribs is checked although it has no effect.
    assert_all_refused(
        PAPER_SCENE,
        r#"
        count = 11 | count = 11\nclip_mm = -1.0 | clip_mm | finger.ribs.clip_mm: expected lengths in mm, zero or more
        count = 11 | count = 11\nclip_mm = [12.8, 0.0] | clip_mm | finger.ribs.clip_mm: expected clips and rigid ends together shorter than each member
        [finger.front] | [finger.front]\nrigid_tip_mm = nan | rigid_tip_mm | finger.front.rigid_tip_mm: expected a length in mm
        [finger.back] | [finger.back]\nrigid_tip_mm = 13.0 | rigid_tip_mm | finger.back.rigid_tip_mm: expected clips and rigid ends
        [finger.back] | [finger.back]\nrigid_base_mm = 12.75 | rigid_base_mm | finger.back.rigid_base_mm: expected clips and rigid
        [finger.back] | [finger.back]\nrigid_bas_mm = 1.0 | rigid_bas_mm | the nearest known key is `rigid_base_mm`
        joints = "rigid"\nthickness_mm = 1.5 | joints = "rigid"\nrigid = true\nthickness_mm = -1.5 | 26 | finger.ribs.thickness_mm: expected a positive length in mm, found -1.5
        [finger.front] | [finger.front]\nlargest_strain = 0.0 | largest_strain | finger.front.largest_strain: expected a strain above 0 and up to 1, found 0.0
        [finger.front] | [finger.front]\nlargest_strain = -0.1 | largest_strain | finger.front.largest_strain: expected a strain above 0 and up to 1, found -0.1
        [finger.back] | [finger.back]\nlargest_strain = 1.5 | largest_strain | finger.back.largest_strain: expected a strain above 0 and up to 1, found 1.5
        [finger.ribs] | [finger.ribs]\nlargest_strain = nan | largest_strain | finger.ribs.largest_strain: expected a strain above 0 and up to 1, found NaN
        depth_mm = 20.0 | depth_mm = 20.0\nshear_correction = 1.2 | shear_correction | finger.shear_correction: expected a factor, 0 to 1, found 1.2
        depth_mm = 20.0 | depth_mm = 20.0\nshear_correction = 1e-9 | shear_correction | finger.shear_correction: expected members with a shear parameter 12 EI / (kappa G A L^2) up to 1e6, found
        "#,
    );
    // Between the middle lines of the plates, the last rib is 58 mm / 12 long.
    for (value, room) in [("2.3", true), ("2.5", false), ("[4.6, 0.0]", true), ("[0.0, 4.9]", false)] {
        let scene = changed(PAPER_SCENE, "count = 11", &format!("count = 11\nbracket_mm = {value}"));
        match room {
            true => assert!(Scene::from_toml(&scene).is_ok(), "{value}"),
            false => assert_refused(
                &scene,
                "finger.ribs.bracket_mm: expected brackets shorter than the gap between the plates at rib 11",
            ),
        }
    }
    for value in ["0.51", "-1.0", "nan", "inf"] {
        assert_refused(
            &depth("poissons_ratio", value),
            "finger.poissons_ratio: expected a ratio above -1 and up to 0.5",
        );
    }
}

#[test]
fn three_lengths_must_make_a_triangle() {
    assert_all_refused(
        PAPER_SCENE,
        r#"
        58.0 | 306.0 | base_width_mm | finger.base_width_mm: expected less than 306.0 mm
        58.0 | 400.0 | base_width_mm | make no triangle
        58.0 | 1e-300 | front_length_mm | make no triangle
        58.0 | 1e-12 | front_length_mm | make no triangle
        back_length_mm = 153.0 | back_length_mm = 95.0 | front_length_mm | finger.front_length_mm: expected less than 153.0 mm
        back_length_mm = 153.0 | back_length_mm = 211.0 | back_length_mm | finger.back_length_mm: expected less than 211.0 mm
        back_length_mm = 153.0 | back_length_mm = 1e300 | back_length_mm | make no triangle
        "#,
    );
    let huge = changed(&changed(PAPER_SCENE, "58.0", "58.0e200"), "153.0", "153.0e200");
    assert_refused(&huge, "line 10: finger.front_length_mm: expected a smaller length in mm");
}

#[test]
fn ribs_must_lie_on_the_plates_in_order() {
    assert_all_refused(
        PAPER_SCENE,
        r#"
        count = 11 | positions_mm = [[50.0, 60.0], [70.0, 55.0]] | positions_mm | on the back plate, rib 2 at 55.0 mm must lie clearly beyond the previous rib at 60.0 mm or exactly at the same position
        count = 11 | positions_mm = [[50.0, 60.0], [40.0, 70.0]] | positions_mm | on the front plate, rib 2 at 40.0 mm must lie clearly beyond
        count = 11 | positions_mm = [[50.0, 60.0], [50.0, 60.0]] | positions_mm | rib 2 at [50.0, 60.0] mm lies on the previous rib
        count = 11 | positions_mm = [[70.0, 70.0], [50.0, 50.0]] | positions_mm | expected ribs in order from base to tip that do not cross
        count = 11 | positions_mm = [[50.0, 60.0], [154.0, 70.0]] | positions_mm | expected the position of rib 2 on the front plate from 0 to below 153.0 mm, found 154.0
        count = 11 | positions_mm = [[50.0, 60.0], [70.0, 153.0]] | positions_mm | expected the position of rib 2 on the back plate from 0 to below 153.0 mm, found 153.0
        count = 11 | positions_mm = [[0.0, 0.0]] | positions_mm | rib 1 at [0.0, 0.0] mm lies on the base line
        count = 11 | positions_mm = [[-0.1, 60.0]] | positions_mm | expected the position of rib 1 on the front plate
        count = 11 | positions_mm = [[50.0, -60.0]] | positions_mm | expected the position of rib 1 on the back plate
        count = 11 | positions_mm = [[nan, 60.0]] | positions_mm | expected the position of rib 1 on the front plate from 0 to below 153.0 mm, found NaN
        count = 11 | positions_mm = [[50.0, inf]] | positions_mm | found inf
        count = 11 | positions_mm = [[1e-310, 50.0]] | positions_mm | found 1e-310
        count = 11 | count = 11\npositions_mm = [[50.0, 60.0]] | positions_mm | expected either count or positions_mm, found both
        "#,
    );
}

#[test]
fn ribs_are_at_most_a_thousand() {
    let positions = |count: usize| -> String {
        let positions: Vec<_> = (1..=count).map(|i| format!("[{0:.4}, {0:.4}]", 0.15 * i as f64)).collect();
        format!("positions_mm = [{}]", positions.join(", "))
    };
    for (ribs, expected) in [
        ("count = 1001", "finger.ribs.count: expected 0 to 1000 ribs, found 1001"),
        ("count = 1000000000000", "finger.ribs.count: expected 0 to 1000 ribs, found 1000000000000"),
        (&positions(1001), "expected at most 1000 ribs, found 1001"),
    ] {
        assert_refused(&changed(PAPER_SCENE, "count = 11", ribs), expected);
    }
    for most in ["count = 1000", &positions(1000)] {
        assert_solved(&changed(PAPER_SCENE, "count = 11", most), NodeId(1002));
    }
}

/// The shortest member of the paper's finger is the rib next to the tip, a twelfth of the base width. The first members of the plates are 12.75 mm
/// long; their other arm is 1 mm long. Ribs do not limit the arms of plates if ribs have arms of their own.
#[test]
fn arms_must_leave_something_of_every_member() {
    let with = |arms: &str| changed(PAPER_SCENE, "depth_mm = 20.0", &format!("depth_mm = 20.0\n{arms}"));
    for long in ["2.42", "3.0", "100", "1e300"] {
        for (key, member) in [("rod_arm_mm", "member"), ("rib_arm_mm", "rib")] {
            let expected = format!("finger.{key}: expected less than half of the shortest {member}, 4.83");
            assert_refused(&with(&format!("{key} = {long}")), &expected);
        }
    }
    for long in ["11.76", "1e300"] {
        let expected =
            "finger.clamp_arm_mm: expected less than 11.75 mm, which finger.rod_arm_mm leaves of a member at the clamp";
        assert_refused(&with(&format!("rod_arm_mm = 1.0\nclamp_arm_mm = {long}")), expected);
    }
    for fits in ["rod_arm_mm = 2.41", "rod_arm_mm = 1.0\nclamp_arm_mm = 11.74", "rod_arm_mm = 5.0\nrib_arm_mm = 1.0"] {
        assert_solved(&with(fits), NodeId(19));
    }
}

#[test]
fn zones_must_lie_on_their_plate() {
    let shorter = changed(PAPER_SCENE, "back_length_mm = 153.0", "back_length_mm = 140.0");
    let zone = |plate: &str, from: &str, to: &str, factor: &str| {
        format!(
            "{shorter}\n[[finger.zone]]\nplate = {plate}\nfrom_mm = {from}\nto_mm = {to}\nmodulus_factor = {factor}\n"
        )
    };
    let rows = r#"
        "front" | 140.0 | 153.1 | 0.5 | line 31: finger.zone[1].to_mm: expected a position after from_mm = 140.0 and up to 153.0 mm, found 153.1
        "back" | 130.0 | 153.0 | 0.5 | line 31: finger.zone[1].to_mm: expected a position after from_mm = 130.0 and up to 140.0 mm
        "ribs" | 130.0 | 154.0 | 0.5 | line 31: finger.zone[1].to_mm
        "front" | 140.0 | 140.0 | 0.5 | line 31: finger.zone[1].to_mm: expected a position after from_mm
        "front" | 140.0 | 130.0 | 0.5 | line 31: finger.zone[1].to_mm: expected a position after from_mm
        "front" | 140.0 | nan | 0.5 | line 31: finger.zone[1].to_mm
        "front" | -1.0 | 20.0 | 0.5 | line 30: finger.zone[1].from_mm: expected a position on the plate, 0 to 153.0 mm, found -1.0
        "front" | 153.0 | 160.0 | 0.5 | line 30: finger.zone[1].from_mm
        "front" | nan | 20.0 | 0.5 | line 30: finger.zone[1].from_mm
        "front" | 0 | 20.0 | 0 | line 32: finger.zone[1].modulus_factor: expected a positive factor, found 0.0
        "front" | 0 | 20.0 | -2 | line 32: finger.zone[1].modulus_factor
        "front" | 0 | 20.0 | inf | line 32: finger.zone[1].modulus_factor
        "side" | 0 | 20.0 | 0.5 | line 29: finger.zone[1].plate: expected one of "front", "back", "ribs", found the text "side"
        "Front" | 0 | 20.0 | 0.5 | line 29: finger.zone[1].plate
        1 | 0 | 20.0 | 0.5 | line 29: finger.zone[1].plate
        "#;
    for row in rows.lines().map(str::trim).filter(|row| !row.is_empty()) {
        let [plate, from, to, factor, expected] = row.split(" | ").collect::<Vec<_>>()[..] else { panic!("{row}") };
        assert_refused(&zone(plate, from, to, factor), expected);
    }
    // The fault is in the second of two zones.
    let second = zone("\"front\"", "0", "20.0", "0.5")
        + "[[finger.zone]]\nplate = \"back\"\nfrom_mm = 0\nto_mm = 141\nmodulus_factor = 2\n";
    assert_refused(
        &second,
        "line 36: finger.zone[2].to_mm: expected a position after from_mm = 0.0 and up to 140.0 mm",
    );
    let table = PAPER_SCENE.to_owned() + "\n[finger.zone]\nplate = \"front\"\n";
    assert_refused(&table, "line 28: finger.zone: expected tables [[finger.zone]], found a table");
}
