//! Time and error of computing the shape under a load, by every beam theory on its meshes and by lattices.

use super::{ExperimentError, SpeedErrorPoint, Start, Task, TimedBy, mark_fronts, spread};
use crate::lattice::accuracy::{CONVERGED_ELEMENTS, difference};
use crate::prelude::*;
use crate::statistics::percentile;
use finray_model::statics::solve;

const SOLVED_ANGLES_DEG: [f64; 3] = [-40.0, 0.0, 40.0];

struct ReferenceSolutions {
    loads: Vec<Load>,
    reference: Vec<FingerShape>,
}

impl ReferenceSolutions {
    /// Times a solution method and compares its shapes with the reference.
    fn point(
        &self,
        model: &str,
        setting: String,
        mut shape: impl FnMut(&Load) -> Option<FingerShape>,
    ) -> SpeedErrorPoint {
        let (mut seconds, mut errors) = (Vec::new(), Vec::new());
        for (load, reference) in self.loads.iter().zip(&self.reference) {
            let start = Instant::now();
            let shape = shape(load);
            let elapsed = start.elapsed().as_secs_f64();
            if let Some(shape) = shape {
                seconds.push(elapsed);
                errors.push(difference(reference, &shape));
            }
        }
        solved_point(model, setting, seconds, worst(errors), self.loads.len())
    }
}

/// Point of a solution method. `seconds` holds the computation times (s) for those of the `asked` loads that have an equilibrium. The error is NaN if
/// no load has an equilibrium.
pub fn solved_point(model: &str, setting: String, mut seconds: Vec<f64>, error: f64, asked: usize) -> SpeedErrorPoint {
    SpeedErrorPoint {
        task: Task::Solve,
        model: model.to_owned(),
        estimator: None,
        setting,
        start: Start::None,
        seconds: percentile(&mut seconds, 50.0),
        seconds_95: Some(percentile(&mut seconds, 95.0)),
        preparation_seconds: None,
        error: if seconds.is_empty() { f64::NAN } else { error },
        bias_sigmas: None,
        failed: asked - seconds.len(),
        asked,
        on_front: false,
        timed_by: TimedBy::Report,
    }
}

/// Times beams on several meshes, and lattices of several finenesses, under the force at which maps are drawn. The force acts at `nodes` nodes along
/// the front plate, in three directions each. Errors are differences from beams with [`CONVERGED_ELEMENTS`] elements per member. Empty if the front
/// plate has no contact node besides the tip.
///
/// # Errors
/// [`ExperimentError`] if the reference has no equilibrium or a lattice cannot be built.
pub fn solving(finger: &Finger, nodes: usize, forces: ReportForces) -> Result<Vec<SpeedErrorPoint>, ExperimentError> {
    let loads = solved_loads(finger, nodes, forces);
    if loads.is_empty() {
        return Ok(Vec::new());
    }
    let fine = Mesh::with_elements_per_member(finger, CONVERGED_ELEMENTS);
    let reference = loads.par_iter().map(|load| solve(&fine, &[*load], Kinematics::Corotational));
    let reference = reference.collect::<Result<_, StaticsError>>()?;
    let solved = ReferenceSolutions { loads, reference };
    let mut points = Vec::new();
    for Beams { model, setting, kinematics, mesh } in beams(finger) {
        let mut statics = Statics::ladder(&mesh, kinematics);
        points.push(solved.point(model, setting, |load| {
            let load = mesh.frame_load(load).ok()?;
            Some(mesh.shape(&statics.equilibrium(&[load]).ok()?.motion))
        }));
    }
    for (setting, lattice) in lattices(finger)? {
        points.push(solved.point(LATTICE, setting, |load| lattice.equilibrium(&[*load]).ok()));
    }
    // Settling takes a hundred times as long as Newton's method, so only one load is settled.
    let one = ReferenceSolutions {
        loads: solved.loads.into_iter().take(1).collect(),
        reference: solved.reference.into_iter().take(1).collect(),
    };
    for fineness in [1, 2] {
        let lattice = Lattice::new(finger, fineness)?;
        let setting = bodies(&lattice);
        points.push(one.point("spring lattice, rapier", setting, |load| Some(lattice.settle(&[*load]).ok()?.shape)));
    }
    mark_fronts(&mut points);
    Ok(points)
}

/// A beam model to be timed.
pub struct Beams {
    /// Name of the model.
    pub model: &'static str,
    /// Mesh in words.
    pub setting: String,
    /// Kinematics of the model.
    pub kinematics: Kinematics,
    /// Mesh on which the model is solved.
    pub mesh: Mesh,
}

/// All beam models to be timed: each kinematics on each of its meshes.
pub fn beams(finger: &Finger) -> Vec<Beams> {
    let theories = [
        (Kinematics::Linear, "linear beams"),
        (Kinematics::CorotationalChord, "co-rotational, strain of the chord"),
        (Kinematics::Corotational, "co-rotational"),
    ];
    let on_meshes = |(kinematics, model)| {
        // Linear beam elements are exact at the nodes, so finer meshes only take longer.
        let elements: &[usize] = if kinematics == Kinematics::Linear { &[1] } else { &[1, 2, 4, 8] };
        elements.iter().map(move |&elements| {
            let mesh = Mesh::with_elements_per_member(finger, elements);
            Beams { model, setting: format!("{} nodes", mesh.node_count()), kinematics, mesh }
        })
    };
    theories.into_iter().flat_map(on_meshes).collect()
}

/// Name of lattices that are solved by Newton's method.
pub const LATTICE: &str = "spring lattice, Newton";

/// All lattices to be timed, with their settings in words.
///
/// # Errors
/// [`LatticeError`] if a lattice cannot be built.
pub fn lattices(finger: &Finger) -> Result<Vec<(String, Lattice)>, LatticeError> {
    let build = |fineness| Lattice::new(finger, fineness).map(|lattice| (bodies(&lattice), lattice));
    [1, 2, 3, 4].into_iter().map(build).collect()
}

fn bodies(lattice: &Lattice) -> String {
    format!("{} bodies", lattice.assembly().bodies.len())
}

/// Loads for timing shapes: the force at which maps are drawn, at `nodes` nodes along the front plate, in three directions each.
pub fn solved_loads(finger: &Finger, nodes: usize, forces: ReportForces) -> Vec<Load> {
    let force = |angle_deg| finger.direction(angle_deg) * forces.drawn_n();
    let directions = |node| SOLVED_ANGLES_DEG.map(|angle_deg| Load::at_node(node, force(angle_deg)));
    spread(finger, nodes).flat_map(directions).collect()
}
