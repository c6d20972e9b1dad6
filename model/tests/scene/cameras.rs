//! Scenes that are refused because of their camera, markers, references or contact.

use super::refused::assert_all_refused;
use finray_fixtures::{BRACKETED_SCENE, CAMERA_SCENE};

#[test]
fn cameras_and_markers_of_a_scene_are_checked() {
    assert_all_refused(
        CAMERA_SCENE,
        r#"
        size_px = [1600, 1400] | size_px = [1600] |  | camera.size_px: expected a list of 2 numbers
        size_px = [1600, 1400] | size_px = [1600.5, 1400] |  | camera.size_px: expected whole numbers
        size_px = [1600, 1400] | size_px = [0, 1400] |  | camera.size_px: expected whole numbers from 1 to 65535, width and height
        focal_px = [1360.0, 1360.0]\n |  |  | camera.focal_px is missing
        [1360.0, 1360.0] | [1360.0, nan] |  | camera.focal_px
        [1360.0, 1360.0] | [-1360.0, 1360.0] |  | camera.focal_px: expected focal lengths along u and v in px, 0.001 to
        distortion = [0.0, | distortion = [0.0, 0.0, |  | camera.distortion: expected 4 (k1, k2, p1, p2), 5 (and k3) or 8 coefficients (and k4, k5, k6), found 6
        distortion = [0.0, 0.0, 0.0, 0.0, 0.0] | distortion = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0] |  | camera.distortion: expected at most 8 coefficients, found a thin prism
        distortion = [0.0, 0.0, 0.0, 0.0, 0.0] | distortion = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1] |  | camera.distortion: expected at most 8 coefficients, found a tilted sensor
        distortion = [0.0, | distortion_model = "fisheye"\ndistortion = [0.0, |  | camera.distortion: expected the 4 coefficients of a fisheye lens (k1, k2, k3, k4), found 5
        distortion = [0.0, | distortion_model = "fish"\ndistortion = [0.0, |  | camera.distortion_model: expected one of "brown-conrady", "fisheye"
        distortion = [0.0, | distortion = [1e7, |  | camera.distortion: expected k1, k2, p1, p2
        distortion = [0.0, | distortion = ["a", |  | camera.distortion: expected a list of numbers
        translation_mm = [-75.0, 0.0, 170.0]\n |  |  | camera.translation_mm is missing
        [-75.0, 0.0, 170.0] | [-75.0, 0.0, 1e9] |  | camera.translation_mm: expected a translation of at most
        radius_mm = 1.5 | radius_mm = 0 |  | markers.radius_mm: expected a length in mm above zero, up to 1000
        height_mm = 0.0\n |  |  | markers.height_mm is missing
        [226, 186, 46] | [226, 186] |  | markers.front_rgb: expected a list of 3 numbers
        [226, 186, 46] | [226, 186, 256] |  | markers.front_rgb: expected whole numbers from 0 to 255
        back_rgb | back_rbg |  | unknown key `markers.back_rbg`; the nearest known key is `back_rgb`
        "#,
    );
}

#[test]
fn shades_and_references_of_a_scene_are_checked() {
    assert_all_refused(
        BRACKETED_SCENE,
        r#"
        shade = "bright" | shade = "white" |  | markers.shade: expected one of "bright", "dark", found the text "white"
        inner_radius_mm = 1.0 | inner_radius_mm = 2.0 |  | markers.inner_radius_mm: expected a length in mm, zero or more and below radius_mm
        shade = "bright" | shade = "bright"\nfront_rgb = [226, 186, 46] |  | markers.shade: expected either shade or front_rgb and back_rgb, found shade and front_rgb
        at_mm = [-16.0, 20.0] | at_mm = [-16.0] |  | base.reference[1].at_mm: expected a list of 2 numbers
        at_mm = [-16.0, 20.0] |  |  | base.reference[1].at_mm is missing
        at_mm = [-16.0, 20.0] | at_mm = [-1e9, 20.0] |  | base.reference[1].at_mm: expected x and y of at most
        at_mm = [-16.0, -10.0]\nshade = "dark" | at_mm = [-16.0, -10.0] |  | base.reference[2].shade is missing
        [base] | [base]\nreferences = 2 |  | unknown key `base.references`; the nearest known key is `reference`
        [base] | [base]\nsigma_mm = 0.1 |  | base.sigma_deg is missing
        [base] | [base]\nsigma_mm = -0.1\nsigma_deg = 0.1 |  | base.sigma_mm: expected a length in mm, zero or more
        [base] | [base]\nsigma_mm = 0.1\nsigma_deg = 100 |  | base.sigma_deg: expected an angle in degrees, 0 to 90
        [base] | [base]\nturn_deg_per_n = 0.1 |  | base.sigma_mm is missing
        [base] | [base]\nsigma_mm = 0.1\nsigma_deg = 0.1\nturn_deg_per_n = 11 |  | base.turn_deg_per_n: expected an angle in degrees per newton, -10 to 10
        [base] | [base]\nsigma_mm = 0.1\nsigma_deg = 0.1\nturn_sigma_deg_per_n = -1 |  | base.turn_sigma_deg_per_n: expected an angle in degrees per newton, 0 to 10
        [markers] | [markers]\nmodel_error_mm = nan |  | markers.model_error_mm: expected a length in mm, zero or more
        [markers] | [markers]\nnoise_factor = 0.0 |  | markers.noise_factor: expected a number above 0 and up to 1
        [base] | [contact]\nfriction = -20\n[base] |  | contact.friction: expected a coefficient of friction, -10 to 10
        [base] | [contact]\nfriction_range = [0.5, 0.0]\n[base] |  | contact.friction_range: expected two coefficients
        [base] | [contact]\nfriction_range = [0.0, 0.5]\nfriction = 0.2\n[base] |  | contact.friction_range: expected either friction or friction_range, found both
        [base] | [contact]\nforce_error_share = 2.0\n[base] |  | contact.force_error_share: expected a share, 0 to 1, found 2.0
        [base] | [contact]\npad_mm = -1\n[base] |  | contact.pad_mm: expected a length in mm, zero or more
        [base] | [contact]\npad_length_mm = 300.0\n[base] |  | contact.pad_length_mm: expected a length in mm, at most the front plate's 150.16, found 300.0
        [base] | [contact]\nfriction_sigma = 0.1\n[base] |  | contact.friction is missing: expected a coefficient
        [base] | [contact]\nfriction = 0.1\nnormal = "own"\n[base] |  | contact.normal: expected one of "deformed", "undeformed"
        [base] | [contact]\nfriction = 0.1\nnormal = "undeformed"\nnormal_over_mm = 5\n[base] |  | contact.normal_over_mm: expected no value with normal
        bracket_mm = 3.0 | bracket_mm = [[3.0, 2.0]] |  | finger.ribs.bracket_mm: expected one pair for each of 4 ribs, found 1 pairs
        "#,
    );
}
