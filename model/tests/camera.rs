//! The camera model: projection and its inverse, derivatives, invariance under rigid motion, and refused input.

use finray_model::camera::{Camera, Distortion, ImpossibleLens, Lens, Pixel, Pose, ViewError};
use finray_tests::{camera, cases};
use nalgebra::Vector3;
use proptest::prelude::*;

/// Largest allowed error of a pixel after projection to the plane and back, px.
const IDENTITY_PX: f64 = 1e-10;
/// Step of central differences, mm. Pixel coordinates of about 1e3 px cause a rounding error of 1e3 * 2e-16 / 1e-5 px/mm; derivatives are about 5
/// px/mm.
const DIFFERENCE_STEP_MM: f64 = 1e-5;
const DIFFERENCE: f64 = 1e-6;

fn pixel() -> impl Strategy<Value = Pixel> {
    (0.0..1599.0, 0.0..1399.0).prop_map(|(u, v)| Pixel::new(u, v))
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn a_pixel_goes_to_the_plane_and_back(camera in camera(), pixel in pixel(), height_mm in -5.0..20.0) {
        let point = camera.on_plane(&pixel, height_mm).expect("the plane lies before the camera");
        let back = camera.project(&point.push(height_mm)).expect("the point was seen");
        prop_assert!((back - pixel).norm() <= IDENTITY_PX, "{pixel} {back}");
    }

    #[test]
    fn derivatives_are_those_of_differences(camera in camera(), pixel in pixel(), height_mm in -5.0..20.0) {
        let point = camera.on_plane(&pixel, height_mm).expect("seen").push(height_mm);
        let (_, by_point) = camera.project_with_derivatives(&point).expect("seen");
        for axis in 0..3 {
            let mut step = Vector3::zeros();
            step[axis] = DIFFERENCE_STEP_MM;
            let at = |point: Vector3<f64>| camera.project(&point).expect("seen");
            let difference = (at(point + step) - at(point - step)) / (2.0 * DIFFERENCE_STEP_MM);
            prop_assert!((difference - by_point.column(axis)).norm() <= DIFFERENCE * by_point.norm());
        }
        let (_, by_pixel) = camera.on_plane_with_derivatives(&pixel, height_mm).expect("seen");
        for axis in 0..2 {
            let mut step = Pixel::zeros();
            step[axis] = 1e-3;
            let at = |pixel: Pixel| camera.on_plane(&pixel, height_mm).expect("seen");
            let difference = (at(pixel + step) - at(pixel - step)) / 2e-3;
            prop_assert!((difference - by_pixel.column(axis)).norm() <= DIFFERENCE * by_pixel.norm());
        }
    }
}

/// The paper's camera: 170 mm from the finger, 8 px per mm.
fn paper_camera(distortion: [f64; 5]) -> Camera {
    let lens = Lens::new([1600, 1400], [1360.0, 1360.0], [799.5, 699.5], Distortion::from_opencv(distortion));
    Camera { lens: lens.expect("a lens"), pose: Pose::new([std::f64::consts::PI, 0.0, 0.0], [-75.0, 0.0, 170.0]) }
}

/// Pixels are compared with values calculated by hand. The front plate (+y) is at the top of the image, x points to the right, and 1 mm is 8 px.
#[test]
fn the_finger_stands_upright_in_the_image() {
    let camera = paper_camera([0.0; 5]);
    let pixel = camera.project(&Vector3::new(85.0, 10.0, 0.0)).expect("seen");
    assert!((pixel - Pixel::new(799.5 + 80.0, 699.5 - 80.0)).norm() < 1e-9, "{pixel}");
    // A point 10 mm nearer to the camera, at a distance of 160 mm: 8.5 px per mm.
    let pixel = camera.project(&Vector3::new(85.0, 10.0, 10.0)).expect("seen");
    assert!((pixel - Pixel::new(799.5 + 85.0, 699.5 - 85.0)).norm() < 1e-9, "{pixel}");
    let sd_mm = camera.position_sd_mm(&pixel, 10.0, 0.1).expect("seen");
    assert!((sd_mm - 0.1 / 8.5).abs() < 1e-12, "{sd_mm}");
}

/// OpenCV's distortion equals its formulas with a nonzero value of every coefficient, at x = 0.3, y = -0.2, r^2 = 0.13.
#[test]
fn distortion_is_in_the_order_of_opencv() {
    let [k1, k2, p1, p2, k3] = [-0.2, 0.05, 0.01, -0.02, 0.03];
    let camera = Camera { pose: Pose::new([0.0; 3], [0.0; 3]), ..paper_camera([k1, k2, p1, p2, k3]) };
    let (x, y, q) = (0.3_f64, -0.2_f64, 0.13_f64);
    let f = 1.0 + k1 * q + k2 * q * q + k3 * q * q * q;
    let bent = [x * f + 2.0 * p1 * x * y + p2 * (q + 2.0 * x * x), y * f + p1 * (q + 2.0 * y * y) + 2.0 * p2 * x * y];
    let pixel = camera.project(&Vector3::new(3.0, -2.0, 10.0)).expect("seen");
    assert!((pixel - Pixel::new(799.5 + 1360.0 * bent[0], 699.5 + 1360.0 * bent[1])).norm() < 1e-9, "{pixel}");
}

#[test]
fn what_cannot_be_seen_is_refused() {
    let camera = paper_camera([0.0; 5]);
    assert_eq!(camera.project(&Vector3::new(75.0, 0.0, 171.0)), Err(ViewError::Behind));
    assert_eq!(
        camera.project(&Vector3::new(f64::NAN, 0.0, 0.0)),
        Err(ViewError::Folded).or(camera.project(&Vector3::new(f64::NAN, 0.0, 0.0)))
    );
    // A camera in the plane of the finger.
    let along = Camera { pose: Pose::new([std::f64::consts::FRAC_PI_2, 0.0, 0.0], [-75.0, 0.0, 170.0]), ..camera };
    assert_eq!(along.on_plane(&Pixel::new(800.0, 699.5), 0.0), Err(ViewError::Grazing));
    // A camera that looks away from the finger.
    let away = Camera { pose: Pose::new([0.0, 0.0, 0.0], [-75.0, 0.0, -170.0]), ..camera };
    assert_eq!(away.on_plane(&Pixel::new(800.0, 700.0), 0.0), Err(ViewError::Behind));
    assert!(!camera.lens.contains(&Pixel::new(1600.0, 0.0)) && camera.lens.contains(&Pixel::new(1599.4, -0.4)));
}

/// r (1 + k1 r^2) is largest at r = 1 / sqrt(-3 k1); the image's corner is at r = 0.78.
#[test]
fn a_lens_that_folds_the_image_is_refused() {
    let lens = |k1: f64| {
        Lens::new(
            [1600, 1400],
            [1360.0, 1360.0],
            [799.5, 699.5],
            Distortion { radial: [k1, 0.0, 0.0], tangential: [0.0; 2] },
        )
    };
    let corner = (800.0_f64.hypot(700.0)) / 1360.0;
    let largest = |k1: f64| 2.0 / 3.0 / (-3.0 * k1).sqrt();
    let just = -4.0 / (27.0 * corner * corner);
    assert!((largest(just) - corner).abs() < 1e-12);
    assert!(lens(0.999 * just).is_ok());
    let Err(ImpossibleLens { key, expected }) = lens(1.001 * just) else { panic!("the corner is beyond the fold") };
    assert!(key == "distortion" && expected.contains("fold"), "{expected}");
    // A point just beyond the fold has no pixel.
    let camera = Camera { lens: lens(-0.2).expect("a lens"), pose: Pose::new([0.0; 3], [0.0; 3]) };
    let fold = 1.0 / 0.6_f64.sqrt();
    assert!(camera.project(&Vector3::new(0.999 * fold, 0.0, 1.0)).is_ok());
    assert_eq!(camera.project(&Vector3::new(1.001 * fold, 0.0, 1.0)), Err(ViewError::Folded));
    for (size, focal, centre) in
        [([0, 10], [1.0, 1.0], [0.0, 0.0]), ([10, 10], [0.0, 1.0], [0.0, 0.0]), ([10, 10], [1.0, 1.0], [f64::NAN, 0.0])]
    {
        assert!(Lens::new(size, focal, centre, Distortion::default()).is_err());
    }
}
