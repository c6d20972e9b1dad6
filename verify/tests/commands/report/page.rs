//! The report's pages as files: their links, sizes, drawings and verdict.

use super::shared::*;
use crate::kit::*;

#[test]
fn every_file_that_a_page_names_is_there() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let (names, pages) = (report.names(), report.page_names());
        assert!(pages.len() >= 5 && pages[0] == "index.html" && names.contains(&"summary.json".to_owned()));
        let mut all = Vec::new();
        for page in &pages {
            let links = report.links(page);
            // Every page links to every other page.
            assert!(pages.iter().all(|other| links.contains(other)), "{page}: {links:?}");
            for link in links.into_iter().filter(|link| !link.starts_with("https://")) {
                let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
                let file = if file.is_empty() { page } else { file };
                assert!(names.contains(&file.to_owned()), "{file} is not in {names:?}");
                assert!(anchor.is_empty() || report.read(file).contains(&format!("id=\"{anchor}\"")), "{page}: {link}");
                if file.ends_with(".csv") {
                    assert!(!Csv::of(&report.read(file)).rows.is_empty(), "{file}");
                }
                all.push(file.to_owned());
            }
        }
        // Every table in the folder is named on a page.
        for name in names.iter().filter(|name| name.ends_with(".csv")) {
            assert!(all.contains(name), "{name} is named nowhere");
        }
        // The folder contains no temporary files.
        assert!(names.iter().all(|name| !name.starts_with('.')), "{names:?}");
    }
}

#[test]
fn a_page_needs_nothing_but_itself() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        for name in report.page_names() {
            // The names of the SVG and XHTML namespaces look like addresses, but the page loads no data from them.
            let page = report
                .read(&name)
                .replace("http://www.w3.org/2000/svg", "")
                .replace("http://www.w3.org/1999/xhtml", "");
            for outside in ["http://", "src=", "@import", "url(http", "<link", "<iframe", "import(", "fetch("] {
                assert!(!page.contains(outside), "{name}: {outside}");
            }
            assert!(page.starts_with("<!DOCTYPE html>") || page.starts_with("<!doctype html>"));
            // A page contains a script only if it also contains the data for that script.
            let with_data = match name.as_str() {
                "index.html" | "your-finger.html" => [1, 3],
                "maps.html" => [1, 2],
                _ => [0, 0],
            };
            assert_eq!([page.matches("<script>").count(), page.matches("<script").count()], with_data, "{name}");
            assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count(), "{name}");
            assert!(!without_program(&page).contains("NaN"), "{name}: a figure holds no number");
        }
        assert!(report.pages().matches("<svg").count() >= 8);
    }
}

/// A page without the embedded program of the finger.
fn without_program(page: &str) -> String {
    let Some((before, rest)) = page.split_once("id=\"push-program\">") else { return page.to_owned() };
    format!("{before}{}", rest.split_once('<').expect("the end of the program").1)
}

/// Limits for the first page: size in bytes without the embedded program, and number of visible words.
const FIRST_PAGE: [usize; 2] = [1_000_000, 1200];
/// Largest number of visible words of all pages.
const WORDS: usize = 6000;

/// Text of a page without tags and without the elements `hidden`.
fn text_without(page: &str, hidden: &[&str]) -> String {
    let without = |text: &str, open: &str, close: &str| -> String {
        let mut parts = text.split(open);
        let first = parts.next().unwrap_or_default().to_owned();
        parts.fold(first, |kept, part| kept + part.split_once(close).map_or("", |(_, rest)| rest))
    };
    let text = hidden
        .iter()
        .fold(page.to_owned(), |text, element| without(&text, &format!("<{element}"), &format!("</{element}>")));
    without(&text, "<", ">")
}

/// Number of words that a reader sees before opening closed parts, without drawings and scripts.
fn visible_words(page: &str) -> usize {
    text_without(page, &["script", "style", "svg", "details"]).split_whitespace().count()
}

/// Sentences that a page joins from parts have a space between them.
#[test]
fn sentences_are_separated() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        for name in report.page_names() {
            let text = text_without(&report.read(&name), &["script", "style", "svg"]);
            let letters: Vec<char> = text.chars().collect();
            let glued = letters.windows(3).position(|three| {
                (three[0].is_lowercase() || ")%".contains(three[0])) && three[1] == '.' && three[2].is_uppercase()
            });
            let around =
                |at: usize| letters[at.saturating_sub(40)..(at + 40).min(letters.len())].iter().collect::<String>();
            assert!(glued.is_none(), "{name}: {:?}", glued.map(around));
        }
    }
}

#[test]
fn pages_are_short_enough_to_be_read() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let first = report.read("index.html");
        let size = without_program(&first).len();
        assert!(size < FIRST_PAGE[0] && visible_words(&first) < FIRST_PAGE[1], "{size}, {}", visible_words(&first));
        let all: usize = report.page_names().iter().map(|name| visible_words(&report.read(name))).sum();
        assert!(all < WORDS, "{all}");
    }
}

/// Drawings of a page: the figures that contain an `<svg>`.
fn drawings(page: &str) -> Vec<&str> {
    let figures = page.split("<figure").skip(1).filter_map(|rest| rest.split("</figure>").next());
    figures.filter(|figure| figure.contains("<svg")).collect()
}

/// The texts of a drawing, without numbers.
fn words(figure: &str) -> Vec<&str> {
    let texts = figure.split("<text").skip(1).filter_map(|rest| rest.split_once('>')?.1.split("</text>").next());
    texts.map(str::trim).filter(|text| !text.is_empty() && text.parse::<f64>().is_err()).collect()
}

/// Every drawing has a name, a caption and a file with its numbers. In drawings with axes, each axis is labelled with quantity and unit.
#[test]
fn every_drawing_says_what_it_shows() {
    // Units, and words that stand in axis labels of counts and ratios. Every axis label contains at least one of the texts in `units`.
    let units = [
        " mm", ", N", ", %", " deg", " \u{b5}s", "nodes", "node", "bodies", "segments", "cases", "modulus", "factor",
        "parameters", "reference", "largest displacement",
    ];
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let page = report.pages();
        let drawings = drawings(&page);
        assert!(drawings.len() >= 8 && drawings.len() == page.matches("<svg").count());
        for figure in drawings {
            let start = &figure[..figure.len().min(400)];
            let between = |open: &str, close: &str| figure.split(open).nth(1)?.split(close).next();
            assert!(between("<title>", "</title>").is_some_and(|name| !name.is_empty()), "{start}");
            assert!(between("<figcaption>", "<").is_some_and(|caption| caption.trim().len() > 20), "{start}");
            assert!(figure.contains("class=\"csv\" href=\""), "{start}");
            let axes = words(figure).into_iter().filter(|text| units.iter().any(|unit| text.contains(unit))).count();
            assert!(axes >= 2, "{:?} in {start}", words(figure));
        }
    }
}

/// Largest number of words on the first screen.
const FIRST_SCREEN: usize = 120;

/// The first page begins with a short verdict, which states that the results come from simulation only. After the short verdict, the page shows the
/// finger in nine situations, the unknown contact first, and then the full verdict. Each section begins with its conclusion.
#[test]
fn the_first_page_begins_with_its_verdict() {
    let page = PAPERS.read("index.html");
    let at = |part: &str| page.find(part).unwrap_or_else(|| panic!("no {part}"));
    let screen = &page[at("<body>")..at("<nav class=\"bar\"")];
    assert!((4..=5).contains(&screen.matches("<dt>").count()) && visible_words(screen) <= FIRST_SCREEN, "{screen}");
    assert!(screen.contains("Simulation only."));
    let trusted = page[at("<h2 id=\"trusted\"")..].split("</section>").next().expect("the section");
    assert_eq!((trusted.matches("<dt>").count(), trusted.matches("<svg").count()), (5, 9));
    assert!(trusted.contains("class=\"caveat\">Simulation only, with"));
    for figure in drawings(trusted) {
        assert!(
            figure.contains("Noise samples: ") && figure.contains(" with a warning."),
            "a share without its counts"
        );
    }
    assert!(trusted.find("Contact unknown:") < trusted.find("Contact known:"), "the unknown contact comes first");
    let page = PAPERS.pages();
    let at = |part: &str| page.find(part).unwrap_or_else(|| panic!("no {part}"));
    for id in [
        "maps", "contact-scenes", "estimators", "noise", "speed-error", "networks", "checks", "claims", "lattice",
        "hard-cases", "table-one", "twin",
    ] {
        let section = page[at(&format!("<h2 id=\"{id}\""))..].split("</section>").next().unwrap_or_default();
        let blocks = section.split("class=\"says\"").nth(1).and_then(|says| says.split("</div>").next());
        assert!(blocks.is_some_and(|says| says.matches("<p>").count() >= 1), "{id} says nothing");
    }
    // What a builder may change comes before the maps, and its shares are those of the maps. The change that gains most is named.
    let index = PAPERS.read("index.html");
    assert!(index.find("<h2 id=\"changes\"") < index.find("<h2 id=\"trusted\""));
    let summary = PAPERS.summary();
    let changes = array(&summary, "changes");
    let share = |name: &str| {
        let row = changes.iter().find(|row| row["change"] == name).unwrap_or_else(|| panic!("no {name}"));
        row["share_trusted"].as_f64().expect("a share")
    };
    let trusted = |case: &str| {
        let row = array(&summary, "trust").iter().find(|row| row["case"] == case).expect("the case");
        row["share_trusted"].as_f64().expect("a share")
    };
    let same =
        [("as it is", "contact unknown"), ("friction known", "friction known"), ("position known", "position known")];
    for (change, case) in same {
        assert_eq!(share(change), trusted(case), "{change}");
    }
    assert!(share("half the noise") > share("as it is") && share("larger forces") > share("as it is"), "{changes:?}");
    assert!(share("direction known") > share("position known"), "{changes:?}");
    // Conditions of use gain more here, and are not what a builder can change.
    let chosen = || changes.iter().filter(|row| row["is_condition"] == false);
    let most = chosen().map(|row| row["share_trusted"].as_f64().expect("a share")).fold(0.0, f64::max);
    assert!(share("direction known") > most, "{changes:?}");
    let best = chosen().find(|row| row["share_trusted"].as_f64() == Some(most)).expect("a change");
    let best = best["change"].as_str().expect("words");
    assert!(index.contains(&format!("What should I change? Most is gained by: {best}</h2>")), "{best}");
    // The modulus of the paper's finger is measured, so weighing it changes nothing.
    assert!(!changes.iter().any(|row| row["change"] == "modulus weighed"));
    // Every sentence of the verdict in the machine-readable summary occurs exactly once, on one page.
    let page = as_read(&page);
    for sentence in array(&summary, "verdict") {
        let sentence = sentence.as_str().expect("words");
        assert_eq!(page.matches(sentence).count(), 1, "{sentence}");
    }
}

/// Part of a range that is nearest to each of some ascending values.
fn parts(values: &[f64], [from, to]: [f64; 2]) -> Vec<f64> {
    let edge = |i: usize| match i {
        0 => from,
        i if i == values.len() => to,
        i => (0.5 * (values[i - 1] + values[i])).clamp(from, to),
    };
    (0..values.len()).map(|i| edge(i + 1) - edge(i)).collect()
}

fn distinct(values: Vec<f64>) -> Vec<f64> {
    let mut values = values;
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// The first answer of the verdict states trusted shares, which follow from the map files. The largest error over four forces decides whether a cell
/// is trusted; a cell counts by its part of the plate and of the directions that friction allows.
#[test]
fn the_first_answer_adds_up_the_cells_of_its_maps() {
    let summary = PAPERS.summary();
    let first = array(&summary, "verdict")[0].as_str().expect("words");
    let page = PAPERS.read("index.html");
    let half = 0.5_f64.atan().to_degrees();
    let maps = [
        ("contact unknown", "map_contact_auto_auto_hidden_none.csv", 45.0),
        ("contact unknown, markers at the object hidden", "map_contact_auto_auto_hidden_object.csv", 45.0),
        ("friction known", "map_contact_auto_friction_hidden_none.csv", half),
        ("contact misjudged", "map_contact_off_hidden_none.csv", 45.0),
        ("contact known", "map_corotational_nonlinear_with_noise.csv", 45.0),
        ("contact known, base and tip softer than modelled", "map_twin_nonlinear_with_noise.csv", 45.0),
    ];
    let mut shares = Vec::new();
    for (case, file, most_deg) in maps {
        let cells = Csv::of(&PAPERS.read(file));
        let (errors, samples) = (cells.texts("mean_error"), cells.numbers("samples"));
        let [places, angles] = ["s_mm", "angle_deg"].map(|column| distinct(cells.numbers(column)));
        let (lengths, sectors) = (parts(&places, [0.0, 153.0]), parts(&angles, [-most_deg, most_deg]));
        let weights = lengths.iter().flat_map(|length| sectors.iter().map(move |sector| length * sector));
        let [mut kept, mut carried] = [0.0; 2];
        for ((errors, samples), weight) in errors.chunks(4).zip(samples.chunks(4)).zip(weights) {
            if samples.iter().all(|count| *count > 0.0) {
                carried += weight;
                let is_within = |error: &&str| error.parse::<f64>().is_ok_and(|error| error <= 0.1);
                kept += if errors.iter().all(is_within) { weight } else { 0.0 };
            }
        }
        let share = kept / carried;
        let entry = array(&summary, "trust").iter().find(|entry| entry["case"] == case).expect("the case");
        let stated = entry["share_trusted"].as_f64().expect("a share");
        assert!((stated - share).abs() <= LINEAR_ROUNDING, "{case}: {stated}, {share}");
        let percent = match 100.0 * share {
            percent if percent == 0.0 || percent > 9.5 => format!("{percent:.0} %"),
            percent => format!("{percent:.1} %"),
        };
        assert!(first.contains(&format!("{percent} ({case})")), "{case}, {percent}: {first}");
        let title = format!("{}{}: {percent}", case[..1].to_uppercase(), &case[1..]);
        assert!(page.contains(&title), "{title}");
        shares.push(share);
    }
    // Who knows more senses more.
    assert!(shares[0] < shares[2] && shares[2] < shares[4] && shares[1] <= shares[0], "{shares:?}");
}

/// Shares exclude cells without an equilibrium. The page states the number of cells without an equilibrium, so that a share does not seem to refer to
/// all cells.
#[test]
fn cells_without_an_equilibrium_are_said() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let summary = report.summary();
        let known = array(&summary, "trust").iter().find(|entry| entry["case"] == "contact known").expect("the case");
        let [cells, without] = ["cells", "without_equilibrium"].map(|key| known[key].as_u64().expect("a count"));
        let first = array(&summary, "verdict")[0].as_str().expect("words");
        let said = format!("no equilibrium under at least one of these forces in {without} of {cells} cells");
        assert_eq!(first.contains(&said), without > 0, "{said}: {first}");
    }
}

/// A page without sections is not written, and no other page links to it.
#[test]
fn pages_without_a_study_are_not_there() {
    for (report, expected) in [(&*PAPERS, true), (&*SPRING_STEELS, false)] {
        assert_eq!(report.page_names().contains(&"paper.html".to_owned()), expected);
        assert_eq!(report.read("index.html").contains("href=\"paper.html"), expected);
        for name in report.page_names().iter().filter(|name| *name != "your-finger.html") {
            assert!(report.read(name).contains("<h2 id="), "{name}");
        }
    }
}

/// The verdict states that the beam model is beyond its limits exactly if a shape in `validity.csv` exceeds a limit.
#[test]
fn limits_of_the_beam_model_are_said_first() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let shapes = Csv::of(&report.read("validity.csv"));
        let largest = |column: &str| shapes.numbers(column).into_iter().fold(0.0, f64::max);
        let is_beyond = largest("largest_strain") > 0.05 || largest("shear_share") > 0.05;
        let summary = report.summary();
        let answers = array(&summary, "verdict").iter().filter_map(serde_json::Value::as_str);
        let physics = answers.filter(|answer| answer.starts_with("Is the physics right?")).collect::<String>();
        assert_eq!(physics.contains("beyond its limits"), is_beyond, "{physics}");
    }
}

/// Numbers in the remaining answers of the verdict follow from files: failures in the map, the share of cells for least squares, coverage and
/// refusals.
#[test]
fn the_other_answers_are_found_in_files() {
    let summary = PAPERS.summary();
    let answers = array(&summary, "verdict").iter().filter_map(serde_json::Value::as_str).collect::<Vec<_>>();
    let answer = |question: &str| *answers.iter().find(|answer| answer.starts_with(question)).expect("the answer");

    let map = Csv::of(&PAPERS.read("map_corotational_nonlinear_with_noise.csv"));
    let number = |text: &&str| text.parse::<f64>().unwrap_or(f64::NAN);
    let columns = ["mean_error", "bias", "spread", "force_n"]
        .map(|column| map.texts(column).iter().map(number).collect::<Vec<f64>>());
    let failed: Vec<usize> = (0..columns[0].len()).filter(|&row| columns[0][row] > 0.1).collect();
    let by_noise = failed.iter().filter(|&&row| columns[2][row] > columns[1][row].abs()).count();
    let small = failed.iter().filter(|&&row| columns[3][row] == 0.5).count();
    assert!(2 * by_noise > failed.len());
    assert_says(
        answer("Why not elsewhere?"),
        &[&format!(
            "in {by_noise} of the {0} sensed forces that fail; {small} of these {0} are forces of 0.5 N",
            failed.len()
        )],
    );

    let estimators = Csv::of(&PAPERS.read("estimators.csv"));
    let row = estimators.texts("estimator").iter().position(|name| *name == "least-squares").expect("a row");
    let share = estimators.numbers("share_trusted")[row];
    assert_says(
        answer("What should sense it?"),
        &[&format!("Least squares: mean error within 10 % in a share of {:.0} %", 100.0 * share)],
    );

    let coverage = Csv::of(&PAPERS.read("coverage.csv"));
    let of = |truth: &str| {
        let kinds = coverage.texts("truth").into_iter().zip(coverage.texts("estimator"));
        kinds.into_iter().position(|kind| kind == (truth, "nonlinear")).expect("a row")
    };
    let value = |column: &str, row: usize| coverage.texts(column)[row].parse::<f64>().expect("a number");
    let (known, softer) = (of("corotational"), of("twin"));
    let said = [
        format!("in {:.0} % of the answers without a warning", 100.0 * value("covered_without_warning", known)),
        format!("({} of {} samples refused)", value("refused", known), value("samples", known)),
        format!(
            "intervals of answers without a warning ({:.0} % of {} samples) contain the force in {:.0} % of the cases",
            100.0 * value("without_warning", softer) / value("samples", softer),
            value("samples", softer),
            100.0 * value("covered_without_warning", softer)
        ),
    ];
    assert_says(answer("How sure is an answer?"), &said.each_ref().map(String::as_str));
}

/// README shows the drawing that the report makes of the paper's finger, with its dimensions, and small pictures only. It stays short.
#[test]
fn the_readme_is_short_and_shows_the_reports_drawing() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |name: &str| std::fs::read_to_string(root.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let readme = read("README.md");
    assert!(readme.lines().count() <= 120 && readme.len() <= 9 * 1024, "{} bytes", readme.len());
    let pictures: Vec<&str> = readme.split("](fixtures/").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    for name in pictures.iter().filter(|name| name.starts_with("pictures/")) {
        let size = std::fs::metadata(root.join("fixtures").join(name)).expect("a picture").len();
        assert!(size < 60_000, "{name}: {size} bytes");
    }
    assert!(pictures.contains(&"pictures/page.png"), "{pictures:?}");
    let drawing = PAPERS.read("finger.svg");
    assert_eq!(read("fixtures/pictures/finger.svg"), drawing);
    for words in [">58 mm<", ">153 mm, 1.5 mm thick<", ">ribs r1 to r11, 1.5 mm thick<", ">r1<", ">r11<", ">+40 deg<"] {
        assert!(drawing.contains(words), "{words}");
    }
}

/// The errors by part of the plate and force are the weighted means of the cells of the unknown contact's map.
#[test]
fn errors_by_place_and_force_follow_from_the_map() {
    let cells = Csv::of(&PAPERS.read("map_contact_auto_auto_hidden_none.csv"));
    let columns = ["s_mm", "angle_deg", "force_n"].map(|column| cells.numbers(column));
    let [s_mm, angle_deg, force_n] = &columns;
    let (errors, samples) = (cells.texts("mean_error"), cells.numbers("samples"));
    let [places, angles] = [s_mm, angle_deg].map(|values| distinct(values.clone()));
    let (lengths, sectors) = (parts(&places, [0.0, 153.0]), parts(&angles, [-45.0, 45.0]));
    let weight = |row: usize| {
        let at = |values: &[f64], value: f64| values.iter().position(|other| *other == value).expect("a cell");
        lengths[at(&places, s_mm[row])] * sectors[at(&angles, angle_deg[row])]
    };
    let table = Csv::of(&PAPERS.read("places.csv"));
    let [from, to, of_force] = ["from_mm", "to_mm", "force_n"].map(|column| table.numbers(column));
    let (stated, refused) = (table.texts("mean_error"), table.numbers("share_refused"));
    assert_eq!(stated.len(), 12);
    let mut known = 0;
    for row in 0..stated.len() {
        let is_in =
            |cell: &usize| s_mm[*cell] > from[row] && s_mm[*cell] <= to[row] + 1e-6 && force_n[*cell] == of_force[row];
        let [mut sum, mut answered, mut all] = [0.0; 3];
        for cell in (0..errors.len()).filter(is_in).filter(|cell| samples[*cell] > 0.0) {
            all += weight(cell);
            if let Ok(error) = errors[cell].parse::<f64>() {
                sum += weight(cell) * error;
                answered += weight(cell);
            }
        }
        assert!((refused[row] - (1.0 - answered / all)).abs() < 1e-9, "{row}: {answered} of {all}");
        if answered > 0.0 {
            assert_close(&[stated[row].parse().expect("a number")], &[sum / answered], 1e-9);
            known += 1;
        }
    }
    assert!(known >= 9, "{known}");
    let page = PAPERS.read("index.html");
    assert!(page.find("<h2 id=\"places\"") < page.find("<h2 id=\"changes\"") && page.contains("middle (51 to 102 mm)"));
}
