//! `finray train`, and `finray sense --estimator network`.

use crate::kit::*;

/// Options for a network that is trained quickly.
const SMALL: [&str; 6] = ["--samples", "400", "--epochs", "4", "--hidden-layers", "6"];
/// Relative tolerance of a sensed force. With noise of 0.067 mm, the Cramer-Rao bound for a force of 2 N in the middle of the plate is 0.2 %; a small
/// network has a larger error.
const SENSED: f64 = 0.05;
/// Noise of the camera, mm; the tested shapes have no noise.
const NOISE: [&str; 2] = ["--noise-mm", "0.067"];

fn train(contacts: &[&str], options: &[&str], out: &str) -> Answer {
    finray(&[&["train", PAPER][..], contacts, &SMALL, options, &["--out", out]].concat())
}

/// Trains a network, and returns the path of its file.
fn network(folder: &Folder, contacts: &[&str], options: &[&str]) -> String {
    let out = folder.path("network.safetensors");
    let answer = train(contacts, options, &out);
    assert_eq!((answer.code, answer.out.as_str()), (Some(0), ""), "{}", answer.err);
    out
}

fn shape(loads: &[(usize, f64)]) -> String {
    let forces: Vec<_> = loads.iter().map(|&(node, force_n)| (node, force_n, 0.0)).collect();
    paper_shape(&forces, &[]).computed()
}

fn sense(displacements: &str, contacts: &[&str], network: Option<&str>) -> Answer {
    let file = network.map(|file| ["--network", file]);
    let arguments = [
        &["sense", PAPER, "--displacements", "-", "--estimator", "network"][..],
        contacts,
        &NOISE[..],
        file.as_ref().map_or(&[][..], |file| &file[..]),
    ];
    finray_reading(displacements.as_bytes(), &arguments.concat())
}

#[test]
fn a_trained_network_senses() {
    let folder = Folder::new();
    let network = network(&folder, &["--contact", "17", "21"], &[]);
    let sensed = sense(&shape(&[(17, 2.0), (21, 1.0)]), &["--contact", "21", "17"], Some(&network));
    let sensed = Csv::of(&sensed.done());
    assert_eq!(sensed.texts("contact"), ["21", "17"]);
    assert_close(&sensed.numbers("force_n"), &[1.0, 2.0], SENSED);
    assert!(sensed.numbers("sigma_n").iter().all(|sigma| (1e-3..0.5).contains(sigma)), "{sensed:?}");
}

#[test]
fn training_says_how_well_it_went() {
    let folder = Folder::new();
    let answer = train(&["--contact", "19"], &[], &folder.path("network"));
    assert_says(&answer.err, &["contact 19@0: ", "N root mean square error with 0.067 mm of noise", "80 test cases"]);
}

#[test]
fn the_seed_makes_the_weights() {
    let folder = Folder::new();
    let made = |name: &str, seed: &str| {
        let out = folder.path(name);
        assert_eq!(train(&["--contact", "19"], &["--seed", seed], &out).code, Some(0));
        std::fs::read(out).expect("the network")
    };
    let one = made("one", "1");
    assert_eq!(one, made("again", "1"));
    assert_ne!(one, made("another", "2"));
}

/// Options of `train` change the training samples; the test shows this by forces that the trained networks sense.
#[test]
fn options_reach_the_samples() {
    let folder = Folder::new();
    let truth = shape(&[(19, 4.0)]);
    let force = |options: &[&str]| {
        let network = network(&folder, &["--contact", "19"], options);
        // The shape contradicts a network that was trained on the linear finger, so `sense` may warn.
        Csv::of(&sense(&truth, &["--contact", "19"], Some(&network)).computed()).numbers("force_n")[0]
    };
    // For the co-rotational shape under 4 N at node 19, a network that was trained on the linear finger has an error of some percent.
    let (linear, nonlinear) = (force(&["--truth", "linear"]), force(&[]));
    assert!((nonlinear - 4.0).abs() < SENSED * 4.0, "{nonlinear}");
    assert!((linear - 4.0).abs() > 2.0 * (nonlinear - 4.0).abs(), "{linear} {nonlinear}");
    // Forces beyond those of the training are refused.
    let network = network(&folder, &["--contact", "19"], &["--largest-force-n", "1"]);
    let message = sense(&truth, &["--contact", "19"], Some(&network)).refused();
    assert_says(&message, &["unlike those that the network was trained on"]);
}

#[test]
fn hidden_nodes_are_no_markers() {
    let folder = Folder::new();
    let network = network(&folder, &["--contact", "19"], &["--hide", "3", "4"]);
    let all = shape(&[(19, 2.0)]);
    let message = sense(&all, &["--contact", "19"], Some(&network)).refused();
    assert_says(&message, &["node 3 is not among the 21 markers"]);
    let seen: String =
        all.lines().filter(|l| !l.starts_with("3,") && !l.starts_with("4,")).map(|l| l.to_owned() + "\n").collect();
    let forces = Csv::of(&sense(&seen, &["--contact", "19"], Some(&network)).done()).numbers("force_n");
    assert_close(&forces, &[2.0], SENSED);
}

#[test]
fn a_network_refuses_what_it_was_not_made_for() {
    let folder = Folder::new();
    let network = network(&folder, &["--contact", "19", "20"], &[]);
    let bent = shape(&[(19, 1.0)]);
    let asked = |contacts: &[&str]| sense(&bent, contacts, Some(&network)).refused();
    assert_says(&asked(&["--contact", "19"]), &["trained for exactly the contacts 19@0, 20@0, not for 19@0"]);
    assert_says(&asked(&["--contact", "19", "20@5"]), &["exactly the contacts 19@0, 20@0, not for 19@0, 20@5"]);
    assert_says(&asked(&["--contact", "19", "20@auto"]), &["needs the estimator nonlinear"]);
    let steel = ["sense", SPRING_STEEL, "--displacements", "-", "--estimator", "network", "--network", &network];
    let steel = [&steel[..], &["--contact", "8"]].concat();
    assert_says(&finray_reading(bent.as_bytes(), &steel).refused(), &["trained for another finger"]);
}

#[test]
fn files_that_are_no_networks_are_refused() {
    let folder = Folder::new();
    let good = std::fs::read(network(&folder, &["--contact", "19"], &[])).expect("the network");
    let bent = shape(&[(19, 1.0)]);
    let refused = |name: &str, bytes: &[u8]| {
        let file = folder.put(name, bytes);
        let message = sense(&bent, &["--contact", "19"], Some(&file)).refused();
        assert_says(&message, &[name]);
    };
    refused("empty", b"");
    refused("words", b"these are words, not weights");
    refused("short", &good[..good.len() - 8]);
    let mut changed = good.clone();
    *changed.last_mut().expect("bytes") ^= 1;
    refused("changed", &changed);
    let missing = sense(&bent, &["--contact", "19"], Some(&folder.path("missing"))).refused();
    assert_says(&missing, &["missing", "cannot be read"]);
}

#[test]
fn wrong_arguments_are_refused() {
    let folder = Folder::new();
    let out = folder.path("network");
    let refused = |arguments: &[&str], parts: &[&str]| {
        assert_says(&finray(&[&["train", PAPER], arguments, &["--out", &out]].concat()).refused(), parts);
    };
    refused(&[], &["contact"]);
    refused(&["--contact", "1"], &["node 1"]);
    refused(&["--contact", "19", "19"], &["contacts 1 and 2 have the same position"]);
    refused(&["--contact", "19@auto"], &["known positions and directions"]);
    refused(&["--contact", "19", "--hide", "25"], &["--hide", "2 to 24", "25"]);
    refused(&["--contact", "19", "--samples", "0"], &["--samples"]);
    refused(&["--contact", "19", "--noise-mm=-1"], &["--noise-mm"]);
    refused(&["--contact", "19", "--hidden-layers", "8,0"], &["--hidden-layers"]);
    refused(&["--contact", "19", "--any-of", "--plain"], &["--any-of"]);
    assert!(folder.names().is_empty(), "{:?}", folder.names());
    let stray = ["sense", PAPER, "--displacements", "-", "--contact", "19", "--network", "file"];
    assert_says(
        &finray_reading(b"node,ux_mm,uy_mm\n7,0,-1\n", &stray).refused(),
        &["--network: expected the option --estimator network as well"],
    );
}
