//! `finray calibrate --located`: a finger and its rig from several images.

use super::{Arguments, Row, correlations, failure};
use crate::commands::parse::positive;
use crate::commands::{Failure, bad_input, not_both_from_standard_input};
use finray_model::calibration::{self, BaseCompliance, FoundView, Quantity, Sought, ViewEstimate, ViewModel};
use finray_model::finger::{BracketLengths, Plate, RibPositions};
use finray_model::keys::{BACK, BASE, CAMERA, CONTACT, FRONT, MARKERS, REFERENCE, RIBS};
use finray_model::sensing::{Lean, Normal};
use finray_model::{Finger, Scene, Vector};
use finray_verify::estimators::ELEMENTS;
use finray_verify::files::views::{self, LocatedView};
use finray_verify::files::{csv_text, load_scene_and_text, with_values, write_all_or_nothing};
use nalgebra::Point2;
use serde::Serialize;
use std::path::{Path, PathBuf};
use toml_edit::{Array, Value};

/// A camera so high that nothing depends on the height of markers.
const NO_CAMERA_MM: f64 = 1e12;
/// A prior that the images do not make better than this share of itself is all that is known.
const HARDLY_BETTER: f64 = 0.8;

/// What a name of `--fit` stands for.
#[derive(Clone, Copy)]
enum Named {
    Quantities(fn(&Finger) -> Vec<Quantity>),
    Friction { builds_up: bool },
    BaseCompliance,
}

/// A name, the prior that it has where none is given (standard deviation), and what it stands for.
const NAMES: [(&str, Option<f64>, Named); 14] = [
    ("modulus", None, Named::Quantities(|_| vec![Quantity::Modulus])),
    ("front-modulus", None, Named::Quantities(|_| vec![Quantity::PlateModulus(Plate::Front)])),
    ("back-modulus", None, Named::Quantities(|_| vec![Quantity::PlateModulus(Plate::Back)])),
    ("bracket", None, Named::Quantities(|_| [Plate::Front, Plate::Back].map(Quantity::Bracket).to_vec())),
    ("brackets", Some(0.2), Named::Quantities(own_brackets)),
    ("clip", Some(1.0), Named::Quantities(|_| vec![Quantity::Clip])),
    ("front-clip", Some(1.0), Named::Quantities(|_| vec![Quantity::PlateClip(Plate::Front)])),
    ("back-clip", Some(1.0), Named::Quantities(|_| vec![Quantity::PlateClip(Plate::Back)])),
    ("ribs", Some(0.2), Named::Quantities(ribs)),
    ("height", None, Named::Quantities(|_| vec![Quantity::MarkerHeight])),
    ("base", None, Named::Quantities(|_| vec![Quantity::BaseX, Quantity::BaseY, Quantity::BaseTurn])),
    ("base-compliance", None, Named::BaseCompliance),
    ("friction", None, Named::Friction { builds_up: false }),
    ("friction-build-up", None, Named::Friction { builds_up: true }),
];

fn ribs(finger: &Finger) -> Vec<Quantity> {
    let on = |plate| (0..finger.rib_count()).map(move |rib| Quantity::RibPosition(plate, rib));
    on(Plate::Front).chain(on(Plate::Back)).collect()
}

fn own_brackets(finger: &Finger) -> Vec<Quantity> {
    let on = |plate| (0..finger.rib_count()).map(move |rib| Quantity::OwnBracket(plate, rib));
    on(Plate::Front).chain(on(Plate::Back)).collect()
}

fn is_modulus(quantity: &Quantity) -> bool {
    matches!(quantity, Quantity::Modulus | Quantity::PlateModulus(_))
}

fn is_of_rig(quantity: &Quantity) -> bool {
    matches!(quantity, Quantity::MarkerHeight | Quantity::BaseX | Quantity::BaseY | Quantity::BaseTurn)
}

/// What is to be found.
struct Fit {
    sought: Vec<Sought>,
    friction: Option<FrictionFit>,
    /// Whether the turn of the base with the force is to be found.
    base_compliance: bool,
}

/// How friction is to be found.
#[derive(Clone, Copy, Default)]
struct FrictionFit {
    builds_up: bool,
    /// Standard deviation of the coefficient from object to object, which images of one do not show.
    between_objects: f64,
}

impl Fit {
    fn seeks(&self, wanted: impl Fn(&Quantity) -> bool) -> bool {
        self.sought.iter().any(|sought| wanted(&sought.quantity))
    }

    fn parse(text: &str, scene: &Scene) -> Result<Fit, Failure> {
        let bad = |reason: String| bad_input(format!("--fit: {reason}"));
        let mut fit = Fit { sought: Vec::new(), friction: None, base_compliance: false };
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
                        return Err(bad("friction is named twice".to_owned()));
                    }
                    let between_objects = prior_sd.unwrap_or_default();
                    fit.friction = Some(FrictionFit { builds_up: *builds_up, between_objects });
                }
                Named::BaseCompliance if prior_sd.is_some() => {
                    return Err(bad("base-compliance takes no standard deviation".to_owned()));
                }
                Named::BaseCompliance => fit.base_compliance = true,
                Named::Quantities(of) => {
                    for quantity in of(&scene.finger) {
                        if fit.seeks(|known| *known == quantity) {
                            return Err(bad(format!("{quantity} is named twice")));
                        }
                        fit.sought.push(Sought { quantity, prior_sd });
                    }
                }
            }
        }
        fit.check(scene).map_err(bad)?;
        Ok(fit)
    }

    /// Whether the scene has what is sought.
    fn check(&self, scene: &Scene) -> Result<(), String> {
        let ribs = &scene.finger.description().ribs;
        if self.seeks(|quantity| matches!(quantity, Quantity::Bracket(_) | Quantity::OwnBracket(..)))
            && !scene.finger.has_brackets()
        {
            return Err("bracket: expected bracket_mm in the scene's table finger.ribs".to_owned());
        }
        if self.seeks(|quantity| matches!(quantity, Quantity::RibPosition(..)))
            && matches!(ribs.positions, RibPositions::Count(_))
        {
            return Err("ribs: expected positions_mm in the scene's table finger.ribs".to_owned());
        }
        let has_rig = scene.markers.is_some() && scene.camera.is_some_and(|camera| camera.pose.is_some());
        if self.seeks(is_of_rig) && !has_rig {
            return Err("height, base: expected markers and a camera with its pose in the scene".to_owned());
        }
        if self.seeks(|quantity| *quantity == Quantity::Modulus)
            && self.seeks(|quantity| matches!(quantity, Quantity::PlateModulus(_)))
        {
            return Err("expected either modulus or those of the plates, found both".to_owned());
        }
        if self.seeks(|quantity| *quantity == Quantity::Clip)
            && self.seeks(|quantity| matches!(quantity, Quantity::PlateClip(_)))
        {
            return Err("expected either clip or those of the plates, found both".to_owned());
        }
        Ok(())
    }
}

#[derive(Serialize)]
struct ImageRow {
    image: String,
    s_mm: f64,
    force_n: f64,
    angle_deg: f64,
    lean_deg: f64,
    base_x_mm: f64,
    base_y_mm: f64,
    base_deg: f64,
    residual_rms_mm: f64,
}

pub fn run(arguments: &Arguments, located: &Path, fit: &str) -> Result<(), Failure> {
    not_both_from_standard_input(&arguments.scene, located, "--located")?;
    if let Some(forces) = &arguments.forces {
        not_both_from_standard_input(&arguments.scene, forces, "--forces")?;
        not_both_from_standard_input(located, forces, "--forces")?;
    }
    let (scene, text) = load_scene_and_text(&arguments.scene)?;
    let fit = Fit::parse(fit, &scene)?;
    let seen = views::load(located, arguments.forces.as_deref(), &scene)?.views;
    let measured = seen.iter().filter(|seen| seen.view.force.is_some()).count();
    if measured == 0 && (fit.friction.is_some() || fit.base_compliance || fit.seeks(is_modulus)) {
        return Err(bad_input(
            "moduli, friction and the compliance of the base are not identifiable without measured forces (--forces)",
        ));
    }
    let lean = match scene.contact.lean {
        Some(lean) => lean,
        None if measured == seen.len() => Lean::NONE,
        None => {
            return Err(bad_input(
                "images without a measured force: expected friction or friction_range in the scene's table contact",
            ));
        }
    };
    let model = ViewModel {
        elements: ELEMENTS,
        camera_height_mm: scene.camera.and_then(|camera| camera.pose).map_or(NO_CAMERA_MM, |pose| pose.eye().z),
        marker_height_mm: scene.markers.map_or(0.0, |markers| markers.height_mm),
        lean,
        pad: scene.contact.pad,
    };
    let all: Vec<_> = seen.iter().map(|seen| seen.view.clone()).collect();
    let estimate = calibration::views(&scene.finger, &all, &fit.sought, &model).map_err(failure)?;
    print_priors(&estimate);
    for outlier in &estimate.outliers {
        eprintln!("warning: {outlier}");
    }
    let leaning: Vec<(f64, f64)> = (all.iter().zip(&estimate.views))
        .filter(|(view, _)| view.force.is_some())
        .map(|(_, found)| (found.force.norm(), found.lean_deg(&estimate.finger, lean.from)))
        .collect();
    let friction = fit.friction.map(|friction| {
        let found = calibration::friction_of(&leaning, lean.from, friction.builds_up)?;
        // What the coefficient differs by from object to object, as an angle.
        let tangent = found.angle_deg.to_radians().tan();
        let between_deg = (friction.between_objects / (1.0 + tangent * tangent)).to_degrees();
        Ok(Lean { sd_deg: found.sd_deg.hypot(between_deg), ..found })
    });
    let friction = friction.transpose().map_err(failure)?;
    let turns: Vec<(f64, f64)> = (seen.iter().zip(&estimate.views))
        .filter(|(seen, _)| seen.view.force.is_some())
        .map(|(seen, found)| (found.force.norm(), (seen.base.rotation * found.base.rotation).angle().to_degrees()))
        .collect();
    let compliance = fit.base_compliance.then(|| calibration::compliance_of(&turns)).transpose().map_err(failure)?;
    if compliance.is_some_and(|compliance| compliance.sigma_deg_per_n.is_infinite()) {
        eprintln!(
            "note: base_deg_per_n: two images do not show its standard deviation, and `finray sense` takes it for exact"
        );
    }
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    if let Some(path) = &arguments.correlations {
        let names: Vec<String> = estimate.quantities.iter().map(|found| found.sought.quantity.to_string()).collect();
        files.push((path.clone(), csv_text(correlations(&names, &estimate.correlation))?));
    }
    if let Some(path) = &arguments.images {
        files.push((path.clone(), csv_text(image_rows(&seen, &estimate, lean.from))?));
    }
    if let Some(path) = &arguments.calibrated {
        let values = values(&scene, &estimate, friction.as_ref(), compliance);
        files.push((path.clone(), with_values(&text, &values).map_err(bad_input)?));
    }
    files.push((arguments.out.clone(), csv_text(rows(&estimate, friction.as_ref(), compliance))?));
    Ok(write_all_or_nothing(&files)?)
}

/// Says which values rest on a prior, and how far.
fn print_priors(estimate: &ViewEstimate) {
    for found in &estimate.quantities {
        let Some(prior_sd) = found.sought.prior_sd else { continue };
        let quantity = found.sought.quantity;
        match found.sigma > HARDLY_BETTER * prior_sd {
            true => {
                eprintln!("note: {quantity}: prior of {prior_sd} (standard deviation), which the images hardly better")
            }
            false => eprintln!("note: {quantity}: prior of {prior_sd} (standard deviation)"),
        }
    }
}

/// Coefficient of friction, and the standard deviation of single forces about it.
fn coefficient(lean: &Lean) -> (f64, f64) {
    let coefficient = lean.angle_deg.to_radians().tan();
    (coefficient, lean.sd_deg.to_radians() * (1.0 + coefficient * coefficient))
}

/// What was found; no standard deviation is known of what is itself one, nor of a force over which friction builds up.
fn rows(estimate: &ViewEstimate, friction: Option<&Lean>, compliance: Option<BaseCompliance>) -> Vec<Row> {
    let row = |parameter: &str, value, sigma| Row { parameter: parameter.to_owned(), value, sigma };
    let quantities = estimate.quantities.iter();
    let mut rows: Vec<Row> =
        quantities.map(|found| row(&found.sought.quantity.to_string(), found.value, Some(found.sigma))).collect();
    if let Some(BaseCompliance { deg_per_n, sigma_deg_per_n }) = compliance {
        rows.push(row("base_deg_per_n", deg_per_n, Some(sigma_deg_per_n).filter(|sigma| sigma.is_finite())));
    }
    if let Some(lean) = friction {
        let (coefficient, sigma) = coefficient(lean);
        rows.push(row("friction", coefficient, Some(sigma)));
        if lean.build_up_n > 0.0 {
            rows.push(row("friction_build_up_n", lean.build_up_n, None));
        }
    }
    rows.push(row("noise_factor", estimate.new_marker_errors.noise_factor, None));
    rows.push(row("model_error_mm", estimate.new_marker_errors.model_mm, None));
    rows.extend(estimate.force_error.map(|error| row("force_error_share", error.of_new, None)));
    rows
}

fn image_rows(seen: &[LocatedView], estimate: &ViewEstimate, from: Normal) -> Vec<ImageRow> {
    let row = |(seen, found): (&LocatedView, &FoundView)| ImageRow {
        image: seen.view.name.clone(),
        s_mm: found.s_mm,
        force_n: found.force.norm(),
        angle_deg: found.lean_deg(&estimate.finger, Normal::Undeformed),
        lean_deg: found.lean_deg(&estimate.finger, from),
        base_x_mm: found.base.translation.x,
        base_y_mm: found.base.translation.y,
        base_deg: found.base.rotation.angle().to_degrees(),
        residual_rms_mm: found.residual_rms_mm(),
    };
    seen.iter().zip(&estimate.views).map(row).collect()
}

/// What the calibrated scene has in place of what the scene has: nothing where there is no value.
fn values(
    scene: &Scene,
    estimate: &ViewEstimate,
    friction: Option<&Lean>,
    compliance: Option<BaseCompliance>,
) -> Vec<(String, Option<Value>)> {
    let sought = |wanted: fn(&Quantity) -> bool| estimate.quantities.iter().any(|found| wanted(&found.sought.quantity));
    let pair = |[x, y]: [f64; 2]| Value::from(Array::from_iter([x, y]));
    let description = estimate.finger.description();
    let mut values: Vec<(String, Option<Value>)> = Vec::new();
    let mut put = |key: String, value: Value| values.push((key, Some(value)));
    if sought(is_modulus) {
        put(FRONT.youngs_modulus_mpa.path(), description.front.youngs_modulus_mpa.into());
        put(BACK.youngs_modulus_mpa.path(), description.back.youngs_modulus_mpa.into());
    }
    if let Some(strip) = description.ribs.strip.filter(|_| sought(|quantity| *quantity == Quantity::Modulus)) {
        put(RIBS.youngs_modulus_mpa.path(), strip.youngs_modulus_mpa.into());
    }
    if sought(|quantity| matches!(quantity, Quantity::Bracket(_) | Quantity::OwnBracket(..))) {
        let each = match &description.ribs.bracket_mm {
            BracketLengths::Alike(lengths_mm) => pair(*lengths_mm),
            BracketLengths::Each(each) => Array::from_iter(each.iter().map(|lengths_mm| pair(*lengths_mm))).into(),
        };
        put(RIBS.bracket_mm.path(), each);
    }
    if sought(|quantity| matches!(quantity, Quantity::Clip | Quantity::PlateClip(_))) {
        put(RIBS.clip_mm.path(), pair(description.ribs.clip_mm));
    }
    if let RibPositions::Positions(positions) = &description.ribs.positions
        && sought(|quantity| matches!(quantity, Quantity::RibPosition(..)))
    {
        let positions = positions.iter().map(|position| pair(*position));
        put(RIBS.positions_mm.path(), Array::from_iter(positions).into());
    }
    if sought(|quantity| *quantity == Quantity::MarkerHeight) {
        put(MARKERS.height_mm.path(), estimate.marker_height_mm.into());
    }
    put(MARKERS.noise_factor.path(), estimate.new_marker_errors.noise_factor.into());
    put(MARKERS.model_error_mm.path(), estimate.new_marker_errors.model_mm.into());
    if let Some(error) = estimate.force_error {
        put(CONTACT.force_error_share.path(), error.of_new.into());
    }
    if sought(|quantity| *quantity == Quantity::BaseX) {
        // The references, or the pose, belong to a frame that is not quite the finger's.
        let references = scene.base.as_ref().map_or(&[][..], |base| &base.references);
        for (i, reference) in references.iter().enumerate() {
            let at: Vector = (estimate.base.inverse() * Point2::from(reference.at)).coords;
            put(REFERENCE.at_mm.path_in(i + 1), pair([at.x, at.y]));
        }
        if let (true, Some(pose)) = (references.is_empty(), scene.camera.and_then(|camera| camera.pose)) {
            let moved = pose.of_moved_base(&estimate.base);
            put(CAMERA.rotation_vector_rad.path(), Array::from_iter(moved.rotation_vector_rad()).into());
            put(CAMERA.translation_mm.path(), Array::from_iter(moved.translation_mm.iter().copied()).into());
        }
    }
    // A base that is taken for exact has no turn to expect.
    let is_sought = scene.base.as_ref().is_some_and(|base| base.uncertainty.is_some());
    if let Some(BaseCompliance { deg_per_n, sigma_deg_per_n }) = compliance.filter(|_| is_sought) {
        put(BASE.turn_deg_per_n.path(), deg_per_n.into());
        if sigma_deg_per_n.is_finite() {
            put(BASE.turn_sigma_deg_per_n.path(), sigma_deg_per_n.into());
        }
    }
    if let Some(lean) = friction {
        let (coefficient, sigma) = coefficient(lean);
        put(CONTACT.friction.path(), coefficient.into());
        put(CONTACT.friction_sigma.path(), sigma.into());
        if lean.build_up_n > 0.0 {
            put(CONTACT.friction_build_up_n.path(), lean.build_up_n.into());
        }
        // Either a coefficient or a range of them.
        values.push((CONTACT.friction_range.path(), None));
    }
    values
}
