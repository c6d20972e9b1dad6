//! `finray calibrate --located` and `--image`: calibrates a finger and its rig from images.

use super::{Arguments, Row, correlations, failure, notes, weights};
use crate::commands::locate::Images;
use crate::commands::prelude::*;
use finray_files::views::LocatedViews;
use finray_files::{load_scene_and_text, views, with_values};
use finray_model::calibration::{
    self, BaseCompliance, FoundView, FrictionEstimate, FrictionQuestion, LocatedView, NextForce, Quantity, RigEstimate,
    RigQuestion, Sought, ViewEstimate,
};
use finray_model::finger::{Joints, Plate, RibPositions};
use finray_model::scene::SceneWarning;
use finray_model::sensing::{Lean, Normal};

/// The parameters that a name of `--fit` stands for.
#[derive(Clone, Copy)]
enum Named {
    Quantities(fn(&Finger) -> Vec<Quantity>),
    Friction { builds_up: bool },
    BaseCompliance,
    ForceError,
}

/// Each name of `--fit`, its default standard deviation in the unit of the parameter (`None` if there is no default), and the parameters that it
/// stands for. The standard deviation is that of the parameter's prior; only for friction and the force error, it is the scatter between objects.
const NAMES: [(&str, Option<f64>, Named); 16] = [
    ("modulus", None, Named::Quantities(|_| vec![Quantity::Modulus])),
    ("front-modulus", None, Named::Quantities(|_| vec![Quantity::PlateModulus(Plate::Front)])),
    ("back-modulus", None, Named::Quantities(|_| vec![Quantity::PlateModulus(Plate::Back)])),
    ("bracket", None, Named::Quantities(|_| [Plate::Front, Plate::Back].map(Quantity::Bracket).to_vec())),
    ("brackets", Some(0.2), Named::Quantities(|finger| of_ribs(finger, Quantity::OwnBracket))),
    ("clip", Some(1.0), Named::Quantities(|_| vec![Quantity::Clip])),
    ("front-clip", Some(1.0), Named::Quantities(|_| vec![Quantity::PlateClip(Plate::Front)])),
    ("back-clip", Some(1.0), Named::Quantities(|_| vec![Quantity::PlateClip(Plate::Back)])),
    ("ribs", Some(0.2), Named::Quantities(|finger| of_ribs(finger, Quantity::RibPosition))),
    ("height", None, Named::Quantities(|_| vec![Quantity::MarkerHeight])),
    ("base", None, Named::Quantities(|_| vec![Quantity::BaseX, Quantity::BaseY, Quantity::BaseTurn])),
    ("preload", None, Named::Quantities(|_| vec![Quantity::Preload])),
    ("force-error", Some(0.01), Named::ForceError),
    ("base-compliance", None, Named::BaseCompliance),
    ("friction", None, Named::Friction { builds_up: false }),
    ("friction-build-up", None, Named::Friction { builds_up: true }),
];

/// One quantity per end of each rib.
fn of_ribs(finger: &Finger, quantity: fn(Plate, usize) -> Quantity) -> Vec<Quantity> {
    let on = |plate| (0..finger.rib_count()).map(move |rib| quantity(plate, rib));
    on(Plate::Front).chain(on(Plate::Back)).collect()
}

fn seeks(question: &RigQuestion, wanted: impl Fn(&Quantity) -> bool) -> bool {
    question.sought.iter().any(|sought| wanted(&sought.quantity))
}

/// Parses the value of `--fit`.
fn parse(text: &str, scene: &Scene) -> Result<RigQuestion, Failure> {
    let bad = |reason: String| bad_input(format!("--fit: {reason}"));
    let mut fit = RigQuestion::default();
    for part in text.split(',').map(str::trim) {
        let (name, prior) = part.split_once('=').map_or((part, None), |(name, prior)| (name, Some(prior)));
        let Some((_, own_prior, named)) = NAMES.iter().find(|(known, ..)| *known == name) else {
            let known = NAMES.map(|(known, ..)| known).join(", ");
            return Err(bad(format!("expected names of {known}, found \"{name}\"")));
        };
        let prior_sd = match prior {
            None => *own_prior,
            Some(text) => Some(positive(text).map_err(|reason| bad(format!("{name}: {reason}")))?),
        };
        match named {
            Named::Friction { builds_up } => {
                if fit.friction.is_some() {
                    return Err(bad("expected one of friction and friction-build-up, found both".to_owned()));
                }
                let between_objects = prior_sd.unwrap_or_default();
                fit.friction = Some(FrictionQuestion { builds_up: *builds_up, between_objects });
            }
            Named::ForceError => fit.force_error_between_objects = prior_sd.unwrap_or_default(),
            Named::BaseCompliance if prior_sd.is_some() => {
                return Err(bad("base-compliance: expected no prior, found one".to_owned()));
            }
            Named::BaseCompliance => fit.base_compliance = true,
            Named::Quantities(of) => {
                for quantity in of(&scene.finger) {
                    if seeks(&fit, |known| *known == quantity) {
                        return Err(bad(format!("{quantity} is named twice")));
                    }
                    fit.sought.push(Sought { quantity, prior_sd });
                }
            }
        }
    }
    check(&fit, scene).map_err(bad)?;
    Ok(fit)
}

/// Checks that the scene has the tables and keys of the parameters to be estimated.
fn check(fit: &RigQuestion, scene: &Scene) -> Result<(), String> {
    let ribs = &scene.finger.description().ribs;
    if seeks(fit, |quantity| matches!(quantity, Quantity::Bracket(_) | Quantity::OwnBracket(..)))
        && !scene.finger.has_brackets()
    {
        return Err("bracket: expected bracket_mm in the scene's table finger.ribs".to_owned());
    }
    if seeks(fit, |quantity| matches!(quantity, Quantity::RibPosition(..)))
        && matches!(ribs.positions, RibPositions::Count(_))
    {
        return Err("ribs: expected positions_mm in the scene's table finger.ribs".to_owned());
    }
    if seeks(fit, |quantity| matches!(quantity, Quantity::RibPosition(..))) && scene.finger.has_shared_junctions() {
        return Err(
            "ribs: expected positions in finger.ribs.positions_mm at which no two ribs share a junction".to_owned()
        );
    }
    let has_rig = scene.markers.is_some() && scene.camera.is_some_and(|camera| camera.pose.is_some());
    if seeks(fit, Quantity::is_of_rig) && !has_rig {
        return Err("height, base: expected markers and a camera with its pose in the scene".to_owned());
    }
    if seeks(fit, |quantity| *quantity == Quantity::Modulus)
        && seeks(fit, |quantity| matches!(quantity, Quantity::PlateModulus(_)))
    {
        return Err("expected either modulus, or front-modulus and back-modulus; found both".to_owned());
    }
    if seeks(fit, |quantity| *quantity == Quantity::Clip)
        && seeks(fit, |quantity| matches!(quantity, Quantity::PlateClip(_)))
    {
        return Err("expected either clip, or front-clip and back-clip; found both".to_owned());
    }
    Ok(())
}

#[derive(Serialize)]
struct ImageRow {
    image: String,
    s_mm: f64,
    force_n: f64,
    sigma_n: f64,
    angle_deg: f64,
    lean_deg: f64,
    base_x_mm: f64,
    base_y_mm: f64,
    base_deg: f64,
    residual_rms_mm: f64,
}

/// Standard deviations of a new mounting by hand, if `[assembly]` states none: of each joint and of the height, mm. The preload is that of a plate
/// that was bent to this radius, mm, before it was mounted: 10 N mm for the spring steel of the guide.
const REMOUNTED_JOINT_MM: f64 = 0.2;
const REMOUNTED_HEIGHT_MM: f64 = 2.0;
const REMOUNTED_RADIUS_MM: f64 = 400.0;

/// A measurement of one more force is recommended if it leaves at most this share of the standard deviation of the other forces.
const WORTH_IT: f64 = 0.7;

/// Parameters that are estimated without `--fit`.
const BY_DEFAULT: &str = "modulus";

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let Arguments { located, forces, image, rest, .. } = arguments;
    require_one_standard_input([&arguments.scene].into_iter().chain(located).chain(forces).chain(image).chain(rest))?;
    let (scene, text) = load_scene_and_text(&arguments.scene)?;
    let remounted = arguments.remounted.then(|| of_mounting(&scene)).transpose()?;
    let fit = parse(arguments.fit.as_deref().or(remounted.as_deref()).unwrap_or(BY_DEFAULT), &scene)?;
    // A calibrated modulus replaces its uncertainty and absorbs the state of the side faces.
    let absorbed = seeks(&fit, Quantity::is_modulus);
    let is_absorbed = |warning: &SceneWarning| absorbed && warning.is_of_stiffness();
    hints::of_scene_without(&arguments.scene, &scene, is_absorbed);
    let seen = match located {
        None if arguments.weight.is_empty() => pressed(arguments, &scene)?,
        None => weights::views(arguments, &scene)?,
        Some(located) => {
            let LocatedViews { views, refused, .. } = views::load(located, forces.as_deref(), &scene)?;
            hints::of_refused(&refused);
            views
        }
    };
    let measured = seen.iter().filter(|seen| seen.view.force.is_some()).count();
    if measured == 0 && (fit.friction.is_some() || fit.base_compliance || seeks(&fit, Quantity::is_modulus)) {
        return Err(bad_input(
            "moduli, friction and the compliance of the base are not identifiable without measured forces (--forces)",
        ));
    }
    let lean = match scene.contact.lean {
        Some(lean) => lean,
        None if measured == seen.len() => Lean { from: scene.contact.normal, ..Lean::NONE },
        None => {
            return Err(bad_input(
                "images without a measured force: expected friction or friction_range in the scene's table [contact]",
            ));
        }
    };
    let found = calibration::calibrate_rig(&scene, &seen, &fit, lean).map_err(failure)?;
    let RigEstimate { views: estimate, compliance, .. } = &found;
    notes::print(&found, remounted.as_deref());
    if arguments.fit.is_none() && !arguments.remounted {
        print_message(format_args!(
            "note: only {BY_DEFAULT} is estimated; thicknesses, ribs, base and height of the markers keep the scene's values (--fit)"
        ));
    }
    if measured == 0 && arguments.calibrated.is_some() {
        print_message(
            "warning: no force was measured: forces sensed with this calibration share a large error; one measured force (--forces) removes most of \
             this error",
        );
    }
    if let Some(NextForce { view, now, then }) = estimate.next_force.filter(|next| next.then < WORTH_IT * next.now) {
        print_message(format_args!(
            "note: to measure one more force, choose {}: the forces that were not measured would be uncertain by {:.1} instead of {:.1} % (rms)",
            seen[view].view.name,
            100.0 * then,
            100.0 * now
        ));
    }
    if !arguments.weight.is_empty() {
        weights::warn_of_strings(&scene, &seen);
    }
    for outlier in &estimate.outliers {
        print_message(format_args!("warning: {outlier}"));
    }
    if compliance.is_some_and(|compliance| compliance.sigma_deg_per_n.is_infinite()) {
        print_message(format_args!(
            "note: two images do not determine the standard deviation of base_deg_per_n, so `finray sense` treats base_deg_per_n as exact"
        ));
    }
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    if let Some(path) = &arguments.correlations {
        let names: Vec<String> = estimate.quantities.iter().map(|found| found.sought.quantity.to_string()).collect();
        files.push((path.clone(), csv_text(correlations(&names, &estimate.correlation))?));
    }
    if let Some(path) = &arguments.images {
        files.push((path.clone(), csv_text(image_rows(&seen, estimate, lean.from))?));
    }
    if let Some(path) = &arguments.calibrated {
        files.push((path.clone(), with_values(&text, &found.scene_values(&scene)).map_err(bad_input)?));
    }
    files.push((arguments.out.clone(), csv_text(rows(&found))?));
    write_all_or_nothing(&files)?;
    let (images, forces) = (count(seen.len(), "image"), count(measured, "measured force"));
    let done = format!("{} estimated from {images} and {forces}", count(rows(&found).len(), "parameter"));
    Ok(summary(done, files.iter().map(|(path, _)| path)))
}

/// Locates the finger in the images with the scene that is calibrated, and adds the measured forces.
fn pressed(arguments: &Arguments, scene: &Scene) -> Result<Vec<LocatedView>, Failure> {
    let Arguments { image, rest, forces, .. } = arguments;
    let located = Images { scene: &arguments.scene, images: image, rest: rest.as_deref() }.located(scene)?;
    let names: Vec<&str> = located
        .iter()
        .map(|seen| seen.as_ref().map_or_else(|refused| refused.image.as_str(), |seen| seen.image.as_str()))
        .collect();
    let forces = forces.as_deref().map(|path| views::forces(path, &names)).transpose()?.unwrap_or_default();
    let view = |seen| views::view_with_force(seen, scene, &forces).map_err(bad_input);
    located.into_iter().flatten().map(view).collect()
}

/// What `--fit` names for a finger that was mounted again: whatever the scene states of the mounting. Standard deviations are those of `[assembly]`,
/// by default those that the guide states for a finger mounted by hand.
///
/// # Errors
/// [`Failure`] if the scene states nothing that a new mounting changes.
fn of_mounting(scene: &Scene) -> Result<String, Failure> {
    let ribs = &scene.finger.description().ribs;
    let assembly = scene.assembly.clone().unwrap_or_default();
    let stated = |sd: f64, default: f64| if sd > 0.0 { sd } else { default };
    let joint_mm = stated(assembly.joint_sd_mm, REMOUNTED_JOINT_MM);
    let height_mm = stated(assembly.height_sd_mm, REMOUNTED_HEIGHT_MM);
    let has_rig = scene.markers.is_some() && scene.camera.is_some_and(|camera| camera.pose.is_some());
    let [depth_mm, thickness_mm] = [scene.finger.description().depth_mm, scene.finger.description().front.thickness_mm];
    let stiffness_nmm2 = scene.finger.description().front.youngs_modulus_mpa * depth_mm * thickness_mm.powi(3) / 12.0;
    let preload_nmm = stated(assembly.preload_sd_nmm, stiffness_nmm2 / REMOUNTED_RADIUS_MM);
    // A finger of one piece keeps its joints. Its preload is that of printing, which a mounting does not change.
    let is_assembled = ribs.joints == Joints::Hinged;
    let moves_along = matches!(ribs.positions, RibPositions::Positions(_)) && !scene.finger.has_shared_junctions();
    let names = [
        (has_rig, "base".to_owned()),
        (has_rig, format!("height={height_mm}")),
        (is_assembled, format!("preload={preload_nmm:.3}")),
        (is_assembled && scene.finger.has_brackets(), format!("brackets={joint_mm}")),
        (is_assembled && moves_along, format!("ribs={joint_mm}")),
    ];
    let names: Vec<String> = names.into_iter().filter(|(is_stated, _)| *is_stated).map(|(_, name)| name).collect();
    match names.is_empty() {
        true => Err(bad_input(
            "--remounted: expected a scene with markers and a camera with its pose, or with hinged ribs; found nothing that a new mounting changes",
        )),
        false => Ok(names.join(",")),
    }
}

/// One row per estimated parameter. The rows of the error parameters, and of the force over which friction builds up, have no standard deviation.
fn rows(found: &RigEstimate) -> Vec<Row> {
    let &RigEstimate { views: ref estimate, ref friction, compliance, force_error, .. } = found;
    let row = |parameter: &str, value, sigma| Row { parameter: parameter.to_owned(), value, sigma };
    let quantities = estimate.quantities.iter();
    let mut rows: Vec<Row> =
        quantities.map(|found| row(&found.sought.quantity.to_string(), found.value, Some(found.sigma))).collect();
    if let Some(BaseCompliance { deg_per_n, sigma_deg_per_n }) = compliance {
        rows.push(row("base_deg_per_n", deg_per_n, Some(sigma_deg_per_n).filter(|sigma| sigma.is_finite())));
    }
    if let Some(FrictionEstimate { lean, between_objects, .. }) = friction {
        let [coefficient, sigma] = lean.coefficient();
        rows.push(row("friction", coefficient, Some(sigma)));
        if lean.build_up_n > 0.0 {
            rows.push(row("friction_build_up_n", lean.build_up_n, None));
        }
        rows.extend(between_objects.map(|sd| row("friction_between_objects", sd, None)));
    }
    rows.push(row("noise_factor", estimate.new_marker_errors.noise_factor, None));
    rows.push(row("model_error_mm", estimate.new_marker_errors.calibration_error_mm, None));
    rows.extend(force_error.map(|share| row("force_error_share", share, None)));
    rows
}

fn image_rows(seen: &[LocatedView], estimate: &ViewEstimate, from: Normal) -> Vec<ImageRow> {
    let row = |(seen, found): (&LocatedView, &FoundView)| ImageRow {
        image: seen.view.name.clone(),
        s_mm: found.s_mm,
        force_n: found.force.norm(),
        sigma_n: found.force_sigma_n,
        angle_deg: found.lean_deg(&estimate.finger, Normal::Undeformed),
        lean_deg: found.lean_deg(&estimate.finger, from),
        base_x_mm: found.base.translation.x,
        base_y_mm: found.base.translation.y,
        base_deg: found.base.rotation.angle().to_degrees(),
        residual_rms_mm: found.residual_rms_mm(),
    };
    seen.iter().zip(&estimate.views).map(row).collect()
}
