//! `finray sense`

use super::contacts::Contacts;
use super::parse::not_negative;
use super::{Failure, not_both_from_standard_input};
use finray_model::measurement::Measurement;
use finray_model::sensing::{
    Contact, ContactPlace, ContactQuestion, Estimate, LinearEstimator, NonlinearEstimator, Prior, check_contacts,
    sense_refining,
};
use finray_model::{Finger, Mesh};
use finray_verify::estimators::EstimatorKind;
use finray_verify::files::{csv_text, displacements, load_scene, write_text};
use serde::Serialize;
use std::path::PathBuf;

/// Sense contact forces from measured displacements, with their uncertainty.
///
/// Reads node,ux_mm,uy_mm (further columns are ignored, nodes may be missing) and writes
/// contact,s_mm,angle_deg,force_n,sigma_n, a row a contact. The direction of each force is an angle from the front
/// plate's undeformed inward normal, positive towards the tip; 0 if left out. Give a node twice with two angles to ask
/// for two components. Uncertainty comes from --noise-mm, else from the scene's camera table, else from the residual.
///
/// The nonlinear estimator follows large rotations. It alone takes the directions `normal` (of the deformed plate) and
/// `auto` (unknown), and the place `auto` (unknown); what the data cannot tell is refused. Unless told a mesh, it
/// refines until doubling the mesh changes no force by more than 0.2 %.
///
/// Examples:
///   finray sense fixtures/scenes/paper.toml --displacements shape.csv --contact 19
///   finray sense fixtures/scenes/paper.toml --displacements shape.csv --contact 16@-20 --contact 20@10 --noise-mm 0.067
///   finray solve fixtures/scenes/paper.toml --kinematics linear --load 19:-0.38,-1.96 |
///       finray sense fixtures/scenes/paper.toml --displacements - --contact 19
///   finray sense fixtures/scenes/paper.toml --displacements shape.csv --contact-at auto@normal --estimator nonlinear
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// Measured displacements (CSV); - for standard input
    #[arg(long, value_name = "FILE")]
    displacements: PathBuf,
    #[command(flatten)]
    contacts: Contacts,
    /// How forces are sensed
    #[arg(long, value_enum, default_value_t = EstimatorKind::LeastSquares)]
    estimator: EstimatorKind,
    /// Standard deviation of one measured coordinate, mm
    #[arg(long, value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Nodes of the nonlinear estimator's mesh
    #[arg(long, value_name = "N")]
    mesh_nodes: Option<usize>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

#[derive(Serialize)]
struct Row {
    contact: String,
    s_mm: f64,
    angle_deg: f64,
    force_n: f64,
    sigma_n: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    not_both_from_standard_input(&arguments.scene, &arguments.displacements, "--displacements")?;
    let scene = load_scene(&arguments.scene)?;
    let finger = &scene.finger;
    let questions = &arguments.contacts.0;
    let noise_mm = arguments.noise_mm.or(scene.camera.map(|camera| camera.noise_mm));
    let (contacts, estimate) = match arguments.estimator {
        EstimatorKind::Nonlinear => {
            let sensed = match arguments.mesh_nodes {
                None => sense_refining(finger, questions, &measured(arguments, finger)?, noise_mm)?,
                Some(nodes) => {
                    let mesh = Mesh::with_nodes(finger, nodes)?;
                    let mut estimator = NonlinearEstimator::new(&mesh, questions)?;
                    estimator.estimate(&measured(arguments, finger)?, noise_mm)?
                }
            };
            (sensed.contacts, sensed.forces)
        }
        linear => {
            let contacts = known(questions)?;
            check_contacts(finger, &contacts)?;
            let measurement = measured(arguments, finger)?;
            let prior = if linear == EstimatorKind::Ridge { Prior::PAPER } else { Prior::None };
            let estimator = LinearEstimator::new(finger, &contacts, &measurement)?;
            (contacts, estimator.estimate(&measurement, noise_mm, prior))
        }
    };
    if let Some(i) = estimate.forces_n.iter().position(|force| !force.is_finite()) {
        return Err(Failure::BadInput(format!(
            "not identifiable: a force at contact {} hardly moves the measured nodes, or the displacements are not \
             those of a finger in mm",
            i + 1
        )));
    }
    if estimate.noise_mm.is_infinite() {
        eprintln!(
            "note: as many unknowns as measured coordinates leave no residual to estimate the noise from; give \
             --noise-mm for a finite sigma_n"
        );
    }
    write_text(&arguments.out, &csv_text(rows(finger, &contacts, &estimate))?)?;
    Ok(())
}

fn measured(arguments: &Arguments, finger: &Finger) -> Result<Measurement, Failure> {
    Ok(displacements::load(&arguments.displacements, finger)?)
}

/// Contacts of known place and direction: all that a linear estimator can sense.
fn known(questions: &[ContactQuestion]) -> Result<Vec<Contact>, Failure> {
    let needs = "a place or direction that is `normal` or `auto` needs --estimator nonlinear";
    questions.iter().map(|q| q.known().ok_or_else(|| Failure::BadInput(needs.to_owned()))).collect()
}

fn rows(finger: &Finger, contacts: &[Contact], estimate: &Estimate) -> Vec<Row> {
    let forces = estimate.forces_n.iter().zip(&estimate.sigmas_n);
    contacts
        .iter()
        .zip(forces)
        .map(|(contact, (&force_n, &sigma_n))| Row {
            contact: match contact.place {
                ContactPlace::Node(node) => node.to_string(),
                ContactPlace::Place(_) => "at".to_owned(),
            },
            // Contacts were checked: each has a place on the front plate.
            s_mm: contact.place_mm(finger).unwrap_or(f64::NAN),
            angle_deg: contact.angle_deg,
            force_n,
            sigma_n,
        })
        .collect()
}
