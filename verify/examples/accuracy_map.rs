//! An accuracy map in a few lines: errors of linear least squares on a co-rotational finger, by position and direction of the force.
//!
//! `cargo run --release -p finray-verify --example accuracy_map` writes `accuracy_map.svg`.

use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::{Kinematics, Scene};
use finray_report::{map_figure_svg, standalone};
use finray_studies::sampling::map::{MapRequest, accuracy_maps};
use finray_studies::sampling::sampled::SampledSensor;
use finray_studies::sampling::sweep::Grid;
use finray_studies::truths::TruthId;
use finray_studies::truths::{MeshTruth, fine_mesh};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The problem: a force of 3 N at positions along the whole front plate, in directions from -80 to 80 degrees, measured without noise.
    let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE)?;
    let finger = scene.finger.clone();
    let (positions_mm, angles_deg) = Grid::grid(&finger, 24, 10.0);
    let request = MapRequest {
        positions_mm,
        angles_deg,
        is_leaning: false,
        forces_n: vec![3.0],
        noise_levels_mm: vec![0.0],
        noise_samples: 1,
        seed: 1,
    };

    // The true finger, the sensor, and the map of its errors.
    let fine = fine_mesh(&finger)?;
    let truth = MeshTruth::new(TruthId::Corotational, &fine, Kinematics::Corotational)?;
    let least_squares = SampledSensor::new(EstimatorId::LeastSquares, Networks::none());
    let map = accuracy_maps(scene, &truth, &[least_squares], &request, &|| ()).remove(0);

    // The comparison: along the normal all errors are below 10 %; at -60 degrees the largest error is above 10 %.
    let largest = |angle_deg: f64| {
        let cells = map.cells.iter().filter(|cell| cell.angle_deg == angle_deg);
        cells.filter_map(|cell| cell.mean_error).fold(0.0, f64::max)
    };
    println!(
        "largest error: {:.1} % along the normal, {:.1} % at -60 deg",
        100.0 * largest(0.0),
        100.0 * largest(-60.0)
    );
    assert!(largest(0.0) < 0.1 && largest(-60.0) > 0.1);

    // The figure, drawn last.
    std::fs::write("accuracy_map.svg", standalone(&map_figure_svg(&finger, &map, Some(3.0))?))?;
    Ok(())
}
