//! The camera model: projection and its inverse, derivatives, invariance under rigid motion, and refused input.

use finray_model::camera::{Camera, CoefficientsError, Distortion, Lens, Pixel, Pose, ViewError};
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

/// Largest difference to OpenCV: of pixels, px, and of undistorted coordinates, dimensionless. Pixels of about 1e3 px have rounding errors of 1e-13.
const OPENCV: f64 = 1e-9;

/// Pixels and undistorted coordinates are those of OpenCV, for its models with 4, 5 and 8 coefficients and for its fisheye model.
#[test]
fn lenses_are_those_of_opencv() {
    let mut kinds = Vec::new();
    for line in finray_fixtures::OPENCV_LENSES.lines().skip(1) {
        let row: Vec<&str> = line.split(',').collect();
        let numbers = |cell: usize| row[cell].split(' ').map(|x| x.parse().expect("a number")).collect::<Vec<f64>>();
        let [x, y, u, v] = [3, 4, 5, 6].map(|cell| numbers(cell)[0]);
        let coefficients = numbers(2);
        let distortion = match row[0] {
            "fisheye" => Distortion::fisheye(&coefficients),
            _ => Distortion::rational(&coefficients),
        };
        let distortion = distortion.expect("a distortion");
        assert_eq!(distortion.coefficients()[..coefficients.len()], coefficients);
        let lens = Lens::new([1600, 1200], [1100.0, 1080.0], [810.0, 590.0], distortion).expect("a lens");
        let pixel = lens.project(&Vector3::new(3.0 * x, 3.0 * y, 3.0)).expect("seen");
        assert!((pixel - Pixel::new(u, v)).norm() <= OPENCV, "{row:?}: {pixel}");
        let at = lens.undistorted(&Pixel::new(u, v)).expect("seen");
        assert!((at - Pixel::new(x, y)).norm() <= OPENCV, "{row:?}: {at}");
        kinds.push(row[0].to_owned());
    }
    kinds.dedup();
    assert_eq!(kinds, ["4", "5", "8", "fisheye"]);
}

/// The derivatives of a fisheye lens are those of differences on both sides of the radius up to which its factor comes from a series.
#[test]
fn derivatives_of_a_fisheye_lens_are_those_of_differences() {
    let distortion = Distortion::fisheye(&[0.1, -0.03, 0.01, -0.002]).expect("a distortion");
    let lens = Lens::new([1600, 1400], [1360.0, 1360.0], [799.5, 699.5], distortion).expect("a lens");
    for r in [1e-9, 1e-3, 0.05, 0.0707, 0.0708, 0.2, 1.0, 3.0] {
        let at = Vector3::new(0.6 * r, 0.8 * r, 1.0) * 100.0;
        let (_, by_point) = lens.project_with_derivatives(&at).expect("seen");
        for axis in 0..3 {
            let mut step = Vector3::zeros();
            step[axis] = 1e-4;
            let pixel = |point: Vector3<f64>| lens.project(&point).expect("seen");
            let difference = (pixel(at + step) - pixel(at - step)) / 2e-4;
            assert!((difference - by_point.column(axis)).norm() <= DIFFERENCE * by_point.norm(), "{r} {axis}");
        }
    }
}

#[test]
fn coefficients_of_other_lenses_are_refused() {
    let mut fourteen = [0.01; 14];
    assert_eq!(Distortion::rational(&fourteen), Err(CoefficientsError::Tilted));
    fourteen[12..].fill(0.0);
    assert_eq!(Distortion::rational(&fourteen), Err(CoefficientsError::ThinPrism));
    assert_eq!(Distortion::rational(&fourteen[..12]), Err(CoefficientsError::ThinPrism));
    fourteen[8..].fill(0.0);
    assert_eq!(Distortion::rational(&fourteen), Distortion::rational(&fourteen[..8]));
    assert_eq!(Distortion::rational(&[0.1; 6]), Err(CoefficientsError::Count(6)));
    assert_eq!(Distortion::fisheye(&[0.1; 5]), Err(CoefficientsError::FisheyeCount(5)));
}

/// r (1 + k1 r^2) is largest at r = 1 / sqrt(-3 k1); the image's corner is at r = 0.78. A lens that folds in the corner alone is valid: calibrated
/// polynomials often fold beyond the calibrated points.
#[test]
fn a_lens_sees_no_point_beyond_its_fold() {
    let lens = |k1: f64| {
        let distortion = Distortion::from_opencv([k1, 0.0, 0.0, 0.0, 0.0]);
        Lens::new([1600, 1400], [1360.0, 1360.0], [799.5, 699.5], distortion).expect("a lens")
    };
    let corner = (800.0_f64.hypot(700.0)) / 1360.0;
    let largest = |k1: f64| 2.0 / 3.0 / (-3.0 * k1).sqrt();
    let just = -4.0 / (27.0 * corner * corner);
    assert!((largest(just) - corner).abs() < 1e-12);
    assert!(!lens(0.999 * just).folds_image());
    assert!(lens(1.001 * just).folds_image());
    // A point just beyond the fold has no pixel.
    for k1 in [-0.2, -0.5] {
        let camera = Camera { lens: lens(k1), pose: Pose::new([0.0; 3], [0.0; 3]) };
        let fold = 1.0 / (-3.0 * k1).sqrt();
        assert!(camera.project(&Vector3::new(0.999 * fold, 0.0, 1.0)).is_ok());
        assert_eq!(camera.project(&Vector3::new(1.001 * fold, 0.0, 1.0)), Err(ViewError::Folded));
    }
    for (size, focal, centre) in
        [([0, 10], [1.0, 1.0], [0.0, 0.0]), ([10, 10], [0.0, 1.0], [0.0, 0.0]), ([10, 10], [1.0, 1.0], [f64::NAN, 0.0])]
    {
        assert!(Lens::new(size, focal, centre, Distortion::default()).is_err());
    }
}

/// A rational lens has a pole where its denominator is zero, at r = 1 for k4 = -1; no point beyond the pole has a pixel.
#[test]
fn a_lens_sees_no_point_beyond_its_pole() {
    let distortion = Distortion::rational(&[0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0]).expect("a distortion");
    let lens = Lens::new([1600, 1400], [1360.0, 1360.0], [799.5, 699.5], distortion).expect("a lens");
    assert!(lens.project(&Vector3::new(0.99, 0.0, 1.0)).is_ok());
    for r in [1.01, 2.0, 4.0] {
        assert_eq!(lens.project(&Vector3::new(r, 0.0, 1.0)), Err(ViewError::Folded));
    }
}
