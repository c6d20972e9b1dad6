//! The finger: its numbered key nodes and its dimensions.

use super::dataset::{Columns, Dataset};
use super::page::{Block, Figure, Section};
use super::{ReportError, Results, drawings};
use finray_model::NodeId;
use finray_model::finger::{Plate, RibPositions};

const CSV: &str = "finger.csv";

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
    let finger = &study.finger;
    let d = finger.description();
    let ribs = match &d.ribs.positions {
        RibPositions::Count(count) => format!("{count} ribs, evenly spaced"),
        RibPositions::Positions(places) => format!("{} ribs at given positions", places.len()),
    };
    let mut facts = vec![
        format!(
            "Base width {} mm, front plate {} mm, back plate {} mm, depth {} mm.",
            d.base_width_mm,
            finger.plate_length_mm(Plate::Front),
            finger.plate_length_mm(Plate::Back),
            d.depth_mm
        ),
        format!(
            "Front plate {} mm thick, {} MPa; back plate {} mm, {} MPa; {ribs}{}.",
            d.front.thickness_mm,
            d.front.youngs_modulus_mpa,
            d.back.thickness_mm,
            d.back.youngs_modulus_mpa,
            d.ribs.strip.map_or(", undeformable".to_owned(), |s| format!(
                ", {} mm thick, {} MPa",
                s.thickness_mm, s.youngs_modulus_mpa
            ))
        ),
    ];
    if study.is_paper {
        facts.push(
            "Assumed: base width and depth, given in a figure that was not at hand; 58 mm fits the paper's fine mesh of 684 nodes. \
             Displacements are \
             proportional to 1 / depth."
                .to_owned(),
        );
    }
    let blocks = vec![
        Block::Figure(Figure::wide(
            drawings::finger(study)?,
            "Key nodes from the back base over the tip to the front base; a positive force pushes along its arrow.",
            CSV,
        )),
        Block::List { items: facts },
    ];
    Ok(Some(Section::new("finger", "The finger", blocks)))
}
