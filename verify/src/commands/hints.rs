//! Warnings about input that is valid but probably wrong.

use super::print_message;
use finray_files::observations::RefusedImage;
use finray_files::{Elsewhere, name_of, of_another_finger};
use finray_model::keys::FINGER;
use finray_model::observation::Observation;
use finray_model::scene::SceneWarning;
use finray_model::{Finger, Scene};
use std::path::Path;

/// Prints the warnings about a scene.
pub fn of_scene(path: &Path, scene: &Scene) {
    of_scene_without(path, scene, |_| false);
}

/// Prints the warnings about a scene, except those that do not matter to the command.
pub fn of_scene_without(path: &Path, scene: &Scene, no_matter: impl Fn(&SceneWarning) -> bool) {
    for warning in scene.warnings().iter().filter(|warning| !no_matter(warning)) {
        print_message(format_args!("warning: {}: {warning}", name_of(path)));
    }
}

/// Says that a simulated study neglects uncertain thicknesses.
pub fn of_neglected_thickness(scene: &Scene) {
    if scene.thickness_error.sd > 0.0 {
        print_message(format_args!(
            "note: {} is neglected: it enters `finray sense`, `finray live` and `finray setup`",
            FINGER.thickness_sigma.path()
        ));
    }
}

/// Warns of a displacement file whose undeformed nodes differ from those of `finger`.
pub fn of_displacements(path: &Path, text: &str, finger: &Finger) {
    if let Some(Elsewhere { node, stated, own }) = of_another_finger(path, text, finger) {
        print_message(format_args!(
            "warning: {}: undeformed node {node} is at ({:.2}, {:.2}) mm in the file, and at ({:.2}, {:.2}) mm in the scene: are these displacements \
             of another finger?",
            name_of(path),
            stated.x,
            stated.y,
            own.x,
            own.y
        ));
    }
}

/// Says that the markers of a file were located with another scene, and what follows.
pub fn of_other_scene(path: &Path, seen: &Observation, scene: &Scene) {
    if let Some(change) = seen.change(scene).filter(|_| seen.renewed(scene).is_ok()) {
        let how = match change.pose || change.lens {
            true => "its markers are located again from u_px, v_px",
            false => "its displacements are from this scene's finger",
        };
        print_message(format_args!("note: {}: located with another {change} than the scene's: {how}", name_of(path)));
    }
}

/// Warns of images that `finray locate` refused; the running command leaves these images out.
pub fn of_refused(refused: &[RefusedImage]) {
    for RefusedImage { image, reason } in refused {
        print_message(format_args!("warning: {image} is left out, because `finray locate` refused it: {reason}"));
    }
}
