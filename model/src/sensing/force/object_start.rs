//! Problems with an object, started from the same problem without the object.

use super::linearised::Seen;
use super::problem::{ForceProblem, State};
use super::touching::CLOSED_SD_MM;
use crate::finger::PlatePosition;
use crate::sensing::{ContactQuestion, Direction, Lean, Normal, SensingError};

/// A gap of more than this number of standard deviations is no contact.
const LARGEST_GAP_SIGMAS: f64 = 6.0;
/// Uncertainty of the plate's shape between markers, as a multiple of the markers' noise.
const OPEN_BETWEEN_MARKERS: f64 = 2.0;
/// Number of points of the plate whose distance from the outline is evaluated.
const PLACES: usize = 400;

/// The problem for the same contacts without the object. Directions refer to the normal of the plate.
pub(super) fn without_object<'m>(problem: &ForceProblem<'m>) -> Result<ForceProblem<'m>, SensingError> {
    let plain = |question: &ContactQuestion| match question.direction {
        Direction::Leaning(lean) if lean.from == Normal::Object => {
            let from = Normal::Deformed { over_mm: 0.0 };
            ContactQuestion { direction: Direction::Leaning(Lean { from, ..lean }), ..*question }
        }
        _ => *question,
    };
    let questions: Vec<ContactQuestion> = problem.questions.iter().map(plain).collect();
    ForceProblem::new(problem.mesh, &questions)
}

/// Refuses an object that is farther from the plate, or deeper in the plate, than the uncertainty of the object's pose allows.
pub(super) fn require_touch(
    problem: &ForceProblem,
    state: &State,
    Seen { measurement, marker_noise_mm }: Seen,
) -> Result<(), SensingError> {
    let Some(touching) = &problem.object else { return Ok(()) };
    let (contact, pad) = touching.contacts[0];
    let plate = state.contacts[contact].position.plate();
    let length_mm = problem.finger().plate_length_mm(plate);
    let shape = state.posed();
    let mut nearest_mm = [f64::INFINITY; 2];
    for i in 1..=PLACES {
        let s_mm = length_mm * i as f64 / PLACES as f64;
        let missed_mm = touching.missed_mm(problem.mesh, (contact, pad), PlatePosition { plate, s_mm }, shape)?;
        if missed_mm[1].abs() < nearest_mm[1].abs() {
            nearest_mm = missed_mm;
        }
    }
    let [gap_mm, along_mm] = nearest_mm;
    // A distance along the plate counts as zero if it is smaller than the spacing of neighbouring points.
    let beyond_mm = (along_mm.abs() - length_mm / PLACES as f64).max(0.0);
    let gap_mm = gap_mm.hypot(beyond_mm).copysign(gap_mm);
    let object = &touching.object;
    let parts_mm = [
        object.sd_mm,
        object.sd_rad * object.shape.largest_radius_mm(),
        measurement.base().map_or(0.0, |base| base.sd_mm),
        OPEN_BETWEEN_MARKERS * marker_noise_mm.unwrap_or_default(),
        CLOSED_SD_MM[0],
    ];
    let sd_mm = parts_mm.into_iter().fold(0.0, f64::hypot);
    match gap_mm.abs() > LARGEST_GAP_SIGMAS * sd_mm {
        true => Err(SensingError::NotTouching { contact: contact + 1, gap_mm, sd_mm }),
        false => Ok(()),
    }
}
