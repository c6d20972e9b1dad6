//! Sensed forces, their standard deviations and warnings.

use super::{HEADER, LEAST_SQUARES, SENSED, TRUTH, linear_shape, sense, sense_text};
use crate::kit::*;

#[test]
fn contacts_keep_the_order_in_which_they_are_given() {
    let shape = linear_shape(&TRUTH);
    let order = ["--contact", "23@35", "--contact-at", "114.75@-20", "--contact", "20@10"];
    let sensed = sense(&shape, &order);
    assert_eq!(sensed.texts("contact"), ["23", "at", "20"]);
    assert_close(&sensed.numbers("s_mm"), &[25.5, 114.75, 63.75], 1e-15);
    assert_close(&sensed.numbers("force_n"), &[2.25, 1.5, -0.4], SENSED);
    let together = sense(&shape, &["--contact-at", "25.5@35", "114.75@-20", "--contact", "20@10"]);
    assert_eq!(together.texts("contact"), ["at", "at", "20"]);
    assert_close(&together.numbers("force_n"), &[2.25, 1.5, -0.4], SENSED);
}

/// The paper's finger is its own mirror image, so a mirrored table of displacements belongs to a force on the back plate.
#[test]
fn a_force_on_the_back_plate_is_that_of_the_mirror_image() {
    let front = finray(&["solve", PAPER, "--load-at", "60.04:2,-10"]).done();
    let shape = Csv::of(&front);
    let [nodes, x, y] = ["node", "ux_mm", "uy_mm"].map(|name| shape.numbers(name));
    let rows = nodes.iter().zip(x.iter().zip(&y)).map(|(node, (x, y))| format!("{},{x},{}\n", 26.0 - node, -y));
    let mirrored = format!("node,ux_mm,uy_mm\n{}", rows.collect::<String>());
    for contact in ["60.04@-10", "60.04@auto", "60.04@normal", "60.04+-1@-10+-2"] {
        let sensed = |displacements: &str, contact: &str| {
            sense(displacements, &["--contact-at", contact, "--estimator", "nonlinear", "--noise-mm", "0.05"])
        };
        let (ours, theirs) = (sensed(&mirrored, &format!("back:{contact}")), sensed(&front, contact));
        assert_eq!((ours.texts("contact"), theirs.texts("contact")), (vec!["back:60"], vec!["at"]));
        for column in &HEADER[1..] {
            assert_close(&ours.numbers(column), &theirs.numbers(column), SENSED);
        }
    }
}

#[test]
fn two_angles_on_a_node_ask_for_two_components() {
    let shape = linear_shape(&[(18, 25.0, 2.0)]);
    let sensed = sense(&shape, &["--contact", "18", "--contact", "18@90"]);
    let angle = 25.0_f64.to_radians();
    assert_close(&sensed.numbers("force_n"), &[2.0 * angle.cos(), 2.0 * angle.sin()], SENSED);
}

/// The noise is that of the option, else that of the scene, else that of the residual. A noise of zero states nothing.
#[test]
fn the_noise_is_stated_or_estimated() {
    let shape = Csv::of(&linear_shape(&[(17, -15.0, 0.02)]));
    let noisy = |i: usize, u: f64| if u == 0.0 { 0.0 } else { u + if i.is_multiple_of(2) { 0.05 } else { -0.05 } };
    let rows = shape.numbers("ux_mm").into_iter().zip(shape.numbers("uy_mm")).enumerate();
    let rows = rows.map(|(i, (x, y))| format!("{},{},{}\n", i + 1, noisy(i, x), noisy(i / 2, y)));
    let text = format!("node,ux_mm,uy_mm\n{}", rows.collect::<String>());
    let folder = Folder::new();
    let camera = folder.put("camera.toml", paper_with(&[]) + "\n[camera]\nnoise_mm = 0.2\n");
    let sigma_n = |scene: &str, more: &[&str]| {
        let sense = ["sense", scene, "--displacements", "-", "--contact", "17@-15"];
        let answer = finray_reading(text.as_bytes(), &[&sense[..], &LEAST_SQUARES, more].concat());
        Csv::of(&answer.done()).numbers("sigma_n")[0]
    };
    let option = sigma_n(PAPER, &["--noise-mm", "0.067"]);
    assert_eq!(sigma_n(&camera, &["--noise-mm", "0.067"]), option);
    assert_close(&[sigma_n(&camera, &[])], &[option * 0.2 / 0.067], 2e-3);
    let residual = sigma_n(PAPER, &[]);
    assert_eq!(sigma_n(PAPER, &["--noise-mm", "0"]), residual);
    assert_close(&[residual], &[option * 0.05 / 0.067], 0.1);
}

#[test]
fn without_a_residual_the_uncertainty_is_infinite_and_explained() {
    let answer = sense_text("node,ux_mm,uy_mm\n7,0.1,-1\n", &["--contact", "16", "--contact", "20"]);
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    assert_eq!(Csv::of(&answer.out).numbers("sigma_n"), [f64::INFINITY; 2]);
    assert_says(&answer.err, &["note: ", "noise_mm"]);
    let known = sense("node,ux_mm,uy_mm\n7,0.1,-1\n", &["--contact", "16", "--contact", "20", "--noise-mm", "0.1"]);
    assert!(known.numbers("sigma_n").iter().all(|sigma| sigma.is_finite()));
}

/// The shipped networks sense forces on the paper's finger within their stated standard deviations. The sensed forces are in the order of the
/// contacts, which may be stated as nodes or as the positions of nodes.
#[test]
fn shipped_networks_sense_the_paper_finger() {
    let truth = [(19, 0.0, 1.5), (20, 0.0, 0.8)];
    let loads = truth.map(|(node, angle, force)| paper_load(node, force, angle));
    let shape = finray(&["solve", PAPER, "--load", &loads[0], "--load", &loads[1], "--mesh-nodes", "684"]).done();
    let network = ["--estimator", "network", "--noise-mm", "0.067"];
    let ask = |contacts: &[&str]| sense(&shape, &[contacts, &network].concat());
    let sensed = ask(&["--contact", "19", "20"]);
    for ((force, sigma), (_, _, truth)) in sensed.numbers("force_n").iter().zip(sensed.numbers("sigma_n")).zip(truth) {
        // The shape has no noise, so the error is only the network's error.
        assert!(sigma > 0.01 && (force - truth).abs() < 0.5 * sigma, "{sensed:?}");
    }
    let [mut forwards, mut backwards] = [&sensed, &ask(&["--contact", "20", "19"])].map(|csv| csv.numbers("force_n"));
    backwards.reverse();
    assert_eq!(forwards, backwards);
    // The tip is node 13, 153 mm from the base, and node 25 is at the base, so nodes 19 and 20 are at 76.5 mm and 63.75 mm.
    let positions = ask(&["--contact-at", "76.5", "--contact-at", "63.75"]);
    assert_eq!(positions.numbers("force_n"), forwards);
    // With a third contact, `sense` uses the network that was trained for any subset of the nodes.
    forwards.push(0.0);
    let three = ask(&["--contact", "19", "20", "15"]).numbers("force_n");
    assert!(three.iter().zip(&forwards).all(|(ours, truth)| (ours - truth).abs() < 0.3), "{three:?}");

    // If a contact that was not stated also bends the finger, the displacements correspond to a pulling force, which occurs in no training sample.
    let other = paper_load(15, 0.5, 0.0);
    let other = finray(&["solve", PAPER, "--load", &loads[0], "--load", &other]).done();
    let message = sense_text(&other, &[&["--contact", "19", "20"][..], &network].concat()).refused();
    assert_says(&message, &["contact 2: -", "is outside the forces that the network was trained on, 0 to 5 N"]);

    let message = sense_text(&shape, &[&["--contact", "19@10"][..], &network].concat()).refused();
    assert_says(&message, &["no network ships for these contacts (19@10)", "finray train"]);
    let steel = finray_reading(
        shape.as_bytes(),
        &[&["sense", SPRING_STEEL, "--displacements", "-", "--contact", "8"][..], &network].concat(),
    );
    assert_says(&steel.refused(), &["no network ships for this finger", "finray train"]);
}

/// Errors of joints widen the interval on fingers whose ribs have no brackets, also if ribs share a junction. Such fingers once ended in a panic.
#[test]
fn errors_of_joints_widen_intervals_without_brackets() {
    let folder = Folder::new();
    let plate = "thickness_mm = 1.5\nyoungs_modulus_mpa = 50.0\n";
    let zigzag = format!(
        "name = \"zigzag\"\n[finger]\nbase_width_mm = 60.0\nfront_length_mm = 120.0\nback_length_mm = 120.0\ndepth_mm = 20.0\n\
         [finger.front]\n{plate}[finger.back]\n{plate}[finger.ribs]\njoints = \"rigid\"\n{plate}\
         positions_mm = [[25.0, 0.0], [25.0, 42.0], [55.0, 42.0], [55.0, 80.0], [84.0, 80.0]]\n"
    );
    for scene in [finray_fixtures::PAPER_SCENE.to_owned(), zigzag] {
        let exact = folder.put("exact.toml", &scene);
        let loose = folder.put("loose.toml", scene + "\n[assembly]\njoint_sigma_mm = 0.2\n");
        let shape = folder.path("shape.csv");
        finray(&["solve", &exact, "--load-at", "60:1,-20", "--mesh-nodes", "400", "--out", &shape]).done();
        let [exact, loose] = [exact, loose].map(|scene| {
            let sense = ["sense", &scene, "--displacements", &shape, "--noise-mm", "0.02", "--contact-at", "60@-20"];
            Csv::of(&finray(&sense).done())
        });
        let [narrow_n, wide_n] = [&exact, &loose].map(|sensed| sensed.numbers("sigma_n")[0]);
        assert!(wide_n > 1.02 * narrow_n, "{narrow_n} {wide_n}");
        assert!((loose.numbers("force_n")[0] - 1.0).abs() < 2.0 * wide_n, "{loose:?}");
    }
}

/// For contacts with standard deviations, a residual beyond the noise is warned of, and the scene's force error and errors of the assembly widen the
/// interval.
#[test]
fn intervals_of_contacts_with_standard_deviations_include_other_errors() {
    let folder = Folder::new();
    let shape = folder.path("shape.csv");
    finray(&["solve", PAPER, "--load-at", "76.5:2,0", "--mesh-nodes", "400", "--out", &shape]).done();
    let sense = |scene: &str, contact: &str| {
        finray(&["sense", scene, "--displacements", &shape, "--noise-mm", "0.02", "--contact-at", contact])
    };
    let exact = Csv::of(&sense(PAPER, "76.5+-0.5@0+-1").done()).numbers("sigma_n")[0];
    let (_, warnings) = sense(PAPER, "110+-0.5@0+-1").warned();
    assert!(warnings.iter().any(|warning| warning.contains("contradicts the model")), "{warnings:?}");
    let share = folder.put("share.toml", paper_with(&[]) + "\n[contact]\nforce_error_share = 0.2\n");
    let sigma_n = Csv::of(&sense(&share, "76.5+-0.5@0+-1").done()).numbers("sigma_n")[0];
    assert!(exact < 0.1 && (sigma_n - 0.4).abs() < 0.05, "{exact} {sigma_n}");
    let loose = folder.put("loose.toml", paper_with(&[]) + "\n[assembly]\njoint_sigma_mm = 0.2\n");
    let loose = Csv::of(&sense(&loose, "76.5+-0.5@0+-1").done()).numbers("sigma_n")[0];
    assert!(loose > 1.02 * exact, "{exact} {loose}");
}
