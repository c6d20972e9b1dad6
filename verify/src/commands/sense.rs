//! `finray sense`

use super::contacts::Contacts;
use crate::commands::prelude::*;
use finray_files::observations::{Coordinates, ObservationTable};
use finray_files::views::{self, MeasuredForce};
use finray_files::{load_network, read_text};
use finray_model::observation::Observation;
use finray_model::sensing::ContactPosition;
use finray_model::sensor::{MissingInScene, Refusal, SensedForces, Sensor, SensorOptions, SensorWarning};

/// Sense contact forces from measured displacements, with their uncertainty.
///
/// Reads node,ux_mm,uy_mm (nodes may be missing or their cells empty; of further columns x_mm,y_mm
/// only serve to warn of a file of another finger) and writes contact,s_mm,angle_deg,force_n,sigma_n,
/// a row a contact. Where the scene has its markers on hinges, hinge_ux_mm,hinge_uy_mm of `finray
/// solve` are read instead. Markers on clamped nodes are ignored; one that moved by more than noise
/// explains is refused. The direction of each force is an angle from the front plate's undeformed
/// inward normal, positive towards the tip; 0 if left out. Give a node twice with two angles to ask
/// for two components.
/// A contact that was measured has standard deviations, as 80+-0.5@-20+-3 (mm, degrees): its force
/// then lies anywhere in the cone of --friction about the direction, as `press` and `grasp` sense it.
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
/// same, from the outline of the scene's contact.object, which the plate touches there), `measured`
/// (of the force that --forces has of the image) and `auto` (unknown), and the position `auto`
/// (unknown); what is not identifiable is refused. Without a given mesh it refines until doubling the
/// mesh changes no force by more than 0.2 %. Where a file of `finray locate` or the scene's table base
/// says how well the base is known, it seeks the base too.
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
///   finray sense calibrated.toml --displacements located.csv --all-images --contact-at auto@measured
///       --forces forces.csv
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
    #[arg(long, value_parser = listed::<EstimatorId>(), default_value_t = EstimatorId::Nonlinear)]
    estimator: EstimatorId,
    /// Network of `finray train`; without it, the one that ships for these contacts
    #[arg(long, value_name = "FILE")]
    network: Option<PathBuf>,
    /// Standard deviation of one measured coordinate, mm
    #[arg(long, value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Largest coefficient of friction, where contacts are given with standard deviations
    #[arg(long, value_name = "MU", value_parser = not_negative, default_value_t = 0.0)]
    friction: f64,
    /// Image whose rows are read, of a file of several, by its name there or more of its path
    #[arg(long, value_name = "NAME")]
    image_name: Option<String>,
    /// Sense in every image of a file of several: image,contact,s_mm,angle_deg,force_n,sigma_n,refused
    #[arg(long, conflicts_with = "image_name")]
    all_images: bool,
    /// Contact forces that were measured in the images: image,fx_n,fy_n in the frame of the camera's pose (CSV), for the direction `measured`
    #[arg(long, value_name = "FILE")]
    forces: Option<PathBuf>,
    /// Nodes of the nonlinear estimator's mesh
    #[arg(long, value_name = "N")]
    mesh_nodes: Option<usize>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

/// A sensed force; empty in an image that is refused.
#[derive(Serialize, Default)]
struct Row {
    contact: Option<String>,
    s_mm: Option<f64>,
    angle_deg: Option<f64>,
    force_n: Option<f64>,
    sigma_n: Option<f64>,
}

/// Begins a row of an image.
#[derive(Serialize)]
struct OfImage<'t> {
    image: &'t str,
}

/// Ends a row of an image: why there are no numbers, if there are none.
#[derive(Serialize)]
struct Refused {
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
        None => Networks::read(&finray_fixtures::NETWORKS)?,
    };
    let options = SensorOptions {
        estimator: arguments.estimator,
        networks: &networks,
        noise_mm: arguments.noise_mm,
        mesh_nodes: arguments.mesh_nodes,
    };
    let mut question = ImageQuestion {
        scene: &scene,
        contacts: &arguments.contacts,
        friction: arguments.friction,
        forces: None,
        options,
    };
    match (&arguments.forces, arguments.contacts.ask_measured()) {
        (Some(_), true) if arguments.contacts.count() > 1 => {
            return Err(bad_input("a direction is `measured`: expected one contact, whose force --forces has"));
        }
        (Some(forces), true) => {
            not_both_from_standard_input(&arguments.scene, forces, "--forces")?;
            not_both_from_standard_input(&arguments.displacements, forces, "--forces")?;
        }
        (Some(_), false) => return Err(bad_input("--forces is for the direction `measured`, as in auto@measured")),
        // Contacts that are wrong are so in any image.
        (None, _) => drop(question.sensor(&Observation::default())?),
    }
    let text = read_text(&arguments.displacements)?;
    let table = ObservationTable::new(&arguments.displacements, &text, finger, Coordinates::Displacements)?;
    question.forces = arguments.forces.as_ref().map(|path| views::forces(path, &table.images()?)).transpose()?;
    if arguments.all_images {
        write_text(&arguments.out, &csv_text(all_images(&question, &table)?)?)?;
    } else {
        let seen = table.observation(arguments.image_name.as_deref())?;
        let sensor = question.sensor(&seen)?;
        let sensed = sensed(&sensor, &seen, &table)?;
        warn("", &sensed.warnings);
        write_text(&arguments.out, &csv_text(rows(finger, &sensed))?)?;
        validity::warn_of_forces(&sensor, &sensed);
    }
    hints::of_displacements(&arguments.displacements, &text, finger);
    Ok(())
}

/// What is asked of each image.
struct ImageQuestion<'a> {
    scene: &'a Scene,
    contacts: &'a Contacts,
    friction: f64,
    /// Measured forces, where a direction is one of them.
    forces: Option<Vec<MeasuredForce>>,
    options: SensorOptions<'a>,
}

impl<'a> ImageQuestion<'a> {
    fn force(&self, image: &str) -> Option<&MeasuredForce> {
        self.forces.iter().flatten().find(|measured| measured.image == image)
    }

    /// The sensor of an image; a measured force is turned into the frame of the image's base.
    fn sensor(&self, seen: &Observation) -> Result<Sensor<'a>, Failure> {
        let in_base = |measured: &MeasuredForce| seen.frame(self.scene).rotation.inverse() * measured.force;
        let measured_deg = self.force(&seen.image).map(|measured| self.scene.finger.angle_deg(in_base(measured)));
        let contacts = self.contacts.of(self.scene, self.friction, measured_deg)?;
        Ok(Sensor::new(self.scene, contacts, self.options)?)
    }
}

/// A row a contact of each image. An image that is refused has rows without numbers that say why.
fn all_images<'t>(
    question: &ImageQuestion,
    table: &'t ObservationTable,
) -> Result<Vec<(OfImage<'t>, Row, Refused)>, Failure> {
    let finger = &question.scene.finger;
    let mut all = Vec::new();
    for image in table.images()? {
        let row = |row: Row, refused: String| (OfImage { image }, row, Refused { refused });
        let refused = |reason: &str| -> Vec<_> {
            (0..question.contacts.count()).map(|_| row(Row::default(), reason.to_owned())).collect()
        };
        if let Some(reason) = table.refused(image) {
            all.extend(refused(reason));
            continue;
        }
        if question.forces.is_some() && question.force(image).is_none() {
            all.extend(refused(&MissingInScene::Measured.to_string()));
            continue;
        }
        let seen = table.observation(Some(image))?;
        match question.sensor(&seen)?.sense(&seen) {
            Ok(sensed) => {
                warn(&format!("{image}: "), &sensed.warnings);
                all.extend(rows(finger, &sensed).into_iter().map(|numbers| row(numbers, String::new())));
            }
            // An error in the file ends the command; an image without an answer is one of its rows.
            Err(Refusal::Observation(error)) => return Err(table.error(Some(image), &error).into()),
            Err(refusal) => all.extend(refused(&refusal.to_string())),
        }
    }
    Ok(all)
}

/// Forces of one image.
fn sensed(sensor: &Sensor, seen: &Observation, table: &ObservationTable) -> Result<SensedForces, Failure> {
    let image = Some(seen.image.as_str()).filter(|image| !image.is_empty());
    sensor.sense(seen).map_err(|refusal| match refusal {
        Refusal::Observation(error) => table.error(image, &error).into(),
        refusal => refusal.into(),
    })
}

/// Prints warnings; `about` begins each.
fn warn(about: &str, warnings: &[SensorWarning]) {
    for warning in warnings {
        let kind = if *warning == SensorWarning::NoResidual { "note" } else { "warning" };
        print_message(format_args!("{kind}: {about}{warning}"));
    }
}

fn rows(finger: &Finger, sensed: &SensedForces) -> Vec<Row> {
    let forces = sensed.forces_n.iter().zip(&sensed.sigmas_n);
    sensed
        .contacts
        .iter()
        .zip(forces)
        .map(|(contact, (&force_n, &sigma_n))| Row {
            contact: Some(match contact.position {
                ContactPosition::Node(node) => node.to_string(),
                ContactPosition::At(_) => "at".to_owned(),
            }),
            s_mm: contact.position_mm(finger),
            angle_deg: Some(contact.angle_deg),
            force_n: Some(force_n),
            sigma_n: Some(sigma_n),
        })
        .collect()
}
