//! Maps of where sensing fails, for every truth and estimator, and what explains them.

use super::StudyError;
use crate::estimators::network::{NetworkSensing, Networks};
use crate::estimators::{BeamEstimator, ELEMENTS, Estimator, EstimatorKind};
use crate::experiments::explain::ExplanationMap;
use crate::experiments::networks::accuracy;
use crate::experiments::twin::study::TwinStudyError;
use crate::experiments::twin::twin_of;
use crate::problems::ProblemError;
use crate::sampling::map::{AccuracyMap, MapRequest, accuracy_maps};
use crate::settings::{DRAWN_FORCE_N, Effort, MAP_FORCES_N, Progress};
use crate::truths::{LatticeTruth, MeshTruth, MujocoTruth, NotExported, Truth, fine_mesh};
use finray_model::statics::StaticsError;
use finray_model::{Finger, Kinematics, Mesh};

/// What maps are made of.
pub(super) struct Maps<'s> {
    pub finger: &'s Finger,
    /// The mesh of key nodes alone, on which the linear finger is exact.
    pub coarse: &'s Mesh,
    pub corotational: &'s MeshTruth<'s>,
    /// Standard deviations of a coordinate, mm, from 0.
    pub noise_levels_mm: &'s [f64],
    pub effort: Effort,
}

/// An estimator that takes long, or whose errors need no fine grid, is asked less.
enum Grid {
    Fine,
    Coarse,
    /// The same for the drawn force alone, with noise, in few pictures: a shape that the nonlinear estimator cannot explain costs it a
    /// hundred times as much, as it searches from every start.
    Few,
    /// Contact nodes, along the normal: where there are networks.
    Nodes,
}

impl Maps<'_> {
    /// Steps that [`beams`](Maps::beams) and [`papers`](Maps::papers) report.
    pub(super) fn steps(&self, is_paper: bool) -> usize {
        let contacts = |grid| self.request(grid).contact_count();
        let beams = 2 * (contacts(Grid::Fine) + 2 * contacts(Grid::Coarse));
        beams + if is_paper { 2 * contacts(Grid::Coarse) + 4 * contacts(Grid::Nodes) } else { 0 }
    }

    /// The finger's own beams, linear and with large rotations, sensed by every estimator of the beam model; least squares
    /// first.
    pub(super) fn beams(&self, progress: &dyn Progress) -> Result<Vec<AccuracyMap>, StudyError> {
        let linear = MeshTruth::new("linear", self.coarse, Kinematics::Linear)?;
        let step = || progress.step();
        let truths: [&dyn Truth; 2] = [&linear, self.corotational];
        let mut maps = Vec::new();
        for truth in truths {
            maps.extend(self.sensed(truth, &[EstimatorKind::LeastSquares], &self.request(Grid::Fine), &step));
        }
        for truth in truths {
            maps.extend(self.sensed(truth, &[EstimatorKind::Ridge], &self.request(Grid::Coarse), &step));
        }
        for (truth, grid) in truths.into_iter().zip([Grid::Few, Grid::Coarse]) {
            maps.extend(self.sensed(truth, &[EstimatorKind::Nonlinear], &self.request(grid), &step));
        }
        Ok(maps)
    }

    /// What exists for the paper's finger alone: its twin, MuJoCo's shapes, and networks on every truth.
    pub(super) fn papers(&self, progress: &dyn Progress) -> Result<Vec<AccuracyMap>, StudyError> {
        let finger = self.finger;
        let step = || progress.step();
        let twin_finger = twin_of(finger).map_err(TwinStudyError::from)?;
        let twin_mesh = fine_mesh(&twin_finger)?;
        let twin = MeshTruth::new("twin", &twin_mesh, Kinematics::Corotational)?;
        let lattice = LatticeTruth::new(finger).map_err(ProblemError::from)?;
        let linear = MeshTruth::new("linear", self.coarse, Kinematics::Linear)?;
        let linear_kinds = [EstimatorKind::LeastSquares, EstimatorKind::Ridge];
        let mut maps = self.sensed(&twin, &linear_kinds, &self.request(Grid::Coarse), &step);
        maps.extend(self.sensed(&twin, &[EstimatorKind::Nonlinear], &self.request(Grid::Few), &step));

        let shipped = Networks::shipped()?;
        let networks = NetworkSensing { name: accuracy::NAME, networks: &shipped, finger, refuses: true };
        let truths: [&dyn Truth; 4] = [&linear, self.corotational, &twin, &lattice];
        for truth in truths {
            let nodes = self.request(Grid::Nodes);
            maps.extend(accuracy_maps(finger, truth, &[&networks], &nodes, &step));
        }
        let exported = match MujocoTruth::new(finger) {
            Err(NotExported::Finger) => return Ok(maps),
            exported => exported?,
        };
        let (places_mm, angles_deg) = exported.grid();
        let forces_n = MAP_FORCES_N.into_iter().filter(|force| exported.require_force(*force).is_ok()).collect();
        let cells = MapRequest { places_mm, angles_deg, forces_n, ..self.request(Grid::Coarse) };
        maps.extend(self.sensed(&exported, &EstimatorKind::ALL, &cells, &|| ()));
        let nodes = MapRequest { forces_n: cells.forces_n.clone(), ..self.request(Grid::Nodes) };
        maps.extend(accuracy_maps(finger, &exported, &[&networks], &nodes, &|| ()));
        Ok(maps)
    }

    /// What limits sensing of the drawn force on the large-rotation finger.
    pub(super) fn explanations(&self) -> Result<ExplanationMap, StudyError> {
        let mesh = Mesh::with_elements_per_member(self.finger, ELEMENTS);
        let MapRequest { places_mm, angles_deg, .. } = self.request(Grid::Coarse);
        let noise_mm = self.noise_levels_mm.last().copied().unwrap_or(0.0);
        let (places, angles) = match self.effort {
            // Explanations cost a single shape a cell.
            Effort::Quick => MapRequest::grid(self.finger, places_mm.len(), self.effort.resolution().1),
            Effort::Full => (places_mm, angles_deg),
        };
        Ok(ExplanationMap::new(&mesh, &places, &angles, DRAWN_FORCE_N, noise_mm).map_err(StaticsError::from)?)
    }

    fn sensed(
        &self,
        truth: &dyn Truth,
        kinds: &[EstimatorKind],
        request: &MapRequest,
        progress: &(dyn Fn() + Sync),
    ) -> Vec<AccuracyMap> {
        let fine = Mesh::with_elements_per_member(self.finger, ELEMENTS);
        let on = |kind| if kind == EstimatorKind::Nonlinear { &fine } else { self.coarse };
        let estimators: Vec<_> = kinds.iter().map(|&kind| BeamEstimator::new(kind, on(kind))).collect();
        let estimators: Vec<&dyn Estimator> = estimators.iter().map(|estimator| estimator as &dyn Estimator).collect();
        accuracy_maps(self.finger, truth, &estimators, request, progress)
    }

    fn request(&self, grid: Grid) -> MapRequest {
        let few = matches!(grid, Grid::Few);
        let (places, step_deg, noise_pictures) = match grid {
            Grid::Fine | Grid::Nodes => self.effort.resolution(),
            Grid::Coarse => self.effort.coarse_resolution(),
            Grid::Few => self.effort.coarsest_resolution(),
        };
        let (places_mm, angles_deg) = match grid {
            Grid::Nodes => {
                let nodes = self.finger.contact_nodes().rev();
                (nodes.filter_map(|node| self.finger.front_place_mm(node)).collect(), vec![0.0])
            }
            Grid::Fine | Grid::Coarse | Grid::Few => MapRequest::grid(self.finger, places, step_deg),
        };
        let forces_n = if few { vec![DRAWN_FORCE_N] } else { MAP_FORCES_N.to_vec() };
        MapRequest {
            places_mm,
            angles_deg,
            forces_n,
            noise_levels_mm: if few {
                self.noise_levels_mm.last().copied().into_iter().collect()
            } else {
                self.noise_levels_mm.to_vec()
            },
            noise_pictures,
            seed: 1,
        }
    }
}
