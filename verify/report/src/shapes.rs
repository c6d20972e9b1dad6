//! Deformed shapes under a few forces, and whether the beam model is valid for them.

use super::drawings;
use super::format::percent;
use crate::prelude::*;
use finray_model::validity::{FibreStrain, LARGEST_SHEAR_SHARE, StrainLimits, Validity};
use finray_studies::experiments::shapes::{BentFinger, TouchedFinger};

const CSV: &str = "shapes.csv";
const VALIDITY_CSV: &str = "validity.csv";
/// File with the shapes of the interactive section.
pub(super) const TOUCHED_CSV: &str = "touched.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    let lines = study.bent.iter().flat_map(|bent| bent.lines.iter().enumerate().map(move |(n, line)| (bent, n, line)));
    let points = lines.flat_map(|(bent, n, line)| line.iter().map(move |point| (bent, n + 1, point)));
    let columns = Columns::<(&BentFinger, usize, &Vector)>::new()
        .file("shape", |(bent, ..)| bent.label.clone())
        .file("line", |(_, line, _)| *line)
        .file("x_mm", |(.., point)| point.x)
        .file("y_mm", |(.., point)| point.y);
    let touched = study.touched.iter().flat_map(|touched| {
        touched.shape.motions().iter().map(move |m| (touched, m.node.0, m.position + m.displacement))
    });
    let of_touched = Columns::<(&TouchedFinger, usize, Vector)>::new()
        .file("truth", |(shape, ..)| shape.truth.name())
        .file("loaded_node", |(shape, ..)| shape.node)
        .file("angle_deg", |(shape, ..)| shape.angle_deg)
        .file("force_n", |(shape, ..)| shape.force_n)
        .file("node", |(_, node, _)| *node)
        .file("x_mm", |(.., at)| at.x)
        .file("y_mm", |(.., at)| at.y);
    vec![
        Dataset::new(CSV, &columns, points).csv_alone(),
        Dataset::new(TOUCHED_CSV, &of_touched, touched).csv_alone(),
        Dataset::new(VALIDITY_CSV, &validity_columns(study.strain_limits), corotational(study)).csv_alone(),
    ]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let (mut blocks, force_n) = (Vec::new(), study.forces.drawn_n());
    if study.bent.is_empty() {
        blocks.push(text(format!("The finger cannot carry {force_n} N at any of the tested nodes.")));
    } else {
        let caption =
            format!("At rest and under {force_n} N along the normal: linear (dotted) and co-rotational (solid).");
        blocks.push(Block::Figure(Figure::wide(drawings::bent(study)?, caption, CSV)));
        blocks.extend(validity(study).map(text));
        let columns = validity_columns(study.strain_limits);
        let table = columns.table(
            "Largest strain, and share of shear, of each co-rotational shape",
            VALIDITY_CSV,
            corotational(study),
        );
        blocks.push(details("Strain and shear", vec![Block::Table(table)]));
    }
    Ok(Some(Section::new("shapes", "How the finger bends", blocks)))
}

fn corotational(study: &Study) -> impl Iterator<Item = &BentFinger> {
    study.bent.iter().filter(|bent| bent.kinematics == Kinematics::Corotational)
}

fn validity_columns<'s>(limits: StrainLimits) -> Columns<'s, &'s BentFinger> {
    let largest = move |bent: &&'s BentFinger| -> Option<&'s FibreStrain> { bent.validity.largest_strain(&limits) };
    Columns::<&BentFinger>::new()
        .both("shape", "shape", Format::Words, |bent| bent.label.clone())
        .both("largest_strain", "largest strain", Format::Percent, move |bent| largest(bent).map(|at| at.strain))
        .both("strain_in", "strain in", Format::Words, move |bent| largest(bent).map(|at| at.member.to_string()))
        .both("strain_at_mm", "strain at, mm", Format::Fixed(1), move |bent| largest(bent).map(|at| at.at_mm))
        .both("shear_share", "shear share", Format::Percent, |bent| bent.validity.shear_share)
        .both("shear_in", "shear in", Format::Words, |bent| bent.validity.shear_at.map(|member| member.to_string()))
}

/// The fibre strain that is largest relative to the limit of its material, over all drawn co-rotational shapes.
fn most_strained(study: &Study) -> Option<&FibreStrain> {
    let limits = &study.strain_limits;
    let share = |at: &FibreStrain| at.strain / limits.of(at.member.part);
    let strains = corotational(study).filter_map(|bent| bent.validity.largest_strain(limits));
    strains.max_by(|a, b| share(a).total_cmp(&share(b)))
}

fn most_sheared(study: &Study) -> Option<&Validity> {
    corotational(study).map(|bent| &bent.validity).max_by(|a, b| a.shear_share.total_cmp(&b.shear_share))
}

/// Sentence that compares the strains of the drawn co-rotational shapes with the limits of the beam model.
fn validity(study: &Study) -> Option<String> {
    let (strain, sheared) = (most_strained(study)?, most_sheared(study)?);
    let member = sheared.shear_at.map_or_else(String::new, |member| format!(", mostly in {member}"));
    let shear = percent(sheared.shear_share);
    let [strain_limit, shear_limit] = [study.strain_limits.of(strain.member.part), LARGEST_SHEAR_SHARE].map(percent);
    Some(format!(
        "Largest fibre strain: {strain}. Shear, which the beams neglect, would increase the displacement of the loads by up to {shear}{member}. \
         Limits: {strain_limit} for strain, {shear_limit} for shear."
    ))
}

/// Texts about the limits of the beam model that the drawn shapes exceed; empty if they exceed none.
pub(super) fn beyond_limits(study: &Study) -> Vec<String> {
    let strain = most_strained(study).map(|at| (at.strain, study.strain_limits.of(at.member.part)));
    let strain = strain.filter(|(strain, limit)| strain > limit);
    let strain = strain.map(|(strain, limit)| format!("a strain of {} (limit {})", percent(strain), percent(limit)));
    let shear = most_sheared(study).map(|validity| validity.shear_share).filter(|share| *share > LARGEST_SHEAR_SHARE);
    let shear = shear.map(|share| {
        format!(
            "shear that increases displacements by up to {} (limit {})",
            percent(share),
            percent(LARGEST_SHEAR_SHARE)
        )
    });
    let depth = most_sheared(study).map(|validity| validity.depth_ratio).filter(|ratio| *ratio < 1.0);
    let depth = depth.map(|_| "members that are less deep than thick, which may buckle out of the plane".to_owned());
    [strain, shear, depth].into_iter().flatten().collect()
}
