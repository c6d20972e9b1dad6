//! `finray sense`

use super::contacts::Contacts;
use super::parse::not_negative;
use super::{Failure, bad_input, hints, not_both_from_standard_input, validity};
use finray_files::displacements::{self, Displacements, Reading};
use finray_files::{csv_text, load_network, load_scene, read_text, write_text};
use finray_model::scene::Base;
use finray_model::sensing::{Contact, ContactPosition, ContactQuestion, Estimate, Warning};
use finray_model::{Finger, Scene};
use finray_studies::estimators::network::Networks;
use finray_studies::estimators::{Answer, EstimatorId, Question};
use serde::Serialize;
use std::path::PathBuf;

/// Sense contact forces from measured displacements, with their uncertainty.
///
/// Reads node,ux_mm,uy_mm (nodes may be missing; of further columns x_mm,y_mm only serve to warn of
/// a file of another finger) and writes contact,s_mm,angle_deg,force_n,sigma_n, a row a contact. Where
/// the scene has its markers on hinges, hinge_ux_mm,hinge_uy_mm of `finray solve` are read instead.
/// Markers on clamped nodes are ignored; one that moved by more than noise explains is refused. The
/// direction of each force is an angle from the front plate's undeformed inward normal, positive
/// towards the tip; 0 if left out. Give a node twice with two angles to ask for two components.
///
/// sigma_n is one standard deviation: from the noise of --noise-mm, else of noise_mm in the scene's
/// camera table, else of a column sigma_mm as `finray locate` writes it, else of the residual, and
/// from the model's own error as far as it is known (linearisation, mesh, training). Where the
/// measurement contradicts the stated noise (chi-squared test), or the model errs by more than noise
/// does, a warning says so. sigma_n does not include errors that no measurement shows: a wrong
/// modulus scales every force alike.
///
/// The nonlinear estimator is co-rotational. It alone takes the directions `normal` (of the deformed
/// plate), `friction` (leaning from the normal, as the scene's table contact has it), `object` (the
/// same, from the outline of the scene's contact.object, which the plate touches there) and `auto`
/// (unknown), and the position `auto` (unknown); what is not identifiable is refused. Without a given
/// mesh it refines until doubling the mesh changes no force by more than 0.2 %. Where a file of
/// `finray locate` or the scene's table base says how well the base is known, it seeks the base too.
///
/// The network estimator answers in microseconds what it was trained for, and refuses the rest.
/// Networks for the paper's finger ship (contact nodes 14 to 24 alone, the pairs 19 20, 16 17, 18 20
/// and 16 20, any of 13 to 24); `finray train` makes those of other fingers and contacts, for
/// --network.
///
/// With --all-images a file of several images gives a row for each; an image that is refused says why.
///
/// Examples:
///   finray sense fixtures/scenes/paper.toml --displacements shape.csv --contact 19
///   finray sense fixtures/scenes/paper.toml --displacements shape.csv --contact 16@-20 --contact 20@10
///       --noise-mm 0.067
///   finray sense fixtures/scenes/paper.toml --displacements shape.csv --contact-at auto@normal
///   finray solve fixtures/scenes/paper.toml --kinematics linear --load 19:-0.38,-1.96 |
///       finray sense fixtures/scenes/paper.toml --displacements - --contact 19
///           --estimator least-squares
///   finray sense fixtures/scenes/paper.toml --displacements shape.csv --contact 19 20
///       --estimator network
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
    /// The estimator
    #[arg(long, value_enum, default_value_t = EstimatorId::Nonlinear)]
    estimator: EstimatorId,
    /// Network of `finray train`; without it, the one that ships for these contacts
    #[arg(long, value_name = "FILE")]
    network: Option<PathBuf>,
    /// Standard deviation of one measured coordinate, mm
    #[arg(long, value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Image whose rows are read, of a file of several
    #[arg(long, value_name = "NAME")]
    image_name: Option<String>,
    /// Sense in every image of a file of several: image,contact,s_mm,angle_deg,force_n,sigma_n,refused
    #[arg(long, conflicts_with = "image_name")]
    all_images: bool,
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

/// A row of an image: numbers, or why there are none.
#[derive(Serialize)]
struct ImageRow {
    image: String,
    contact: Option<String>,
    s_mm: Option<f64>,
    angle_deg: Option<f64>,
    force_n: Option<f64>,
    sigma_n: Option<f64>,
    refused: String,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    not_both_from_standard_input(&arguments.scene, &arguments.displacements, "--displacements")?;
    let scene = load_scene(&arguments.scene)?;
    let finger = &scene.finger;
    hints::of_moduli(&arguments.scene, finger);
    let networks = match &arguments.network {
        Some(_) if arguments.estimator != EstimatorId::Network => {
            return Err(bad_input("--network is for --estimator network"));
        }
        Some(path) => Networks::of(vec![load_network(path)?]),
        None => Networks::shipped()?,
    };
    let contacts = &arguments.contacts.with(scene.contact.lean, scene.touched.as_ref())?;
    arguments.estimator.admits(finger, contacts, &networks)?;
    let reading = Reading {
        from_positions: false,
        errors: scene.marker_errors,
        base: scene.base.as_ref().and_then(|base| base.uncertainty),
        base_is_sought: arguments.estimator == EstimatorId::Nonlinear,
        base_is_of_pose: scene.base.as_ref().is_some_and(Base::is_of_pose),
        noise_mm: arguments.noise_mm.or(scene.noise_mm),
    };
    let task = Task { arguments, scene: &scene, contacts, networks: &networks, reading };
    let text = read_text(&arguments.displacements)?;
    if arguments.all_images {
        write_text(&arguments.out, &csv_text(task.all_images(&text)?)?)?;
    } else {
        let found = task.displacements(&text, arguments.image_name.as_deref())?;
        let (contacts, estimate) = task.sensed(found, "")?;
        write_text(&arguments.out, &csv_text(rows(finger, &contacts, &estimate))?)?;
        validity::warn_of_forces(&scene, &contacts, &estimate.forces_n);
    }
    hints::of_displacements(&arguments.displacements, &text, finger);
    Ok(())
}

/// A question that is asked of one image or of several.
struct Task<'t> {
    arguments: &'t Arguments,
    scene: &'t Scene,
    contacts: &'t [ContactQuestion],
    networks: &'t Networks,
    reading: Reading,
}

impl Task<'_> {
    /// A row a contact of each image. An image that is refused has rows without numbers that say why.
    fn all_images(&self, text: &str) -> Result<Vec<ImageRow>, Failure> {
        let mut all = Vec::new();
        for image in displacements::images(&self.arguments.displacements, text)? {
            let of = |row: Option<Row>, refused: &str| {
                let numbers = row.as_ref();
                ImageRow {
                    image: image.clone(),
                    contact: numbers.map(|row| row.contact.clone()),
                    s_mm: numbers.map(|row| row.s_mm),
                    angle_deg: numbers.map(|row| row.angle_deg),
                    force_n: numbers.map(|row| row.force_n),
                    sigma_n: numbers.map(|row| row.sigma_n),
                    refused: refused.to_owned(),
                }
            };
            // What is wrong with the file is an error; an image without an answer is one of its rows.
            let found = self.displacements(text, Some(&image))?;
            match self.sensed(found, &format!("{image}: ")) {
                Ok((contacts, estimate)) => {
                    all.extend(rows(&self.scene.finger, &contacts, &estimate).into_iter().map(|row| of(Some(row), "")));
                }
                Err(Failure::BadInput(reason) | Failure::NotComputed(reason)) => {
                    all.extend(self.contacts.iter().map(|_| of(None, &reason)));
                }
            }
        }
        Ok(all)
    }

    fn displacements(&self, text: &str, image: Option<&str>) -> Result<Displacements, Failure> {
        let path = &self.arguments.displacements;
        Ok(displacements::of_text(path, text, &self.scene.finger, image, self.reading)?)
    }

    /// Forces of one image; warnings begin with `about`.
    fn sensed(&self, found: Displacements, about: &str) -> Result<Answer, Failure> {
        let Task { arguments, scene, contacts, networks, .. } = *self;
        let finger = &scene.finger;
        // A stated noise holds for all nodes alike, and networks are trained on nodes that are measured alike.
        let noise_mm = arguments.noise_mm.or(scene.noise_mm).map(|noise_mm| scene.marker_errors.sd_mm(noise_mm));
        let object = scene.touched.as_ref().and_then(|touched| touched.seen_from(&found.frame));
        let is_alike = noise_mm.is_some() || arguments.estimator == EstimatorId::Network;
        let noise_mm = noise_mm.or(found.noise_mm);
        let measurement = if is_alike { found.of_equal_weight() } else { found.measurement };
        let question = Question {
            contacts,
            pad: scene.contact.pad,
            object: object.as_ref(),
            measurement: &measurement,
            noise_mm,
            mesh_nodes: arguments.mesh_nodes,
            networks,
        };
        let (contacts, mut estimate) = arguments.estimator.answer(finger, &question)?;
        estimate.add_force_error(scene.contact.force_error);
        if let Some(i) = estimate.forces_n.iter().position(|force| !force.is_finite()) {
            return Err(bad_input(format!(
                "not identifiable: a force at contact {} hardly moves the measured nodes, or the displacements are not \
             those of a finger in mm",
                i + 1
            )));
        }
        if let Some(warning) = estimate.warning {
            eprintln!("warning: {about}{warning}; {}", advice(arguments.estimator, &warning));
        }
        if estimate.noise_mm.is_infinite() {
            eprintln!(
                "note: {about}as many unknowns as measured coordinates leave no residual to estimate the noise from; give \
             --noise-mm for a finite sigma_n"
            );
        }
        Ok((contacts, estimate))
    }
}

/// Advice for a warning.
fn advice(estimator: EstimatorId, warning: &Warning) -> &'static str {
    match warning {
        _ if estimator.is_linear() => {
            "sigma_n holds the error of linearisation; --estimator nonlinear does without linearisation, where it answers"
        }
        Warning::Residual(_) => {
            "sigma_n rests on the residual and does not hold what a wrong model does; check the contacts, their directions, the \
             finger's dimensions and the noise"
        }
        _ => "sigma_n holds that error",
    }
}

fn rows(finger: &Finger, contacts: &[Contact], estimate: &Estimate) -> Vec<Row> {
    let forces = estimate.forces_n.iter().zip(&estimate.sigmas_n);
    contacts
        .iter()
        .zip(forces)
        .map(|(contact, (&force_n, &sigma_n))| Row {
            contact: match contact.position {
                ContactPosition::Node(node) => node.to_string(),
                ContactPosition::At(_) => "at".to_owned(),
            },
            // Contacts were checked: each has a position on the front plate.
            s_mm: contact.position_mm(finger).unwrap_or(f64::NAN),
            angle_deg: contact.angle_deg,
            force_n,
            sigma_n,
        })
        .collect()
}
