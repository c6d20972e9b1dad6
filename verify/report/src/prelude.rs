//! What every section is written with: tables and their files, blocks of the page, sentences, and what they speak of.

pub(crate) use crate::dataset::{Columns, Dataset, Format};
pub(crate) use crate::page::{Block, Cell, Column, Figure, Section, Shade, Table, details, text};
pub(crate) use crate::words::{paragraph, say};
pub(crate) use crate::{ReportError, Results};
pub(crate) use finray_model::estimators::EstimatorId;
pub(crate) use finray_studies::study::Study;
pub(crate) use finray_studies::truths::TruthId;
pub(crate) use minijinja::{Value, context};
