//! The page, section by section.

use super::page::{Block, Figure, Page, Section};
use super::{
    ReportError, Summary, causes, claims, contact_scenes, convergence, directions, drawings, hard_cases, lattice,
    networks, pairs, scatter, speed_error, table_two, tables, twin, words,
};
use crate::map::AccuracyMap;
use crate::study::{DRAWN_FORCE_N, MAP_FORCES_N, Study};
use finray_model::finger::{Plate, RibPlaces};

pub(super) fn text(paragraph: impl Into<String>) -> Block {
    Block::Text { paragraph: paragraph.into() }
}

pub(super) fn section(id: &str, heading: &str, blocks: Vec<Block>) -> Section {
    Section { id: id.to_owned(), heading: heading.to_owned(), blocks }
}

/// The whole page.
pub(super) fn page(study: &Study, summary: &Summary) -> Result<Page, ReportError> {
    let mut sections = vec![maps(study, summary)?];
    sections.extend(causes::section(study)?);
    sections.extend(claims::section(study));
    if !study.tables_one.is_empty() {
        sections.push(table_one(study)?);
    }
    sections.extend(twin::section(study)?);
    sections.extend(scatter::section(study));
    sections.extend(pairs::section(study)?);
    sections.extend(directions::section(study)?);
    sections.extend(table_two::section(study));
    sections.extend(networks::section(study)?);
    sections.extend(lattice::section(study)?);
    sections.extend(contact_scenes::section(study)?);
    sections.extend(speed_error::section(study)?);
    sections.push(shapes(study)?);
    sections.push(convergence::section(study)?);
    sections.push(checks(study));
    if !study.hard_cases.is_empty() {
        sections.push(hard_cases::section(study));
    }
    sections.push(finger(study)?);
    Ok(Page {
        title: format!("Where the finger \"{}\" can feel", study.scene),
        subtitle: "Force sensing through the finger's own deformation: accuracy maps, cross-checks and shapes"
            .to_owned(),
        verdict: summary.verdict.clone(),
        sections,
        footer: format!(
            "Made by finray {}. Every figure names its data; summary.json beside this page has all numbers.",
            summary.version
        ),
    })
}

fn map_figure(study: &Study, map: &AccuracyMap, force_n: Option<f64>) -> Result<Figure, ReportError> {
    let truth = match map.truth.as_str() {
        "linear" => "the linear finger",
        _ => "the large-rotation finger (fine mesh)",
    };
    let noise = match map.noise_mm {
        0.0 => "without noise".to_owned(),
        noise => format!("with {noise} mm noise a coordinate, {} pictures a cell", map.request.noise_pictures),
    };
    let force = force_n.map_or_else(|| "mean over all forces".to_owned(), |f| format!("{f} N"));
    Ok(Figure {
        svg: drawings::map_picture(&study.finger, map, force_n)?,
        caption: format!("Sensed by linear least squares on {truth}, {noise}; {force}."),
        csv: Some(tables::map_csv_name(map)),
        wide: false,
    })
}

fn maps(study: &Study, summary: &Summary) -> Result<Section, ReportError> {
    // Large rotation first: it is what a real finger does.
    let of = |truth: &'static str| study.maps.iter().filter(move |map| map.truth == truth);
    let ordered: Vec<&AccuracyMap> = of("corotational").chain(of("linear")).collect();
    let pictures = |force_n| ordered.iter().map(|map| map_figure(study, map, force_n)).collect::<Result<_, _>>();
    let forces = MAP_FORCES_N.map(|f| f.to_string()).join(", ");
    let mut blocks = vec![
        text(
            "A force is put on the true finger at a known place and in a known direction; its size is sensed by linear \
             least squares from the displacements of the key nodes. Colour is the error |sensed / true - 1|, with lines \
             at 10 and 25 %, the two shades of the paper's Table I. Directions are counted from the front plate's \
             undeformed inward normal, positive towards the tip.",
        ),
        Block::Figures { figures: pictures(Some(DRAWN_FORCE_N))? },
    ];
    let lines = of("corotational")
        .map(|map| {
            Ok(Figure {
                svg: drawings::errors_along_the_normal(map)?,
                caption: "The same along the normal, for each force.".to_owned(),
                csv: Some(tables::map_csv_name(map)),
                wide: false,
            })
        })
        .collect::<Result<Vec<_>, ReportError>>()?;
    blocks.push(Block::Figures { figures: lines });
    blocks.push(Block::Table(tables::maps(summary)));
    blocks.push(Block::Details {
        summary: format!("Maps of the mean over {forces} N"),
        blocks: vec![Block::Figures { figures: pictures(None)? }],
    });
    Ok(section("maps", "Where sensing fails", blocks))
}

fn table_one(study: &Study) -> Result<Section, ReportError> {
    let factors: Vec<_> =
        study.tables_one.iter().map(|t| format!("{:.4} at {} deg", t.modulus_factor, t.angle_deg)).collect();
    let mut blocks = vec![text(format!(
        "The paper hangs weights of 50 to 300 g (g = 9.80665 m/s^2) on single nodes and senses them with the linear model, \
         whose Young's modulus is calibrated first on nodes 17, 19 and 21 (eq. (11)). Here the true finger is the \
         large-rotation finger without noise. The paper says that the weights pull vertically, not how the finger lies: \
         several directions are assumed (10.9 deg is vertical for a level finger axis). Calibrated modulus over the true \
         one: {}.",
        factors.join(", ")
    ))];
    blocks.extend(words::table_one(study).map(text));
    blocks.push(Block::Figure(Figure {
        svg: drawings::table_one(&study.tables_one)?,
        caption: "Mean error at six nodes: the paper's measurement and what large rotation alone would cause."
            .to_owned(),
        csv: Some(tables::TABLE_ONE_CSV.to_owned()),
        wide: true,
    }));
    blocks.push(Block::Table(tables::table_one(&study.tables_one)));
    Ok(section("table-one", "The paper's Table I", blocks))
}

fn shapes(study: &Study) -> Result<Section, ReportError> {
    let blocks = if study.bent.is_empty() {
        vec![text(format!("The finger cannot carry {DRAWN_FORCE_N} N at any of the nodes tried."))]
    } else {
        vec![Block::Figure(Figure {
            svg: drawings::bent(study)?,
            caption: format!(
                "At rest and under {DRAWN_FORCE_N} N along the normal: dotted as linear theory has it, solid with large \
                 rotations."
            ),
            csv: Some(tables::SHAPES_CSV.to_owned()),
            wide: true,
        })]
    };
    Ok(section("shapes", "How the finger bends", blocks))
}

fn checks(study: &Study) -> Section {
    let mut blocks = Vec::new();
    if !study.is_paper {
        blocks.push(text(
            "Reference values of other programs (OpenSees) and the paper's Table I exist for the paper's finger alone, and \
             so do the spring lattice and the hard cases; they are left out for this scene.",
        ));
    }
    blocks.push(Block::Table(tables::checks_by_source(&study.checks)));
    blocks.push(Block::Details {
        summary: format!("All {} of them", study.checks.len()),
        blocks: vec![Block::Table(tables::checks(&study.checks))],
    });
    blocks.push(Block::Details {
        summary: "Where a difference is expected".to_owned(),
        blocks: vec![Block::Table(tables::comparisons(&study.comparisons))],
    });
    section("checks", "Cross-checks", blocks)
}

fn finger(study: &Study) -> Result<Section, ReportError> {
    let finger = &study.finger;
    let d = finger.description();
    let ribs = match &d.ribs.places {
        RibPlaces::Count(count) => format!("{count} evenly spaced ribs"),
        RibPlaces::Positions(places) => format!("{} ribs at given places", places.len()),
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
            "Assumed: base width and depth. The paper gives them in a figure that was not at hand; 58 mm fits its fine \
             mesh of 684 nodes and 695 elements of about 1 mm, the base line included. Displacements are proportional to \
             1 / depth."
                .to_owned(),
        );
    }
    Ok(section(
        "finger",
        "The finger",
        vec![
            Block::Figure(Figure {
                svg: drawings::finger(study)?,
                caption:
                    "Key nodes, numbered from the back base over the tip to the front base. The arrows show what an \
                          angle means: a positive force pushes along its arrow."
                        .to_owned(),
                csv: Some(tables::FINGER_CSV.to_owned()),
                wide: true,
            }),
            Block::List { items: facts },
        ],
    ))
}
