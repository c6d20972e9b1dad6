//! The finger of the scene: a drawing with numbered key nodes, and its dimensions.

use super::drawings;
use crate::prelude::*;
use finray_model::finger::{RibPositions, Strip};

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
    let (ribs, are_even) = match &d.ribs.positions {
        RibPositions::Count(count) => (*count, true),
        RibPositions::Positions(places) => (places.len(), false),
    };
    let of = |strip: Strip| {
        context! { thickness_mm => strip.thickness_mm, tip_mm => strip.tip_thickness_mm, modulus_mpa => strip.youngs_modulus_mpa }
    };
    let numbers = context! {
        base_width_mm => d.base_width_mm,
        depth_mm => d.depth_mm,
        front_mm => finger.plate_length_mm(Plate::Front),
        back_mm => finger.plate_length_mm(Plate::Back),
        front => of(d.front),
        back => of(d.back),
        strip => d.ribs.strip.map(of),
        ribs_differ => d.ribs.thicknesses_mm.is_some(),
        ribs,
        are_even,
    };
    let mut facts = vec![say("finger.sides", Some(numbers.clone()))?, say("finger.sections", Some(numbers))?];
    if study.is_paper {
        facts.push(say("finger.assumed", Some(context! {}))?);
    }
    let blocks = vec![
        Block::Figure(Figure::wide(
            drawings::finger(study)?,
            "Key nodes from the back base over the tip to the front base; a positive force pushes along its arrow.",
            CSV,
        )),
        Block::List { items: facts.into_iter().flatten().collect() },
    ];
    Ok(Some(Section::new("finger", "The finger", blocks)))
}
