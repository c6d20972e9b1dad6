//! The page, section by section.

use super::page::{Block, Figure, Page, Question, Section};
use super::{
    ReportError, Summary, causes, claims, contact_scenes, convergence, coverage, directions, displacement_noise,
    drawings, hard_cases, lattice, maps, networks, pairs, scatter, speed_error, table_two, tables, twin, verdict,
    words,
};
use crate::claims::Claim;
use crate::settings::DRAWN_FORCE_N;
use crate::study::Study;
use finray_model::Kinematics;
use finray_model::finger::{Plate, RibPlaces};
use finray_model::validity::{LARGEST_SHEAR_SHARE, LARGEST_STRAIN, StrainLimits};

pub(super) fn text(paragraph: impl Into<String>) -> Block {
    Block::Text { paragraph: paragraph.into() }
}

pub(super) fn section(id: &str, heading: &str, blocks: Vec<Block>) -> Section {
    Section { id: id.to_owned(), heading: heading.to_owned(), says: Vec::new(), blocks }
}

fn question(id: &str, heading: &str, sections: Vec<Section>) -> Question {
    Question { id: id.to_owned(), heading: heading.to_owned(), sections }
}

/// The whole page.
pub(super) fn page(study: &Study, claimed: &[Claim], summary: &Summary) -> Result<Page, ReportError> {
    let mut feels = vec![maps::section(study, summary)?];
    feels.extend(coverage::section(study));
    feels.extend(scatter::section(study));
    feels.extend(displacement_noise::section(study));
    feels.extend(pairs::section(study)?);
    feels.extend(directions::section(study)?);
    feels.extend(table_two::section(study));
    feels.extend(contact_scenes::section(study)?);

    let mut why: Vec<Section> = causes::section(study)?.into_iter().collect();
    why.push(shapes(study)?);
    if !study.tables_one.is_empty() {
        why.push(table_one(study)?);
    }
    why.extend(twin::section(study)?);

    let costs = speed_error::section(study)?.into_iter().chain([convergence::section(study)?]);
    let costs = costs.chain(networks::section(study)?).collect();

    let mut physics = vec![checks(study)];
    physics.extend(lattice::section(study)?);
    if !study.hard_cases.is_empty() {
        physics.push(hard_cases::section(study));
    }
    physics.extend(claims::section(claimed));
    physics.push(finger(study)?);

    let mut questions = vec![
        question("where", "Where", feels),
        question("why", "Why", why),
        question("cost", "What it costs", costs),
        question("physics", "Is the physics right", physics),
    ];
    for finding in words::findings(study) {
        let mut sections = questions.iter_mut().flat_map(|question| &mut question.sections);
        if let Some(section) = sections.find(|section| section.id == finding.section) {
            section.says.push(finding.sentence);
        }
    }
    Ok(Page {
        title: format!("Where the finger \"{}\" can feel", study.scene),
        subtitle: format!(
            "Force sensing through the finger's own deformation: where it can be trusted, why not elsewhere, at which cost. {}",
            words::checks_in_short(study)
        ),
        verdict: verdict::sentences(study),
        lead: verdict::lead(study)?,
        questions,
        footer: format!(
            "Made by finray {}. Every figure names its data; summary.json beside this page has all numbers.",
            summary.version
        ),
    })
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
        .into_iter()
        .chain(validity(study).map(text))
        .collect()
    };
    Ok(section("shapes", "How the finger bends", blocks))
}

/// What the drawn co-rotational shapes ask of the beam model.
fn validity(study: &Study) -> Option<String> {
    let shapes = || study.bent.iter().filter(|bent| bent.kinematics == Kinematics::Corotational);
    let strains = shapes().filter_map(|bent| bent.validity.largest_strain(&StrainLimits::default()));
    let strain = strains.max_by(|a, b| a.strain.total_cmp(&b.strain))?;
    let sheared = shapes().max_by(|a, b| a.validity.shear_share.total_cmp(&b.validity.shear_share))?;
    let member = sheared.validity.shear_at.map_or_else(String::new, |member| format!(", most of it in {member}"));
    Some(format!(
        "The largest strain of a fibre in these co-rotational shapes is {strain}. Shear, which Euler-Bernoulli beams leave out, would let the loads move by \
         up to {} more{member}. Beams are taken up to {} of strain and {} of shear.",
        tables::percent(sheared.validity.shear_share),
        tables::percent(LARGEST_STRAIN),
        tables::percent(LARGEST_SHEAR_SHARE),
    ))
}

fn checks(study: &Study) -> Section {
    let mut blocks = Vec::new();
    if !study.is_paper {
        blocks.push(text(
            "Reference values of other programs (OpenSees) and the paper's Table I exist for the paper's finger alone, and \
             so do the spring lattice and the hard cases; they are left out for this scene.",
        ));
    }
    blocks.push(text(
        "External references are figures of another program: OpenSees, MuJoCo, and shapes at which rapier2d comes to rest. Analytical ones \
         are closed forms, theoretical orders and solutions of the literature. Internal ones are our own: another formulation or mesh, \
         a balance, a bound, the true forces of a simulation. OpenSees, MuJoCo and the lattice are given the same EA and EI of the same \
         sections as the beams: they verify solvers and kinematics, not that Euler-Bernoulli beams describe a real finger.",
    ));
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
