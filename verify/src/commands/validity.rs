//! Warnings where the assumptions of the beam model do not hold: large strains, shear, bending out of the plane.

use super::print_message;
use finray_model::sensor::{SensedForces, Sensor};
use finray_model::validity::Doubt;

/// Warns if the co-rotational finger violates the assumptions of the beam model under the sensed forces.
pub fn warn_of_forces(sensor: &Sensor, sensed: &SensedForces) {
    match sensor.doubts(sensed) {
        Ok(doubts) => warn(&doubts),
        Err(error) => {
            print_message(format_args!("warning: the finger has no equilibrium under the sensed forces: {error}"))
        }
    }
}

/// Prints a warning for each violated assumption of the beam model. The result is still written, so the exit code is 0.
fn warn(doubts: &[Doubt]) {
    for doubt in doubts {
        print_message(format_args!("warning: {doubt}"));
    }
}
