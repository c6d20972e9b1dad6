//! Explanation of an accuracy map: noise floors of forces, and force errors caused by wrongly assumed directions and positions.
//!
//! To first order, all limits of sensing follow from three motions of the loaded finger's markers. A small additional force along the load moves the
//! markers by j per newton. A small force across the load moves the markers by c per newton. A shift of the load along the plate moves the markers by
//! m per mm. The motions j, c and m follow from the co-rotational finger's tangent compliance in its loaded shape. The stiffness of the deformed
//! finger differs from the stiffness at rest.

use super::{Context, Evidence};
use crate::prelude::*;
use crate::sampling::bound::{linearised_markers, marker_coordinates};
use crate::sampling::map::MapRequest;
use crate::settings::{DIRECTION_OFF_DEG, POSITION_OFF_MM};
use finray_model::sensing::LARGEST_SPAN;
use finray_model::statics::Ladder;

/// Limits of sensing one force at one position and direction. Every limit is `None` if the finger has no equilibrium.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Explanation {
    /// Position on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// Force, N.
    pub force_n: f64,
    /// Cramer-Rao bound with known position and direction: smallest standard deviation of an unbiased estimate, relative to the force.
    pub bound: Option<f64>,
    /// Cramer-Rao bound with unknown direction, relative to the force; `None` if the two components are not identifiable.
    pub bound_unknown_direction: Option<f64>,
    /// Cramer-Rao bound of the direction, degrees; `None` if the two components are not identifiable.
    pub direction_sigma_deg: Option<f64>,
    /// Condition number, dimensionless: the largest motion of the markers per newton divided by the smallest, over all directions of the force.
    pub condition: Option<f64>,
    /// Size of the relative force error per degree of error in the assumed direction: |d (sensed / true) / d angle|, 1/degree.
    pub error_per_deg: Option<f64>,
    /// Size of the relative force error per mm of error in the assumed position: |d (sensed / true) / d position|, 1/mm. At a rib, the plate's strain
    /// has a step, so the value is a one-sided derivative.
    pub error_per_mm: Option<f64>,
}

/// [`Explanation`]s of one force, by position, then direction.
#[derive(Debug, Clone, PartialEq)]
pub struct ExplanationMap {
    /// Positions on the front plate, mm from the base.
    pub positions_mm: Vec<f64>,
    /// Directions, degrees from the inward normal, positive towards the tip.
    pub angles_deg: Vec<f64>,
    /// Force, N.
    pub force_n: f64,
    /// Standard deviation of the noise of a measured coordinate, mm; the bounds are proportional to it.
    pub noise_mm: f64,
    /// Cells by position, then direction.
    pub cells: Vec<Explanation>,
}

impl Evidence for ExplanationMap {}

/// Explains the accuracy of sensing at the force for which maps are drawn, on the co-rotational finger. Without noise the bounds are 0.
pub(crate) fn run(context: &Context) -> Result<ExplanationMap, LoadError> {
    let (finger, effort) = (context.finger, context.effort);
    let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
    let (positions, step_deg, _) = effort.coarse_resolution();
    // An explanation needs only one shape per cell, so the directions can have a fine step.
    let (positions_mm, angles_deg) = match effort {
        Effort::Quick => {
            let coarse = MapRequest::grid(finger, positions, step_deg).0.len();
            MapRequest::grid(finger, coarse, effort.resolution().1)
        }
        Effort::Full => MapRequest::grid(finger, positions, step_deg),
    };
    ExplanationMap::new(&mesh, &positions_mm, &angles_deg, context.forces.drawn_n(), context.noise_mm)
}

impl ExplanationMap {
    /// Explains sensing of `force_n` (N) at every position (mm) and direction (degrees), in parallel. The markers are all free key nodes.
    ///
    /// # Errors
    /// [`LoadError`] for a position off the front plate.
    pub fn new(
        mesh: &Mesh,
        positions_mm: &[f64],
        angles_deg: &[f64],
        force_n: f64,
        noise_mm: f64,
    ) -> Result<ExplanationMap, LoadError> {
        let at_rest = Statics::ladder(mesh, Kinematics::Corotational);
        let of_position = |&s_mm: &f64| {
            let cell = |&angle_deg: &f64| -> Result<Explanation, LoadError> {
                let contact = Contact { position: ContactPosition::at(s_mm), angle_deg };
                let sensitivity = Sensitivity::of(mesh, &at_rest, &contact, force_n)?;
                Ok(Explanation::of(s_mm, angle_deg, force_n, noise_mm, sensitivity.as_ref()))
            };
            angles_deg.iter().map(cell).collect::<Result<Vec<_>, _>>()
        };
        let cells: Vec<Vec<Explanation>> = positions_mm.par_iter().map(of_position).collect::<Result<_, _>>()?;
        Ok(ExplanationMap {
            positions_mm: positions_mm.to_vec(),
            angles_deg: angles_deg.to_vec(),
            force_n,
            noise_mm,
            cells: cells.concat(),
        })
    }
}

/// Derivatives of the markers' displacements, by coordinate.
struct Sensitivity {
    /// Motion j: displacement per force added along the load, mm/N.
    along: DVector<f64>,
    /// Motion c: displacement per force added across the load (at the angle of the load plus 90 degrees), mm/N.
    across: DVector<f64>,
    /// Motion m: displacement per shift of the load towards the tip, mm/mm.
    moved: DVector<f64>,
}

impl Sensitivity {
    /// Sensitivity at the shape under a force (N); `None` if the finger has no equilibrium.
    fn of(
        mesh: &Mesh,
        at_rest: &Statics<Ladder<'_>>,
        contact: &Contact,
        force_n: f64,
    ) -> Result<Option<Sensitivity>, LoadError> {
        let finger = mesh.finger();
        let mut statics = at_rest.clone();
        let found = linearised_markers(&mut statics, mesh, &[*contact], &[force_n])?;
        let Some((motion, by_force)) = found else { return Ok(None) };
        let along = by_force.column(0).into_owned();
        let turned = Contact { angle_deg: contact.angle_deg + 90.0, ..*contact };
        let across = mesh.frame_load(&turned.unit_load(finger))?;
        let load = mesh.frame_load(&contact.load(finger, force_n))?;
        let ladder = statics.equations_mut();
        let mut rates = vec![Vector::zeros(); finger.key_node_count()];
        ladder.added_load(&motion, &across, &mut rates);
        let across = marker_coordinates(finger, &rates);
        ladder.moved_load(&motion, &load, Plate::Front, &mut rates);
        let moved = marker_coordinates(finger, &rates);
        Ok(Some(Sensitivity { along, across, moved }))
    }

    /// Coefficient j+ x: the multiple of the motion j that best fits another motion x of the markers (least squares); j+ is the pseudoinverse of j.
    fn projected(&self, motion: &DVector<f64>) -> f64 {
        self.along.dot(motion) / self.along.norm_squared()
    }

    /// Largest over smallest singular value of the matrix (j, c). The matrix of the motions under normal and tangential force has the same value,
    /// because it is a rotation of (j, c).
    fn condition(&self) -> f64 {
        let values = DMatrix::from_columns(&[self.along.clone(), self.across.clone()]).singular_values();
        values.max() / values.min()
    }
}

/// Norm of the residual of a vector after projection on another vector.
fn apart(vector: &DVector<f64>, other: &DVector<f64>) -> f64 {
    (vector - other * (other.dot(vector) / other.norm_squared())).norm()
}

/// Causes of a force error, in the order of [`Explanation::errors`].
pub const CAUSES: [&str; 3] = ["noise", "a wrong direction", "a wrong position"];

impl Explanation {
    /// Error of the force, relative to the force, that each of [`CAUSES`] alone causes to first order: noise at the Cramer-Rao bound, and an assumed
    /// contact whose direction or position is wrong by [`DIRECTION_OFF_DEG`] or [`POSITION_OFF_MM`]. `None` without an equilibrium.
    pub fn errors(&self) -> Option<[f64; 3]> {
        Some([self.bound?, self.error_per_deg? * DIRECTION_OFF_DEG, self.error_per_mm? * POSITION_OFF_MM])
    }

    /// With noise s and force F, the bound is s / (F |j|). With unknown direction, the bound is s / (F |j - c c+ j|). The bound of the direction is s
    /// / (F |c - j j+ c|), with the pseudoinverses j+ and c+. An error of one degree in the direction changes the markers' displacements by F (pi /
    /// 180) c. Least squares attributes this change to a force F (pi / 180) j+ c. An error of one mm in the position changes the displacements by m.
    /// Least squares attributes this change to a force j+ m.
    fn of(s_mm: f64, angle_deg: f64, force_n: f64, noise_mm: f64, sensitivity: Option<&Sensitivity>) -> Explanation {
        let condition = sensitivity.map(Sensitivity::condition);
        let told_apart = sensitivity.filter(|_| condition.is_some_and(|condition| condition <= LARGEST_SPAN));
        Explanation {
            s_mm,
            angle_deg,
            force_n,
            bound: sensitivity.map(|seen| noise_mm / (force_n * seen.along.norm())),
            bound_unknown_direction: told_apart.map(|seen| noise_mm / (force_n * apart(&seen.along, &seen.across))),
            direction_sigma_deg: told_apart
                .map(|seen| (noise_mm / (force_n * apart(&seen.across, &seen.along))).to_degrees()),
            condition,
            error_per_deg: sensitivity.map(|seen| seen.projected(&seen.across).abs().to_radians()),
            error_per_mm: sensitivity.map(|seen| seen.projected(&seen.moved).abs() / force_n),
        }
    }
}
