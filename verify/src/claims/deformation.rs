//! Sections I and III: from force to deformation.

use super::criteria::{MESH_SHARE, MUCH_SHARE, NEGLIGIBLE_SHARE, at_most_nodes, over_assumptions, statement};
use super::experiments::{self, range_of};
use super::{Claim, ClaimError, ClaimVerdict, between, claim, percent};
use crate::check::worst;
use crate::problems::{opensees, refinement};
use crate::study::Study;
use finray_model::Kinematics;

/// Force at which the linear model is judged, N: the largest of the gripper tests.
const FORCE_N: f64 = 3.0;
/// Stiffness of a plane-strain continuum of the finger over that of the frame, at the nodes: an independent finite-element program, with
/// Poisson's ratio 0.45 and rods as stiff discs of 3 mm. It does not ship.
const CONTINUUM: [f64; 2] = [1.61, 1.71];
/// Poisson's ratio of the continuum, and the rigid arms (mm) that bring the frame to it.
const AS_A_CONTINUUM: (f64, f64) = (0.45, 1.25);

pub(super) fn claims(study: &Study) -> Result<Vec<Claim>, ClaimError> {
    let mut opensees = opensees::deviations(&study.finger, finray_fixtures::OPENSEES_PAPER)?;
    opensees.retain(|case| case.kinematics == Kinematics::Linear);
    let off_opensees = worst(opensees.iter().map(|case| case.displacement));
    let off_mesh = refinement::linear_difference(&study.finger)?;
    let curved = experiments::linearisation(&study.finger, FORCE_N)?;
    let (near, most) = at_most_nodes(&curved, |share| share <= MUCH_SHARE);
    let mut claims = vec![
        claim(
            "\"the relationship between the external forces and the compliant deformations can be linearized without losing much accuracy\" \
             (sec. I-B)",
            "no figure",
            format!(
                "shapes differ by {} of the largest displacement, by no more than {} at {near} of {} nodes",
                between(range_of(&curved), percent),
                percent(MUCH_SHARE),
                curved.len()
            ),
            format!("linear against co-rotational frame, {FORCE_N} N along the normal at one of nodes 14 to 24"),
            format!("at most nodes no more than {}, where the paper's shading begins", percent(MUCH_SHARE)),
            statement(most),
        ),
        claim(
            "\"the difference between the proposed model and the ANSYS frame model with 25 nodes is negligible, with a maximum difference of \
             less than 1.5%\" (sec. III)",
            "1.5 % over 100 load cases",
            format!("{} of the largest displacement over {} load cases", percent(off_opensees), opensees.len()),
            "linear frame against OpenSees, load cases of this report's checks, not the paper's",
            "less than 1.5 %",
            statement(off_opensees < NEGLIGIBLE_SHARE),
        ),
        claim(
            "\"the maximum difference between the two ANSYS models with different element sizes is less than 0.26%\" (sec. III)",
            "0.26 %",
            format!("{} of the largest displacement", percent(off_mesh)),
            "linear frames of 25 and 684 nodes, which are exact at the nodes: rounding alone",
            "less than 0.26 %",
            statement(off_mesh < MESH_SHARE),
        ),
    ];
    let [free, contacts] = [study.finger.free_nodes().count(), study.finger.contact_nodes().count()];
    claims.push(claim(
        "\"Q and F are both 69 x 1 vectors\" (sec. III); \"46 network nodes\" for the inputs, \"36 independent force coordinates at most\" (sec. IV-A)",
        "69, 46, 36",
        format!("{}, {}, {}", 3 * free, 2 * free, 3 * contacts),
        "three degrees of freedom and two displacements a free node, two forces and a torque a contact node of the model",
        "the same numbers",
        statement([3 * free, 2 * free, 3 * contacts] == [69, 46, 36]),
    ));
    let coarse = study.convergence.error(0, FORCE_N);
    claims.push(claim(
        "\"decreasing element size is not necessary in terms of accuracy\" (sec. III)",
        "0.26 %",
        coarse.map_or("-".to_owned(), |error| {
            format!("linear: {}; co-rotational: up to {} of the largest displacement", percent(off_mesh), percent(error))
        }),
        format!(
            "linear frame as above; co-rotational frame of 25 nodes against the converged one, {FORCE_N} N along the normal at every sampled \
             node. The paper's model is linear, its finger is not"
        ),
        "no more than the 0.26 % from which the paper concludes it, linear and co-rotational",
        coarse.map_or(ClaimVerdict::NotTested, |error| {
            over_assumptions(&[off_mesh, error].map(|share| statement(share <= MESH_SHARE)))
        }),
    ));
    let (poisson, arm_mm) = AS_A_CONTINUUM;
    let stiffer = experiments::stiffened(&study.finger, poisson, arm_mm)?;
    claims.push(claim(
        "\"an ANSYS model using solid elements (SOLID45) and 3-D meshes ... a large difference\"; one \"possible reason\" is \"two different \
         materials due to the inserted rods\" (sec. III)",
        "no figure",
        format!("a frame with plane strain and rigid arms is {} times as stiff", between(stiffer, |x| format!("{x:.2}"))),
        format!(
            "Poisson's ratio {poisson} (assumed: a factor of {:.2}) and arms of {arm_mm} mm, chosen to meet a continuum of an independent \
             program ({}). The paper gives no figure to compare with, and no solid model is solved here",
            1.0 / (1.0 - poisson * poisson),
            between(CONTINUUM, |x| format!("{x:.2}"))
        ),
        "",
        ClaimVerdict::NotTested,
    ));
    Ok(claims)
}
