//! Common imports of the commands.

pub(super) use super::parse::{degrees_between, listed, not_negative, positive, share};
pub(super) use super::scenes::{camera_and_markers, camera_of, markers_of, networks_of, scene_or_papers};
pub(super) use super::{
    Failure, bad_input, count, figure_path, hints, not_computed, path_beside_figure, print_message, progress_bar,
    require_one_standard_input, require_separate_files, summary,
};
pub(super) use finray_files::{
    FileError, csv_text, is_standard_stream, is_stream, load_image, load_scene, name_of, require_folder,
    require_writable, write_all_or_nothing, write_file, write_folder,
};
pub(super) use finray_model::estimators::EstimatorId;
pub(super) use finray_model::estimators::network::Networks;
pub(super) use finray_model::{Finger, NodeId, Scene};
pub(super) use finray_studies::truths::TruthId;
pub(super) use serde::Serialize;
pub(super) use std::path::{Path, PathBuf};
