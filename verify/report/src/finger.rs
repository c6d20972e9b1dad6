//! The finger of the scene: a drawing with numbered key nodes, and its dimensions.

use super::drawings;
use super::format::thickness;
use crate::prelude::*;
use finray_model::finger::{FingerDescription, RibPositions, Strip};

const CSV: &str = "finger.csv";
/// Assumed dimensions of the paper's finger.
const ASSUMED: &str = "Assumed: base width and depth, which the paper gives only in a figure that was not available. A base width of 58 mm fits the paper's \
                       fine mesh of 684 nodes. Displacements depend on force / depth.";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    let finger = &study.finger;
    let nodes =
        finger.plate_nodes(Plate::Back).into_iter().chain(finger.plate_nodes(Plate::Front).into_iter().rev().skip(1));
    let columns = Columns::<NodeId>::new()
        .file("node", |node| node.0)
        .file("x_mm", |node| finger.position(*node).x)
        .file("y_mm", |node| finger.position(*node).y)
        .file("s_front_mm", |node| finger.front_position_mm(*node));
    vec![Dataset::new(CSV, &columns, nodes).csv_alone()]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let mut facts = vec![sides(&study.finger), members(study.finger.description())];
    if study.is_paper {
        facts.push(ASSUMED.to_owned());
    }
    let caption = "Dimensions are those of the middle lines. Key nodes are numbered from the back base over the tip to the front \
            base, ribs from the base. An arrow shows the direction of a positive force; angles count from the front plate's normal, positive \
            towards the tip.";
    let figure = Figure::wide(drawings::finger(study)?, caption, CSV);
    let blocks = vec![Block::Figure(figure), Block::List(facts)];
    Ok(Some(Section::new("finger", "The finger", blocks)))
}

/// Lengths of the finger's sides, and its depth.
fn sides(finger: &Finger) -> String {
    let FingerDescription { base_width_mm, depth_mm, .. } = finger.description();
    let [front_mm, back_mm] = [Plate::Front, Plate::Back].map(|plate| finger.plate_length_mm(plate));
    format!("Base width {base_width_mm} mm, front plate {front_mm} mm, back plate {back_mm} mm, depth {depth_mm} mm.")
}

/// Thickness and modulus of plates and ribs, and the number of ribs.
fn members(FingerDescription { front, back, ribs, .. }: &FingerDescription) -> String {
    let (count, spaced) = match &ribs.positions {
        RibPositions::Count(count) => (*count, ", evenly spaced"),
        RibPositions::Positions(places) => (places.len(), " at given positions"),
    };
    let strip = ribs.strip.map_or_else(
        || "undeformable".to_owned(),
        |Strip { thickness_mm, youngs_modulus_mpa, .. }| {
            let up_to = if ribs.thicknesses_mm.is_some() { "up to " } else { "" };
            format!("{up_to}{thickness_mm} mm thick, {youngs_modulus_mpa} MPa")
        },
    );
    format!(
        "Front plate {} mm thick, {} MPa; back plate {} mm, {} MPa; {count} ribs{spaced}, {strip}.",
        thickness(front),
        front.youngs_modulus_mpa,
        thickness(back),
        back.youngs_modulus_mpa
    )
}
