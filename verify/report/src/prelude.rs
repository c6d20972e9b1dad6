//! Common imports of the sections: tables and files, blocks of the page, drawings, and types of the studies.

pub(crate) use crate::dataset::{Columns, Dataset, Format};
pub(crate) use crate::format::Span;
pub(crate) use crate::page::{Block, Cell, Figure, Section, Shade, Table, details, text};
pub(crate) use crate::{ReportError, Results};
pub(crate) use finray_figures::{Axis, Cells, Chart, Class, Dash, FigureError, Frame, Hue, Map, Point, Series};
pub(crate) use finray_model::estimators::EstimatorId;
pub(crate) use finray_model::finger::Plate;
pub(crate) use finray_model::{Finger, Kinematics, NodeId, Vector};
pub(crate) use finray_studies::check::{Check, worst};
pub(crate) use finray_studies::sampling::map::AccuracyMap;
pub(crate) use finray_studies::sampling::scatter::{Counts, Scatter, ScatterRow};
pub(crate) use finray_studies::sampling::sweep::{CellState, MapCell};
pub(crate) use finray_studies::sampling::trust::TrustShare;
pub(crate) use finray_studies::settings::{TRUSTED_ERROR, TWO_SIDED_95};
pub(crate) use finray_studies::study::Study;
pub(crate) use finray_studies::truths::TruthId;
