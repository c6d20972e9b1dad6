//! A finger and its rig from several views of it: what the scene states only nominally.
//!
//! A view is an image in which the finger is pressed somewhere on its front plate. Each adds unknowns of its own: where it is pressed, where
//! its base is and, unless it was measured, the force. All views share the [`Quantity`]s that are sought. Without any measured
//! force, geometry alone is identifiable; moduli and forces scale alike.

use super::CalibrationError;
use crate::finger::{BracketLengths, Finger, FingerDescription, Plate, RibPositions};
use crate::frame::FrameMotion;
use crate::least_squares::{Fit, fit};
use crate::measurement::{BaseUncertainty, Marker, Measurement};
use crate::mesh::Mesh;
use crate::sensing::{ContactQuestion, Direction, Lean, NonlinearEstimator, Normal};
use crate::statics::Statics;
use crate::{Kinematics, Load, Vector};
use nalgebra::{DMatrix, DVector, Isometry2, Point2, UnitComplex};
use std::fmt;

/// Something that a scene states and that several views may show better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Factor on all moduli.
    Modulus,
    /// Factor on the modulus of a plate.
    PlateModulus(Plate),
    /// Length of the brackets on a plate, mm.
    Bracket(Plate),
    /// How much longer the bracket of a rib, counted from 0, is on a plate than the scene has it, mm.
    OwnBracket(Plate, usize),
    /// Length of the clips on both plates, mm.
    Clip,
    /// Where a rib, counted from 0, is along a plate, mm.
    RibPosition(Plate, usize),
    /// Height of the markers above the plane of the beams, mm.
    MarkerHeight,
    /// Where the finger is in the frame that a view has of its base, mm.
    BaseX,
    /// The same along y.
    BaseY,
    /// The same for its turn, degrees.
    BaseTurn,
}

/// As in results: `modulus_factor`, `front_bracket_mm`, `back_rib_3_mm`.
impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |plate: &Plate| if *plate == Plate::Front { "front" } else { "back" };
        match self {
            Quantity::Modulus => f.write_str("modulus_factor"),
            Quantity::PlateModulus(plate) => write!(f, "{}_modulus_factor", name(plate)),
            Quantity::Bracket(plate) => write!(f, "{}_bracket_mm", name(plate)),
            Quantity::OwnBracket(plate, rib) => write!(f, "{}_rib_{}_bracket_more_mm", name(plate), rib + 1),
            Quantity::Clip => f.write_str("clip_mm"),
            Quantity::RibPosition(plate, rib) => write!(f, "{}_rib_{}_mm", name(plate), rib + 1),
            Quantity::MarkerHeight => f.write_str("marker_height_mm"),
            Quantity::BaseX => f.write_str("base_x_mm"),
            Quantity::BaseY => f.write_str("base_y_mm"),
            Quantity::BaseTurn => f.write_str("base_deg"),
        }
    }
}

impl Quantity {
    /// Whether it is a factor, of which the logarithm is sought, or a length or angle, of which the change is.
    fn is_factor(self) -> bool {
        matches!(self, Quantity::Modulus | Quantity::PlateModulus(_))
    }
}

/// A quantity that is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sought {
    /// Which.
    pub quantity: Quantity,
    /// How well the scene has it, if that is known: standard deviation in the quantity's unit, of a factor in parts of it.
    pub prior_sd: Option<f64>,
}

/// One image of the finger, as it was located with the scene's rig.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Displacements of markers from the scene's undeformed finger, mm, in the frame that the image has of its base.
    pub measurement: Measurement,
    /// Standard deviation of a coordinate of weight 1, mm.
    pub noise_mm: f64,
    /// How far the base may be from there.
    pub base: BaseUncertainty,
    /// Where the camera stands above that frame, mm.
    pub eye: Vector,
    /// The contact force in that frame, N, where it was measured.
    pub force: Option<Vector>,
}

/// What is held beside the views.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewModel {
    /// Elements a member.
    pub elements: usize,
    /// Height of the camera above the plane of the beams, mm.
    pub camera_height_mm: f64,
    /// Height of the markers above it, mm.
    pub marker_height_mm: f64,
    /// How a force leans that was not measured.
    pub lean: Lean,
}

/// A quantity as it was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundQuantity {
    /// What was sought.
    pub sought: Sought,
    /// Its value: of lengths and angles the whole, of factors on what the scene has.
    pub value: f64,
    /// Its standard deviation.
    pub sigma: f64,
}

/// A view as the calibrated finger has it.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundView {
    /// Where the force acts, mm along the front plate.
    pub s_mm: f64,
    /// The force in the finger frame, N.
    pub force: Vector,
    /// Where the base is in the frame that the view has of it.
    pub base: Isometry2<f64>,
    /// By how much the plate's normal is turned at the contact, rad; the mean over the length that leans count from.
    pub normal_turn_rad: f64,
    /// Computed less seen position of each marker, mm, in the frame of the view.
    pub residuals_mm: Vec<Vector>,
}

impl FoundView {
    /// Root mean square of the residual of a coordinate, mm.
    pub fn residual_rms_mm(&self) -> f64 {
        let squares: f64 = self.residuals_mm.iter().map(Vector::norm_squared).sum();
        (squares / (2 * self.residuals_mm.len()) as f64).sqrt()
    }

    /// By how much the force leans from a normal towards the tip, degrees.
    pub fn lean_deg(&self, finger: &Finger, from: Normal) -> f64 {
        let [inward, tipward] = [0.0, 90.0].map(|angle_deg| finger.direction(angle_deg));
        let angle_deg = self.force.dot(&tipward).atan2(self.force.dot(&inward)).to_degrees();
        match from {
            Normal::Undeformed => angle_deg,
            Normal::Deformed { .. } => angle_deg - self.normal_turn_rad.to_degrees(),
        }
    }
}

/// A finger and its rig as several views have them.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewEstimate {
    /// The finger with all that was found.
    pub finger: Finger,
    /// Height of the markers, mm.
    pub marker_height_mm: f64,
    /// Where the finger is in the frame that a view has of its base.
    pub base: Isometry2<f64>,
    /// The quantities that were sought.
    pub quantities: Vec<FoundQuantity>,
    /// Correlation of each two of them.
    pub correlation: DMatrix<f64>,
    /// The views.
    pub views: Vec<FoundView>,
    /// By how much the finger misses its markers beyond their noise, mm: standard deviation of one coordinate.
    pub model_error_mm: f64,
    /// By which share the finger misses measured forces beyond what noise, place and base explain: standard deviation of one force.
    /// `None` where no modulus is sought, or no force was measured.
    pub force_error: Option<f64>,
}

/// Of the unknowns of one view: position, base x, y and turn; then the force, where it was not measured exactly, and its lean, where it was not
/// measured.
const OWN: usize = 4;
/// Standard deviation of the residual, mm, with which the fit begins; then that of the last fit.
const FIRST_MODEL_ERROR_MM: f64 = 0.05;
const ROUNDS: usize = 6;
/// The same for the error of a force, as a share of it, and the least that counts.
const FIRST_FORCE_ERROR: f64 = 0.01;
const LEAST_FORCE_ERROR: f64 = 1e-5;
/// Steps for derivatives: of lengths, mm, of factors, forces, as shares, and angles in rad, and of angles in degrees. Equilibria are good to
/// ten digits.
const LENGTH_STEP: f64 = 1e-3;
const SHARE_STEP: f64 = 1e-4;
const ANGLE_STEP_DEG: f64 = 1e-2;
/// A factor whose logarithm is known to no better, or a length, mm, or an angle, degrees, is not identifiable.
const LARGEST_SIGMAS: [f64; 2] = [1.0, 20.0];
/// Share of the plate that is left free at both ends of where a contact is sought.
const MARGIN: f64 = 0.02;
/// Standard deviation of a lean, degrees, that counts as none.
const SETTLED_DEG: f64 = 1e-3;
/// Parts of the plate at whose ends a contact is sought at first.
const PLACES: usize = 50;
/// The turn of the normal has settled, rad, after so many steps at most.
const SETTLED_RAD: f64 = 1e-9;
const NORMAL_STEPS: usize = 60;
/// Build-up forces that are tried, over three powers of ten: 0.7 % from one to the next.
const BUILD_UPS: usize = 1000;

/// Everything that is sought, as one point of the search.
#[derive(Debug, Clone, PartialEq)]
struct Point {
    /// Changes of the quantities: logarithms of factors, mm, degrees.
    shared: Vec<f64>,
    own: Vec<Own>,
}

/// The unknowns of one view.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Own {
    s_mm: f64,
    base: Isometry2<f64>,
    force_n: f64,
    /// How much further than its mean the force leans, degrees.
    further_lean_deg: f64,
}

/// A finger and a rig.
struct Candidate {
    mesh: Mesh,
    marker_height_mm: f64,
    base: Isometry2<f64>,
}

/// The search's problem.
struct Problem<'p> {
    finger: &'p Finger,
    views: &'p [View],
    sought: &'p [Sought],
    model: &'p ViewModel,
    model_error_mm: f64,
    /// `None` where measured forces are exact.
    force_error: Option<f64>,
}

/// Finds what several views show of a finger and its rig.
///
/// # Reference
/// Nonlinear least squares over all views and their own unknowns at once (bundle adjustment, Triggs et al. 2000, with the co-rotational
/// finger in place of points), by the method of Levenberg and Marquardt; derivatives are differences of equilibria. What the finger leaves
/// unexplained beyond the noise is a variance that is estimated with it, so that priors weigh as much as they should. Where a modulus is
/// sought, so is the variance of the share by which measured forces are missed, by Schall's iteration (Biometrika 78, 1991): it
/// holds what is wrong with the sensor, and with the model where markers do not show it.
///
/// # Errors
/// [`CalibrationError`] where a view has no explanation at the start, or a quantity is not identifiable.
pub fn views(
    finger: &Finger,
    views: &[View],
    sought: &[Sought],
    model: &ViewModel,
) -> Result<ViewEstimate, CalibrationError> {
    let is_scaled = sought.iter().any(|sought| sought.quantity.is_factor()) && views.iter().any(|v| v.force.is_some());
    let force_error = is_scaled.then_some(FIRST_FORCE_ERROR);
    let mut problem = Problem { finger, views, sought, model, model_error_mm: FIRST_MODEL_ERROR_MM, force_error };
    let names = |quantities: &mut dyn Iterator<Item = usize>| {
        quantities.map(|k| sought[k].quantity.to_string()).collect::<Vec<_>>().join(", ")
    };
    let all = || names(&mut (0..sought.len()));
    let coordinates: usize = views.iter().map(|view| view.measurement.coordinate_count()).sum();
    let unknowns = sought.iter().filter(|sought| sought.prior_sd.is_none()).count()
        + views.iter().map(|view| if view.force.is_some() { 1 } else { 2 }).sum::<usize>();
    if coordinates <= unknowns {
        return Err(CalibrationError::TooFewMarkers { unknowns, coordinates });
    }
    let mut point = problem.start()?;
    let mut found = None;
    for _ in 0..ROUNDS {
        let fitted = fit(point.clone(), |point| problem.linearised(point), |point, step| problem.moved(point, step));
        let fitted = fitted.ok_or(CalibrationError::NoMinimum)?;
        point.clone_from(&fitted.parameters);
        let squares_mm2 = problem.residual_squares_mm2(&point).ok_or(CalibrationError::NoMinimum)?;
        let noise_mm2: f64 = views
            .iter()
            .flat_map(|view| view.measurement.markers().iter().map(|m| 2.0 * (view.noise_mm / m.weight).powi(2)))
            .sum();
        // What was fitted is missing in the residual.
        let left = (coordinates - unknowns) as f64 / coordinates as f64;
        let excess_mm2 = (squares_mm2 / left - noise_mm2) / coordinates as f64;
        problem.model_error_mm = excess_mm2.max(0.0).sqrt();
        if let Some(before) = problem.force_error {
            let covariance = fitted.inverse.as_ref();
            let covariance = covariance.ok_or_else(|| CalibrationError::NotSeparable { parameters: all() })?;
            problem.force_error = Some(problem.force_error_of(&point, covariance, before).max(LEAST_FORCE_ERROR));
        }
        found = Some(fitted);
    }
    let Fit { parameters: point, inverse, .. } = found.ok_or(CalibrationError::NoMinimum)?;
    let covariance = inverse.ok_or_else(|| CalibrationError::NotSeparable { parameters: all() })?;
    let sigma = |k: usize| covariance[(k, k)].sqrt();
    let open = |k: &usize| {
        let limit = LARGEST_SIGMAS[usize::from(!sought[*k].quantity.is_factor())];
        sigma(*k).is_nan() || sigma(*k) >= limit
    };
    if (0..sought.len()).any(|k| open(&k)) {
        return Err(CalibrationError::NotIdentifiable { parameters: names(&mut (0..sought.len()).filter(open)) });
    }
    let candidate = problem.candidate(&point.shared).ok_or(CalibrationError::NoMinimum)?;
    let quantities = sought.iter().zip(&point.shared).enumerate().map(|(k, (sought, change))| {
        let value = match sought.quantity.is_factor() {
            true => change.exp(),
            false => problem.stated(sought.quantity) + change,
        };
        FoundQuantity {
            sought: *sought,
            value,
            sigma: sigma(k) * if sought.quantity.is_factor() { value } else { 1.0 },
        }
    });
    let mut found_views = Vec::new();
    for (view, own) in views.iter().zip(&point.own) {
        let pressed = problem.pressed(&candidate, view, own).ok_or(CalibrationError::NoMinimum)?;
        found_views.push(FoundView {
            s_mm: own.s_mm,
            force: pressed.force * (view.force.map_or(own.force_n, |force| force.norm()) / own.force_n),
            base: candidate.base * own.base,
            normal_turn_rad: pressed.normal_turn_rad,
            residuals_mm: problem.residuals(&candidate, view, own, &pressed).map(|(_, left)| left).collect(),
        });
    }
    Ok(ViewEstimate {
        quantities: quantities.collect(),
        correlation: DMatrix::from_fn(sought.len(), sought.len(), |i, j| covariance[(i, j)] / (sigma(i) * sigma(j))),
        views: found_views,
        model_error_mm: problem.model_error_mm,
        force_error: problem.force_error,
        marker_height_mm: candidate.marker_height_mm,
        base: candidate.base,
        finger: candidate.mesh.finger().clone(),
    })
}

/// A description with one quantity changed.
fn changed(description: &mut FingerDescription, rib_count: usize, quantity: Quantity, change: f64) {
    let plate_index = |plate: Plate| usize::from(plate == Plate::Back);
    match quantity {
        Quantity::Modulus => {
            description.front.youngs_modulus_mpa *= change.exp();
            description.back.youngs_modulus_mpa *= change.exp();
            if let Some(strip) = &mut description.ribs.strip {
                strip.youngs_modulus_mpa *= change.exp();
            }
        }
        Quantity::PlateModulus(Plate::Front) => description.front.youngs_modulus_mpa *= change.exp(),
        Quantity::PlateModulus(Plate::Back) => description.back.youngs_modulus_mpa *= change.exp(),
        Quantity::Bracket(plate) => {
            let all = description.ribs.bracket_mm.all_mut();
            all.iter_mut().for_each(|lengths_mm| lengths_mm[plate_index(plate)] += change);
        }
        Quantity::OwnBracket(plate, rib) => {
            let ribs = &mut description.ribs;
            let mut each: Vec<[f64; 2]> = (0..rib_count).map(|rib| ribs.bracket_mm.of(rib)).collect();
            each[rib][plate_index(plate)] += change;
            ribs.bracket_mm = BracketLengths::Each(each);
        }
        Quantity::Clip => description.ribs.clip_mm.iter_mut().for_each(|clip_mm| *clip_mm += change),
        Quantity::RibPosition(plate, rib) => {
            if let RibPositions::Positions(positions) = &mut description.ribs.positions
                && let Some(position) = positions.get_mut(rib)
            {
                position[plate_index(plate)] += change;
            }
        }
        Quantity::MarkerHeight | Quantity::BaseX | Quantity::BaseY | Quantity::BaseTurn => {}
    }
}

impl Problem<'_> {
    /// What the scene states of a quantity: zero where it has none of its own.
    fn stated(&self, quantity: Quantity) -> f64 {
        let ribs = &self.finger.description().ribs;
        match quantity {
            Quantity::Bracket(plate) => ribs.bracket_mm.of(0)[usize::from(plate == Plate::Back)],
            Quantity::Clip => ribs.clip_mm[0],
            Quantity::RibPosition(plate, rib) => match &ribs.positions {
                RibPositions::Positions(positions) => positions[rib][usize::from(plate == Plate::Back)],
                RibPositions::Count(_) => f64::NAN,
            },
            Quantity::MarkerHeight => self.model.marker_height_mm,
            _ => 0.0,
        }
    }

    /// The finger and rig of some changes; `None` if there is no such finger.
    fn candidate(&self, shared: &[f64]) -> Option<Candidate> {
        let mut description = self.finger.description().clone();
        let (mut marker_height_mm, mut at, mut turn_deg) = (self.model.marker_height_mm, Vector::zeros(), 0.0);
        for (sought, &change) in self.sought.iter().zip(shared) {
            match sought.quantity {
                Quantity::MarkerHeight => marker_height_mm += change,
                Quantity::BaseX => at.x += change,
                Quantity::BaseY => at.y += change,
                Quantity::BaseTurn => turn_deg += change,
                of_finger => changed(&mut description, self.finger.rib_count(), of_finger, change),
            }
        }
        let finger = Finger::new(description).ok()?;
        let base = Isometry2::new(at, turn_deg.to_radians());
        Some(Candidate { mesh: Mesh::with_elements_per_member(&finger, self.model.elements), marker_height_mm, base })
    }

    /// Where the search begins: every view as the scene's finger explains it best.
    fn start(&self) -> Result<Point, CalibrationError> {
        let shared = vec![0.0; self.sought.len()];
        let stated = self.candidate(&shared).ok_or(CalibrationError::NoMinimum)?;
        let own = self.views.iter().map(|view| match view.force {
            Some(force) => self.start_of_known(&stated, view, force.norm()),
            None => self.start_of_unknown(&stated, view),
        });
        Ok(Point { shared, own: own.collect::<Result<_, _>>()? })
    }

    /// The place along the plate where a measured force bends the finger most like what is seen, wherever the base is.
    fn start_of_known(&self, stated: &Candidate, view: &View, force_n: f64) -> Result<Own, CalibrationError> {
        let length_mm = self.finger.plate_length_mm(Plate::Front);
        let at = |i: usize| Own {
            s_mm: length_mm * i as f64 / PLACES as f64,
            base: Isometry2::identity(),
            force_n,
            further_lean_deg: 0.0,
        };
        let misfit = |own: &Own| {
            let pressed = self.pressed(stated, view, own)?;
            Some(misfit_of_shape(self.residuals(stated, view, own, &pressed).map(|(marker, left)| {
                (self.finger.position(marker.node) + self.finger.marker_offset(marker.node) + marker.displacement, left)
            })))
        };
        let tried = (1..PLACES).map(at).filter_map(|own| misfit(&own).map(|misfit| (misfit, own)));
        let best = tried.min_by(|(a, _), (b, _)| a.total_cmp(b));
        best.map(|(_, own)| own).ok_or(CalibrationError::NotCarried { force_n })
    }

    /// Force and place as they are sensed.
    fn start_of_unknown(&self, stated: &Candidate, view: &View) -> Result<Own, CalibrationError> {
        let direction = Direction::Leaning(Lean { sd_deg: 0.0, ..self.model.lean });
        let questions = [ContactQuestion { position: None, direction }];
        let mut estimator = NonlinearEstimator::new(&stated.mesh, &questions)?;
        let measurement = view.measurement.clone().with_uncertain_base(view.base);
        let sensed = estimator.estimate(&measurement, Some(view.noise_mm.hypot(FIRST_MODEL_ERROR_MM)))?;
        Ok(Own {
            s_mm: sensed.contacts[0].position_mm(self.finger).unwrap_or_default(),
            base: Isometry2::identity(),
            force_n: sensed.forces.forces_n[0],
            further_lean_deg: 0.0,
        })
    }

    /// Number of unknowns of a view.
    fn own_count(&self, view: &View) -> usize {
        match view.force {
            Some(_) => OWN + usize::from(self.force_error.is_some()),
            None => OWN + 2,
        }
    }

    /// Standard deviation of the share by which measured forces are missed, given that of the last fit: what was found, by as many forces as the
    /// images tell.
    fn force_error_of(&self, point: &Point, covariance: &DMatrix<f64>, before: f64) -> f64 {
        let (mut column, mut squares, mut told) = (self.sought.len(), 0.0, 0.0);
        for (view, own) in self.views.iter().zip(&point.own) {
            if let Some(force) = view.force {
                let (force_n, at) = (force.norm(), column + OWN);
                squares += (own.force_n / force_n - 1.0).powi(2);
                told += 1.0 - covariance[(at, at)] / (force_n * before).powi(2);
            }
            column += self.own_count(view);
        }
        (squares / told.max(f64::MIN_POSITIVE)).sqrt()
    }

    /// The force of a view in the finger frame, and how the finger bends under it; `None` where there is no equilibrium.
    fn pressed(&self, candidate: &Candidate, view: &View, own: &Own) -> Option<Pressed> {
        let finger = candidate.mesh.finger();
        let over_mm = match self.model.lean.from {
            Normal::Deformed { over_mm } => over_mm,
            Normal::Undeformed => 0.0,
        };
        let mut statics = Statics::ladder(&candidate.mesh, Kinematics::Corotational);
        let mut under = |force: Vector| {
            let load = Load::at_position(own.s_mm, force);
            let motion = statics.equilibrium(&[candidate.mesh.frame_load(&load).ok()?]).ok()?.motion;
            let normal_turn_rad = candidate.mesh.normal_turn(&motion, &load, over_mm).ok()?;
            Some(Pressed { force, motion, normal_turn_rad })
        };
        if let Some(force) = view.force {
            return under((candidate.base * own.base).rotation.inverse() * force * (own.force_n / force.norm()));
        }
        // The lean counts from a normal that turns with the force: settled in a few steps.
        let lean_deg = self.model.lean.mean_deg(own.force_n) + own.further_lean_deg;
        let mut turn_rad = 0.0_f64;
        for _ in 0..NORMAL_STEPS {
            let pressed = under(finger.direction(lean_deg + turn_rad.to_degrees()) * own.force_n)?;
            let before = turn_rad;
            if let Normal::Deformed { .. } = self.model.lean.from {
                turn_rad = pressed.normal_turn_rad;
            }
            if (turn_rad - before).abs() <= SETTLED_RAD {
                return Some(pressed);
            }
        }
        None
    }

    /// What is left of each marker of a view, mm.
    fn residuals<'v>(
        &self,
        candidate: &'v Candidate,
        view: &'v View,
        own: &Own,
        pressed: &'v Pressed,
    ) -> impl Iterator<Item = (&'v Marker, Vector)> {
        let (finger, stated) = (candidate.mesh.finger(), self.finger);
        let placed = candidate.base * own.base;
        let height_mm = self.model.camera_height_mm;
        // Markers that are higher than they were thought to be are nearer to where the camera stands.
        let nearer = (height_mm - candidate.marker_height_mm) / (height_mm - self.model.marker_height_mm);
        let undeformed = |finger: &Finger, node| finger.position(node) + finger.marker_offset(node);
        view.measurement.markers().iter().map(move |marker| {
            let seen = undeformed(stated, marker.node) + marker.displacement;
            let displaced = pressed.motion.displacements[candidate.mesh.marker_node(marker.node)];
            let computed = placed * Point2::from(undeformed(finger, marker.node) + displaced);
            (marker, computed.coords - (view.eye + (seen - view.eye) * nearer))
        })
    }

    /// Residuals of one view in their standard deviations, its priors last; `None` where there is no equilibrium.
    fn weighted(&self, candidate: &Candidate, view: &View, own: &Own) -> Option<Vec<f64>> {
        let pressed = self.pressed(candidate, view, own)?;
        let mut rows = Vec::with_capacity(view.measurement.coordinate_count() + OWN);
        for (marker, residual) in self.residuals(candidate, view, own, &pressed) {
            let sd_mm = (view.noise_mm / marker.weight).hypot(self.model_error_mm);
            rows.extend((residual / sd_mm).iter());
        }
        let BaseUncertainty { sd_mm, sd_rad } = view.base;
        let at = own.base.translation.vector / sd_mm;
        rows.extend([at.x, at.y, own.base.rotation.angle() / sd_rad]);
        if let (Some(force), Some(force_error)) = (view.force, self.force_error) {
            rows.push((own.force_n / force.norm() - 1.0) / force_error);
        }
        if view.force.is_none() {
            rows.push(own.further_lean_deg / self.model.lean.sd_deg.max(SETTLED_DEG));
        }
        Some(rows)
    }

    /// Sum of the squared residuals of all markers, mm^2.
    fn residual_squares_mm2(&self, point: &Point) -> Option<f64> {
        let candidate = self.candidate(&point.shared)?;
        let mut sum = 0.0;
        for (view, own) in self.views.iter().zip(&point.own) {
            let pressed = self.pressed(&candidate, view, own)?;
            sum += self.residuals(&candidate, view, own, &pressed).map(|(_, left)| left.norm_squared()).sum::<f64>();
        }
        Some(sum)
    }

    /// All residuals and their derivatives by a step; `None` where there is no equilibrium.
    fn linearised(&self, point: &Point) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let candidate = self.candidate(&point.shared)?;
        let at: Vec<Vec<f64>> = (self.views.iter().zip(&point.own))
            .map(|(view, own)| self.weighted(&candidate, view, own))
            .collect::<Option<_>>()?;
        let priors = self.sought.iter().filter(|sought| sought.prior_sd.is_some()).count();
        let shared = self.sought.len();
        let rows = at.iter().map(Vec::len).sum::<usize>() + priors;
        let unknowns = shared + self.views.iter().map(|view| self.own_count(view)).sum::<usize>();
        let mut residual = DVector::zeros(rows);
        let mut by = DMatrix::zeros(rows, unknowns);
        let mut row = 0;
        for rows in &at {
            residual.rows_mut(row, rows.len()).copy_from_slice(rows);
            row += rows.len();
        }
        for (k, sought) in self.sought.iter().enumerate() {
            let step = if sought.quantity.is_factor() { SHARE_STEP } else { LENGTH_STEP };
            let mut changed = point.shared.clone();
            changed[k] += step;
            let other = self.candidate(&changed)?;
            let mut row = 0;
            for ((view, own), before) in self.views.iter().zip(&point.own).zip(&at) {
                for (i, (after, before)) in self.weighted(&other, view, own)?.iter().zip(before).enumerate() {
                    by[(row + i, k)] = (after - before) / step;
                }
                row += before.len();
            }
            if let Some(prior_sd) = sought.prior_sd {
                let place = row + self.sought[..k].iter().filter(|sought| sought.prior_sd.is_some()).count();
                residual[place] = point.shared[k] / prior_sd;
                by[(place, k)] = 1.0 / prior_sd;
            }
        }
        let (mut row, mut column) = (0, shared);
        for ((view, own), before) in self.views.iter().zip(&point.own).zip(&at) {
            for j in 0..self.own_count(view) {
                let step = own.step(j);
                let after = self.weighted(&candidate, view, &own.moved(self.finger, j, step))?;
                for (i, (after, before)) in after.iter().zip(before).enumerate() {
                    by[(row + i, column)] = (after - before) / step;
                }
                column += 1;
            }
            row += before.len();
        }
        Some((residual, by))
    }

    /// A point after a step.
    fn moved(&self, point: &Point, step: &DVector<f64>) -> Point {
        let mut moved = point.clone();
        for (change, step) in moved.shared.iter_mut().zip(step) {
            *change += step;
        }
        let mut column = self.sought.len();
        for (view, own) in self.views.iter().zip(&mut moved.own) {
            for j in 0..self.own_count(view) {
                *own = own.moved(self.finger, j, step[column]);
                column += 1;
            }
        }
        moved
    }
}

/// What is left of residuals at points, mm^2, once the whole shape has moved to where they are least.
fn misfit_of_shape(residuals: impl Iterator<Item = (Vector, Vector)>) -> f64 {
    let all: Vec<(Vector, Vector)> = residuals.collect();
    let count = all.len().max(1) as f64;
    let [middle, shift] =
        all.iter().fold([Vector::zeros(); 2], |[p, r], (point, left)| [p + point / count, r + left / count]);
    let (mut squares, mut turned, mut arms) = (0.0, 0.0, 0.0);
    for (point, left) in &all {
        let (arm, left) = (point - middle, left - shift);
        squares += left.norm_squared();
        turned += arm.perp(&left);
        arms += arm.norm_squared();
    }
    squares - turned * turned / arms.max(f64::MIN_POSITIVE)
}

/// A finger under a force.
struct Pressed {
    force: Vector,
    motion: FrameMotion,
    normal_turn_rad: f64,
}

impl Own {
    /// Step of an unknown for derivatives.
    fn step(&self, unknown: usize) -> f64 {
        match unknown {
            0 => LENGTH_STEP,
            1 | 2 => LENGTH_STEP,
            3 => SHARE_STEP,
            4 => SHARE_STEP * self.force_n,
            _ => ANGLE_STEP_DEG,
        }
    }

    /// The same with one unknown moved.
    fn moved(&self, finger: &Finger, unknown: usize, by: f64) -> Own {
        let mut moved = *self;
        match unknown {
            0 => {
                let length_mm = finger.plate_length_mm(Plate::Front);
                moved.s_mm = (self.s_mm + by).clamp(MARGIN * length_mm, (1.0 - MARGIN) * length_mm);
            }
            1 => moved.base.translation.x += by,
            2 => moved.base.translation.y += by,
            3 => moved.base.rotation = UnitComplex::new(by) * self.base.rotation,
            4 => moved.force_n += by,
            _ => moved.further_lean_deg += by,
        }
        moved
    }
}

/// How forces that were measured lean, as friction would have it: the coefficient and, if it is sought, the force over which it builds up, for
/// which leans are met best; the standard deviation is that of what is left. `leans` has force, N, and lean, degrees, of each view.
///
/// # Errors
/// [`CalibrationError::TooFewViews`] where there are no more views than unknowns.
pub fn friction_of(leans: &[(f64, f64)], from: Normal, builds_up: bool) -> Result<Lean, CalibrationError> {
    let unknowns = 1 + usize::from(builds_up);
    if leans.len() <= unknowns {
        return Err(CalibrationError::TooFewViews { views: leans.len(), unknowns });
    }
    let with = |build_up_n: f64| {
        let unit = Lean { angle_deg: 1.0, build_up_n, from, ..Lean::NONE };
        let shares = || leans.iter().map(|(force_n, lean_deg)| (unit.mean_deg(*force_n), lean_deg));
        let angle_deg = shares().map(|(share, lean)| share * lean).sum::<f64>()
            / shares().map(|(share, _)| share * share).sum::<f64>();
        let squares: f64 = shares().map(|(share, lean)| (lean - angle_deg * share).powi(2)).sum();
        let sd_deg = (squares / (leans.len() - unknowns) as f64).sqrt();
        Lean { angle_deg, sd_deg, ..unit }
    };
    if !builds_up {
        return Ok(with(0.0));
    }
    let largest_n = leans.iter().fold(0.0_f64, |m, (force_n, _)| m.max(force_n.abs()));
    // From at once to hardly: the sum of squares is smooth in between.
    let tried = |i: usize| with(largest_n * 10f64.powf(-2.0 + 3.0 * i as f64 / BUILD_UPS as f64));
    let best = (0..=BUILD_UPS).map(tried).chain([with(0.0)]).min_by(|a, b| a.sd_deg.total_cmp(&b.sd_deg));
    best.ok_or(CalibrationError::NoMinimum)
}
