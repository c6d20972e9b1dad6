//! Tests that scenes with impossible fingers are refused with exit code 2 and one message that names file, line, key and expected value.

use crate::kit::scene::{assert_refused, refused};
use crate::kit::*;
use finray_model::Scene;

#[test]
fn sizes_must_be_positive_finite_numbers() {
    let impossible = ["0", "0.0", "-0.0", "-1.5", "nan", "-nan", "inf", "1e400", "1e-310", "5e-324"];
    for value in impossible {
        for key in ["base_width_mm", "front_length_mm", "back_length_mm", "depth_mm"] {
            let scene = paper_with(&[]);
            let line = scene.lines().find(|line| line.starts_with(key)).expect("the key").to_owned();
            assert_refused(
                &line,
                &format!("{key} = {value}"),
                key,
                &[&format!("finger.{key}: expected a positive length in mm")],
            );
        }
        for (table, line, quantity) in
            [("front", 15, "length in mm"), ("back", 19, "length in mm"), ("ribs", 25, "length in mm")]
        {
            let mut lines: Vec<_> = paper_with(&[]).lines().map(str::to_owned).collect();
            for (line, key, quantity) in
                [(line, "thickness_mm", quantity), (line + 1, "youngs_modulus_mpa", "modulus in MPa")]
            {
                assert!(lines[line - 1].starts_with(key));
                let good = std::mem::replace(&mut lines[line - 1], format!("{key} = {value}"));
                let message = refused(&lines.join("\n"));
                assert_says(&message, &[&format!("line {line}: finger.{table}.{key}: expected a positive {quantity}")]);
                assert!(message.len() < 200, "{message}");
                lines[line - 1] = good;
            }
        }
    }
    for value in ["-0.1", "nan", "inf"] {
        let arm = format!("depth_mm = 20.0\nrod_arm_mm = {value}");
        assert_refused(
            "depth_mm = 20.0",
            &arm,
            "rod_arm_mm",
            &["finger.rod_arm_mm: expected a length in mm, zero or more"],
        );
        for key in ["rib_arm_mm", "clamp_arm_mm"] {
            let arm = format!("depth_mm = 20.0\n{key} = {value}");
            let expected = format!("finger.{key}: expected a length in mm, zero or more");
            assert_refused("depth_mm = 20.0", &arm, key, &[&expected]);
        }
        let camera = format!("[camera]\nnoise_mm = {value}\n[finger]");
        assert_refused("\n[finger]", &camera, "noise_mm", &["camera.noise_mm: expected a length in mm, zero or more"]);
    }
    for value in ["-0.1", "nan", "inf", "1e-310", "[3.0, -1.0]", "[nan, 1.0]"] {
        let bracket = format!("count = 11\nbracket_mm = {value}");
        assert_refused("count = 11", &bracket, "bracket_mm", &["finger.ribs.bracket_mm: expected"]);
    }
    for (from, to, at, expected) in [
        (
            "count = 11",
            "count = 11\nclip_mm = -1.0",
            "clip_mm",
            "finger.ribs.clip_mm: expected lengths in mm, zero or more",
        ),
        // Members of the paper's plates are 12.75 mm long.
        (
            "count = 11",
            "count = 11\nclip_mm = [12.8, 0.0]",
            "clip_mm",
            "finger.ribs.clip_mm: expected clips and rigid ends together shorter than each member",
        ),
        (
            "[finger.front]",
            "[finger.front]\nrigid_tip_mm = nan",
            "rigid_tip_mm",
            "finger.front.rigid_tip_mm: expected a length in mm",
        ),
        (
            "[finger.back]",
            "[finger.back]\nrigid_tip_mm = 13.0",
            "rigid_tip_mm",
            "finger.back.rigid_tip_mm: expected clips and rigid ends",
        ),
        (
            "[finger.back]",
            "[finger.back]\nrigid_base_mm = 12.75",
            "rigid_base_mm",
            "finger.back.rigid_base_mm: expected clips and rigid",
        ),
        (
            "[finger.back]",
            "[finger.back]\nrigid_bas_mm = 1.0",
            "rigid_bas_mm",
            "the nearest known key is `rigid_base_mm`",
        ),
    ] {
        assert_refused(from, to, at, &[expected]);
    }
    // Between the middle lines of the plates, the last rib is 58 mm / 12 long.
    for (value, room) in [("2.3", true), ("2.5", false), ("[4.6, 0.0]", true), ("[0.0, 4.9]", false)] {
        let bracket = format!("count = 11\nbracket_mm = {value}");
        let scene = paper_with(&[("count = 11", &bracket)]);
        if room {
            Scene::from_toml(&scene).unwrap_or_else(|error| panic!("{value}: {error}"));
        } else {
            let expected =
                "finger.ribs.bracket_mm: expected brackets shorter than the gap between the plates at rib 11";
            assert_refused("count = 11", &bracket, "bracket_mm", &[expected]);
        }
    }
    for value in ["0.51", "-1.0", "nan", "inf"] {
        let ratio = format!("depth_mm = 20.0\npoissons_ratio = {value}");
        let expected = "finger.poissons_ratio: expected a ratio above -1 and up to 0.5";
        assert_refused("depth_mm = 20.0", &ratio, "poissons_ratio", &[expected]);
    }
    let shear = "finger.shear_correction: expected a factor, 0 to 1, found 1.2";
    assert_refused("depth_mm = 20.0", "depth_mm = 20.0\nshear_correction = 1.2", "shear_correction", &[shear]);
    let soft =
        "finger.shear_correction: expected members with a shear parameter 12 EI / (kappa G A L^2) up to 1e6, found";
    assert_refused("depth_mm = 20.0", "depth_mm = 20.0\nshear_correction = 1e-9", "shear_correction", &[soft]);
    // The material of rigid ribs is checked although it has no effect.
    let rigid = [("joints = \"rigid\"\nthickness_mm = 1.5", "joints = \"rigid\"\nrigid = true\nthickness_mm = -1.5")];
    assert_says(
        &refused(&paper_with(&rigid)),
        &["line 26: finger.ribs.thickness_mm: expected a positive length in mm, found -1.5"],
    );
}

#[test]
fn three_lengths_must_make_a_triangle() {
    for (from, to, at, expected) in [
        ("58.0", "306.0", "base_width_mm", "finger.base_width_mm: expected less than 306.0 mm"),
        ("58.0", "400.0", "base_width_mm", "make no triangle"),
        ("58.0", "1e-300", "front_length_mm", "make no triangle"),
        ("58.0", "1e-12", "front_length_mm", "make no triangle"),
        (
            "back_length_mm = 153.0",
            "back_length_mm = 95.0",
            "front_length_mm",
            "finger.front_length_mm: expected less than 153.0 mm",
        ),
        (
            "back_length_mm = 153.0",
            "back_length_mm = 211.0",
            "back_length_mm",
            "finger.back_length_mm: expected less than 211.0 mm",
        ),
        ("back_length_mm = 153.0", "back_length_mm = 1e300", "back_length_mm", "make no triangle"),
    ] {
        assert_refused(from, to, at, &[expected]);
    }
    let huge = paper_with(&[("58.0", "58.0e200"), ("153.0", "153.0e200")]);
    assert_says(&refused(&huge), &["line 10: finger.front_length_mm: expected a smaller length in mm"]);
}

#[test]
fn ribs_must_lie_on_the_plates_in_order() {
    for (positions, expected) in [
        (
            "[[50.0, 60.0], [70.0, 55.0]]",
            "on the back plate, rib 2 at 55.0 mm must lie clearly beyond the previous rib at 60.0 mm or exactly at the same position",
        ),
        ("[[50.0, 60.0], [40.0, 70.0]]", "on the front plate, rib 2 at 40.0 mm must lie clearly beyond"),
        ("[[50.0, 60.0], [50.0, 60.0]]", "rib 2 at [50.0, 60.0] mm lies on the previous rib"),
        ("[[70.0, 70.0], [50.0, 50.0]]", "expected ribs in order from base to tip that do not cross"),
        (
            "[[50.0, 60.0], [154.0, 70.0]]",
            "expected the position of rib 2 on the front plate from 0 to below 153.0 mm, found 154.0",
        ),
        (
            "[[50.0, 60.0], [70.0, 153.0]]",
            "expected the position of rib 2 on the back plate from 0 to below 153.0 mm, found 153.0",
        ),
        ("[[0.0, 0.0]]", "rib 1 at [0.0, 0.0] mm lies on the base line"),
        ("[[-0.1, 60.0]]", "expected the position of rib 1 on the front plate"),
        ("[[50.0, -60.0]]", "expected the position of rib 1 on the back plate"),
        ("[[nan, 60.0]]", "expected the position of rib 1 on the front plate from 0 to below 153.0 mm, found NaN"),
        ("[[50.0, inf]]", "found inf"),
        ("[[1e-310, 50.0]]", "found 1e-310"),
    ] {
        let positions = format!("positions_mm = {positions}");
        assert_refused("count = 11", &positions, "positions_mm", &["finger.ribs.positions_mm: ", expected]);
    }
    let both = "count = 11\npositions_mm = [[50.0, 60.0]]";
    assert_refused("count = 11", both, "positions_mm", &["expected either count or positions_mm, found both"]);
}

#[test]
fn ribs_are_at_most_a_thousand() {
    for count in ["1001", "1000000000000"] {
        let expected = format!("finger.ribs.count: expected 0 to 1000 ribs, found {count}");
        assert_refused("count = 11", &format!("count = {count}"), "count", &[&expected]);
    }
    let positions = |count: usize| -> String {
        let positions: Vec<_> = (1..=count).map(|i| format!("[{0:.4}, {0:.4}]", 0.15 * i as f64)).collect();
        format!("positions_mm = [{}]", positions.join(", "))
    };
    let expected = "expected at most 1000 ribs, found 1001";
    assert_refused("count = 11", &positions(1001), "positions_mm", &[expected]);
    let folder = Folder::new();
    for most in ["count = 1000", &positions(1000)] {
        let scene = folder.put("scene.toml", paper_with(&[("count = 11", most)]));
        let shape = Csv::of(&finray(&["solve", &scene, "--load", "1002:0,-0.1"]).done());
        assert_eq!(shape.rows.len(), 2003);
    }
}

/// The shortest member of the paper's finger is the rib next to the tip, a twelfth of the base width.
#[test]
fn arms_must_leave_something_of_every_member() {
    let arm = |arm: &str| format!("depth_mm = 20.0\nrod_arm_mm = {arm}");
    let arm_with = |rods: &str, key: &str, other: &str| format!("{}\n{key} = {other}", arm(rods));
    for long in ["2.42", "3.0", "100", "1e300"] {
        let expected = ["finger.rod_arm_mm: expected less than half of the shortest member, 4.83"];
        assert_refused("depth_mm = 20.0", &arm(long), "rod_arm_mm", &expected);
        let expected = ["finger.rib_arm_mm: expected less than half of the shortest rib, 4.83"];
        assert_refused("depth_mm = 20.0", &format!("depth_mm = 20.0\nrib_arm_mm = {long}"), "rib_arm_mm", &expected);
    }
    // The first members of the plates are 12.75 mm long. Their other arm is 1 mm long.
    for long in ["11.76", "1e300"] {
        let expected =
            "finger.clamp_arm_mm: expected less than 11.75 mm, which finger.rod_arm_mm leaves of a member at the clamp";
        assert_refused("depth_mm = 20.0", &arm_with("1.0", "clamp_arm_mm", long), "clamp_arm_mm", &[expected]);
    }
    // Ribs do not limit the arms of plates if ribs have arms of their own.
    let folder = Folder::new();
    for fits in [arm("2.41"), arm_with("1.0", "clamp_arm_mm", "11.74"), arm_with("5.0", "rib_arm_mm", "1.0")] {
        let scene = folder.put("scene.toml", paper_with(&[("depth_mm = 20.0", &fits)]));
        finray(&["solve", &scene, "--load", "19:0,-0.1", "--kinematics", "linear"]).done();
    }
}

#[test]
fn zones_must_lie_on_their_plate() {
    let zone = |plate: &str, from: &str, to: &str, factor: &str| {
        let zone =
            format!("[[finger.zone]]\nplate = {plate}\nfrom_mm = {from}\nto_mm = {to}\nmodulus_factor = {factor}\n");
        paper_with(&[("back_length_mm = 153.0", "back_length_mm = 140.0")]) + "\n" + &zone
    };
    for (plate, from, to, factor, expected) in [
        (
            "\"front\"",
            "140.0",
            "153.1",
            "0.5",
            "line 31: finger.zone[1].to_mm: expected a position after from_mm = 140.0 and up to 153.0 mm, found 153.1",
        ),
        (
            "\"back\"",
            "130.0",
            "153.0",
            "0.5",
            "line 31: finger.zone[1].to_mm: expected a position after from_mm = 130.0 and up to 140.0 mm",
        ),
        ("\"ribs\"", "130.0", "154.0", "0.5", "line 31: finger.zone[1].to_mm"),
        ("\"front\"", "140.0", "140.0", "0.5", "line 31: finger.zone[1].to_mm: expected a position after from_mm"),
        ("\"front\"", "140.0", "130.0", "0.5", "line 31: finger.zone[1].to_mm: expected a position after from_mm"),
        ("\"front\"", "140.0", "nan", "0.5", "line 31: finger.zone[1].to_mm"),
        (
            "\"front\"",
            "-1.0",
            "20.0",
            "0.5",
            "line 30: finger.zone[1].from_mm: expected a position on the plate, 0 to 153.0 mm, found -1.0",
        ),
        ("\"front\"", "153.0", "160.0", "0.5", "line 30: finger.zone[1].from_mm"),
        ("\"front\"", "nan", "20.0", "0.5", "line 30: finger.zone[1].from_mm"),
        (
            "\"front\"",
            "0",
            "20.0",
            "0",
            "line 32: finger.zone[1].modulus_factor: expected a positive factor, found 0.0",
        ),
        ("\"front\"", "0", "20.0", "-2", "line 32: finger.zone[1].modulus_factor"),
        ("\"front\"", "0", "20.0", "inf", "line 32: finger.zone[1].modulus_factor"),
        (
            "\"side\"",
            "0",
            "20.0",
            "0.5",
            "line 29: finger.zone[1].plate: expected one of \"front\", \"back\", \"ribs\", found the text \"side\"",
        ),
        ("\"Front\"", "0", "20.0", "0.5", "line 29: finger.zone[1].plate"),
        ("1", "0", "20.0", "0.5", "line 29: finger.zone[1].plate"),
    ] {
        assert_says(&refused(&zone(plate, from, to, factor)), &[expected]);
    }
    // The fault is in the second of two zones.
    let second = zone("\"front\"", "0", "20.0", "0.5")
        + "[[finger.zone]]\nplate = \"back\"\nfrom_mm = 0\nto_mm = 141\nmodulus_factor = 2\n";
    assert_says(
        &refused(&second),
        &["line 36: finger.zone[2].to_mm: expected a position after from_mm = 0.0 and up to 140.0 mm"],
    );
    let table = paper_with(&[]) + "\n[finger.zone]\nplate = \"front\"\n";
    assert_says(&refused(&table), &["line 28: finger.zone: expected tables [[finger.zone]], found a table"]);
}
