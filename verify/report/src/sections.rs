//! All sections of the report. Each section contributes to the page, the CSV files and the summary.

use super::dataset::Dataset;
use super::page::{First, Page, PageLink, Section};
use super::{
    ReportError, Results, answers, camera, causes, changes, checks, contact_scenes, estimators, explore, finger, grasp,
    gripper_tests, maps, measured, networks, pairs, places, push, recorded, scatter, shapes, times, trust,
};

/// A section: its page, a function for its content on this page (`None` if the scene has no such study), and a function for its data.
struct Entry(On, fn(Results) -> Result<Option<Section>, ReportError>, for<'s> fn(Results<'s>) -> Vec<Dataset<'s>>);

/// A page of the report.
#[derive(Clone, Copy, PartialEq)]
enum On {
    Index,
    Measured,
    Maps,
    Objects,
    Camera,
    Speed,
    Checks,
    Paper,
    Own,
}

/// Pages in the order of their navigation, each with its file and its heading.
const PAGES: [(On, &str, &str); 9] = [
    (On::Index, "index.html", "Summary"),
    (On::Own, "your-finger.html", "Edit the finger"),
    (On::Measured, "measured.html", "Photographs"),
    (On::Maps, "maps.html", "Maps"),
    (On::Objects, "objects.html", "Objects"),
    (On::Camera, "camera.html", "Camera"),
    (On::Speed, "speed.html", "Speed and networks"),
    (On::Checks, "checks.html", "Checks"),
    (On::Paper, "paper.html", "The paper"),
];

/// Every section, in the order of the page. A new section needs its experiment, its file in this folder, and a row here.
const SECTIONS: &[Entry] = &[
    Entry(On::Index, places::section, places::datasets),
    Entry(On::Index, changes::section, changes::datasets),
    Entry(On::Index, finger::section, finger::datasets),
    Entry(On::Index, grasp::section, grasp::datasets),
    Entry(On::Index, causes::section, causes::datasets),
    Entry(On::Index, estimators::section, estimators::datasets),
    Entry(On::Measured, measured::section, measured::datasets),
    Entry(On::Maps, maps::section, maps::datasets),
    Entry(On::Maps, pairs::section, pairs::datasets),
    Entry(On::Objects, contact_scenes::section, contact_scenes::datasets),
    Entry(On::Objects, grasp::all, |_| Vec::new()),
    Entry(On::Objects, grasp::rates::section, grasp::rates::datasets),
    Entry(On::Camera, camera::section, camera::datasets),
    Entry(On::Speed, recorded::speed, |_| Vec::new()),
    Entry(On::Camera, scatter::section, scatter::datasets),
    Entry(On::Speed, recorded::convergence, |_| Vec::new()),
    Entry(On::Speed, times::section, times::datasets),
    Entry(On::Speed, networks::section, networks::datasets),
    Entry(On::Checks, checks::section, checks::datasets),
    Entry(On::Checks, shapes::section, shapes::datasets),
    Entry(On::Checks, recorded::lattice, |_| Vec::new()),
    Entry(On::Checks, recorded::hard_cases, |_| Vec::new()),
    Entry(On::Paper, recorded::claims, |_| Vec::new()),
    Entry(On::Paper, recorded::table_two, |_| Vec::new()),
    Entry(On::Paper, gripper_tests::section, gripper_tests::datasets),
    Entry(On::Paper, recorded::table_one, |_| Vec::new()),
    Entry(On::Paper, recorded::twin, |_| Vec::new()),
    Entry(On::Paper, recorded::causes, |_| Vec::new()),
];

/// Datasets of all sections.
pub(super) fn datasets(results: Results) -> Result<Vec<Dataset>, ReportError> {
    let computed = SECTIONS.iter().flat_map(|Entry(.., datasets)| datasets(results));
    let all = trust::datasets(results.study).into_iter().chain(computed);
    Ok(all.chain(recorded::datasets(results)?).collect())
}

/// All pages with their sections, each page as file name and content; the first page comes first.
pub(super) fn pages(results: Results) -> Result<Vec<(&'static str, Page)>, ReportError> {
    let study = results.study;
    let mut filled = Vec::new();
    for (on, file, heading) in PAGES {
        let of_page = SECTIONS.iter().filter(|Entry(of, ..)| *of == on);
        let sections = of_page.filter_map(|Entry(_, section, _)| section(results).transpose());
        let sections = sections.collect::<Result<Vec<_>, _>>()?;
        // A page of results is left out if the scene has no study for it.
        if matches!(on, On::Index | On::Own) || !sections.is_empty() {
            filled.push((on, file, heading, sections));
        }
    }
    let link = |(_, file, heading, _): &(On, &str, &str, Vec<Section>)| PageLink {
        file: (*file).to_owned(),
        heading: (*heading).to_owned(),
        is_this: false,
    };
    let links: Vec<PageLink> = filled.iter().map(link).collect();
    let pushed = push::of(study)?;
    let page = |(on, file, heading, sections): (On, &'static str, &str, Vec<Section>)| {
        let is_first = on == On::Index;
        let pages = links.iter().map(|link| PageLink { is_this: link.file == file, ..link.clone() }).collect();
        let page = Page {
            title: if is_first {
                let finger = match study.is_paper {
                    true => "the finger of Xu et al.".to_owned(),
                    false => format!("the finger \"{}\"", study.scene),
                };
                let simulated = if study.measured.is_none() { " (simulation)" } else { "" };
                format!("Where {finger} senses forces{simulated}")
            } else {
                format!("{heading}: finger \"{}\"", study.scene)
            },
            first: is_first.then(|| first(results)).transpose()?,
            push: match on {
                On::Index => Some(pushed.clone()),
                On::Own => Some(push::edited(&pushed, study)),
                _ => None,
            },
            explore: (on == On::Maps).then(|| explore::data(results)),
            has_film: !study.grasps.is_empty() && matches!(on, On::Index | On::Objects),
            sections,
            pages,
            footer: format!(
                "Made by finray {}. Every figure names its data file. These files and summary.json are in the folder of this page.",
                super::VERSION
            ),
        };
        Ok((file, page))
    };
    filled.into_iter().map(page).collect()
}

fn first(results: Results) -> Result<First, ReportError> {
    let study = results.study;
    Ok(First {
        headline: answers::headline(study),
        verdict: answers::verdict(study),
        answers: answers::answers(study),
        caveat: answers::caveat(study),
        lead: trust::figures(results)?,
        lead_caption: trust::caption(study),
        lead_csv: trust::CSV.to_owned(),
    })
}
