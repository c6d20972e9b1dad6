//! The paper's Table II, by finger, noise and estimator; the paper's own network beside them, as recorded.

use super::page::{Block, Cell, Column, Row, Section, Table};
use super::sections::{self, text};
use super::tables::{error, percent};
use crate::experiments::networks::paper::{
    Figure, OverSeeds, PAPER_RECIPES, SAME_FACTOR, figures, quantities, recorded, recorded_sets,
};
use crate::experiments::networks::records::RecipeRow;
use crate::experiments::table_two::{
    CASES_WITHOUT_FIT, CONTACT_GROUPS, ContactGroup, FORCES_N, GroupErrors, MOST_FITS, TableTwo,
};
use crate::sampling::scatter::ScatterRow;
use crate::study::Study;
use serde::Serialize;

pub(super) const CSV: &str = "table_two.csv";
/// Errors below this are shown as none: no reader asks for a millionth of a percent.
const ROUNDING: f64 = 1e-8;
/// Noise is not the cause where the linear finger, with the same noise, errs by less than this share.
const MINOR: f64 = 0.5;

/// One quantity of one set of contacts, or the mean over a group's sets, as it stands in the CSV.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableTwoRow {
    /// Kinematics of the sensed finger.
    pub truth: &'static str,
    /// Standard deviation of one coordinate, mm.
    pub noise_mm: f64,
    /// Name of the estimator; `network of the paper` is recorded, a mean over seeds.
    pub estimator: String,
    /// Row of the paper's table.
    pub group: &'static str,
    /// Contact nodes, by spaces; `mean` for the mean over the group's sets, which the paper lists; of a record the sets that it has.
    pub nodes: String,
    /// `each force` or `sum`.
    pub quantity: &'static str,
    /// Cases that were drawn.
    pub drawn: usize,
    /// Cases that were answered; the mean is theirs.
    pub answered: usize,
    /// Cases that the estimator refused.
    pub refused: usize,
    /// What the paper measured on its gripper, over all tests of the group.
    pub paper_mean_error: Option<f64>,
    /// Mean of |sensed / true - 1|.
    pub mean_error: Option<f64>,
    /// Mean of |sensed - true|, N.
    pub mean_error_n: Option<f64>,
    /// What an estimator that reaches the Cramer-Rao bound has as its mean error.
    pub mean_error_bound: Option<f64>,
}

/// A row for the mean of the forces, and for their sum where there are several: set by set, then over each group, then the recorded.
pub(super) fn rows(study: &Study) -> Vec<TableTwoRow> {
    let Some(two) = &study.table_two else { return Vec::new() };
    let mut all = Vec::new();
    for finger in &two.fingers {
        for row in &finger.rows {
            let Some(group) = CONTACT_GROUPS.into_iter().find(|group| group.sets.contains(&&row.nodes[..])) else {
                continue;
            };
            all.extend(quantities(&group).map(|(quantity, _)| {
                let [mean_error, mean_error_n, mean_error_bound] = match quantity {
                    "sum" => [sum(row), row.sum.map(|sum| sum.mean_error_n), sum_bound(row)],
                    _ => [row.mean_error(), row.mean_error_n(), row.mean_error_bound()],
                };
                TableTwoRow {
                    truth: finger.truth,
                    noise_mm: row.noise_mm,
                    estimator: row.estimator.clone(),
                    group: group.name,
                    nodes: nodes_in_words(&row.nodes, " "),
                    quantity,
                    drawn: row.drawn(),
                    answered: row.cases,
                    refused: row.refused,
                    paper_mean_error: None,
                    mean_error,
                    mean_error_n,
                    mean_error_bound,
                }
            }));
        }
    }
    for (truth, noise_mm, estimator) in settings(two) {
        for group in CONTACT_GROUPS {
            let found = two.group(&group, truth, noise_mm, &estimator);
            all.extend(quantities(&group).map(|(quantity, paper)| TableTwoRow {
                truth,
                noise_mm,
                estimator: estimator.clone(),
                group: group.name,
                nodes: "mean".to_owned(),
                quantity,
                drawn: found.map_or(0, |found| found.answered + found.refused),
                answered: found.map_or(0, |found| found.answered),
                refused: found.map_or(0, |found| found.refused),
                paper_mean_error: Some(paper),
                mean_error: found.and_then(|found| if quantity == "sum" { found.sum } else { Some(found.force) }),
                mean_error_n: found.map(|found| found.force_n).filter(|_| quantity != "sum"),
                mean_error_bound:
                    found.and_then(|found| if quantity == "sum" { found.sum_bound } else { found.force_bound }),
            }));
        }
    }
    all.extend(recorded_rows(&study.records.recipes));
    all
}

/// The paper's recipes, mean over seeds and sets.
fn recorded_rows(records: &[RecipeRow]) -> Vec<TableTwoRow> {
    let mut all = Vec::new();
    for (truth, noise_mm) in recorded_settings(records) {
        for recipe in PAPER_RECIPES {
            for group in CONTACT_GROUPS {
                all.extend(quantities(&group).filter_map(|(quantity, paper)| {
                    let found = recorded(records, [recipe, truth], noise_mm, &group, quantity)?;
                    Some(TableTwoRow {
                        truth,
                        noise_mm,
                        estimator: paper_network(recipe),
                        group: group.name,
                        nodes: recorded_sets(records, recipe, &group)
                            .iter()
                            .map(|set| nodes_in_words(set, " "))
                            .collect::<Vec<_>>()
                            .join("; "),
                        quantity,
                        drawn: found.answered + found.refused,
                        answered: found.answered,
                        refused: found.refused,
                        paper_mean_error: Some(paper),
                        mean_error: Some(found.mean),
                        mean_error_n: None,
                        mean_error_bound: None,
                    })
                }));
            }
        }
    }
    all
}

/// How a recipe of the paper is called in tables.
fn paper_network(recipe: &str) -> String {
    let scaling = if recipe == PAPER_RECIPES[0] { "largest" } else { "spread" };
    format!("network of the paper, scaled by the {scaling}")
}

/// Fingers and levels of noise with records.
fn recorded_settings(records: &[RecipeRow]) -> Vec<(&'static str, f64)> {
    let mut settings = Vec::new();
    for truth in ["linear", "corotational"] {
        let mut levels: Vec<f64> = records.iter().filter(|row| row.truth == truth).map(|row| row.noise_mm).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        settings.extend(levels.into_iter().map(|noise_mm| (truth, noise_mm)));
    }
    settings
}

/// Finger, noise and estimator of the rows that were computed, by finger, then noise.
fn settings(two: &TableTwo) -> Vec<(&'static str, f64, String)> {
    let mut all: Vec<(&'static str, f64, String)> = Vec::new();
    for finger in &two.fingers {
        let mut of_finger: Vec<(&'static str, f64, String)> = Vec::new();
        for row in &finger.rows {
            let setting = (finger.truth, row.noise_mm, row.estimator.clone());
            if !of_finger.contains(&setting) {
                of_finger.push(setting);
            }
        }
        of_finger.sort_by(|a, b| a.1.total_cmp(&b.1));
        all.extend(of_finger);
    }
    all
}

/// Node numbers in a row.
pub(super) fn nodes_in_words(nodes: &[usize], between: &str) -> String {
    nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(between)
}

/// Share of cases that were refused.
pub(super) fn share_refused<'r>(rows: impl IntoIterator<Item = &'r ScatterRow>) -> String {
    share_in_words(rows.into_iter().map(|row| [row.refused, row.cases]))
}

/// The same of numbers of refused and of sensed cases.
pub(super) fn share_in_words(counts: impl Iterator<Item = [usize; 2]>) -> String {
    let [refused, sensed] = counts.fold([0, 0], |[r, s], [refused, sensed]| [r + refused, s + sensed]);
    if refused == 0 { "0".to_owned() } else { percent(refused as f64 / (refused + sensed) as f64) }
}

pub(super) fn sum(row: &ScatterRow) -> Option<f64> {
    row.sum.map(|sum| sum.mean_error)
}

fn sum_bound(row: &ScatterRow) -> Option<f64> {
    Some(row.sum?.bound?.mean_error_bound)
}

pub(super) fn section(study: &Study) -> Option<Section> {
    let two = study.table_two.as_ref()?;
    let groups = CONTACT_GROUPS.map(|group| {
        let sets: Vec<String> = group.sets.iter().map(|set| nodes_in_words(set, " and ")).collect();
        format!("{} ({})", group.name, sets.join("; "))
    });
    let mut blocks = vec![text(format!(
        "The paper grasps sensor modules with its gripper, senses with its network and lists mean errors over the tests at the nodes that \
         sec. V-C names: {}. Here a simulated finger whose model is known is sensed at the same nodes, {} times for each set of contacts, all \
         estimators from the same noise samples: forces of {} to {} N along the normal, nodes and directions known. Shown is the mean \
         error of a force over the sets of a column and, behind it, of the sum of both, over the cases that were answered; how many \
         were refused stands beside. The bound is that of Cramer and Rao. The nonlinear estimator takes its time and senses the first \
         {} cases of each set; of the linear finger, which it does not fit, {}. \"network\" is that which ships for these contacts, trained \
         on the co-rotational finger. \"Network of the paper\" is trained as in sec. IV-A, on noise-free cases of the linear finger, and \
         recorded: mean over the seeds, least and greatest in brackets; the paper does not say how displacements are scaled, so two \
         ways are. Its records are of {}, not of all the paper's sets.",
        groups.join(", "),
        two.cases,
        FORCES_N[0],
        FORCES_N[1],
        two.cases.min(MOST_FITS),
        two.cases.min(CASES_WITHOUT_FIT),
        recorded_in_words(&study.records.recipes)
    ))];
    blocks.extend(words(two).map(text));
    blocks.extend(
        PAPER_RECIPES.iter().filter_map(|recipe| paper_words(&study.records.recipes, recipe, study.noise_mm)).map(text),
    );
    blocks.push(Block::Table(table(two, &study.records.recipes)));
    Some(sections::section("table-two", "The paper's Table II", blocks))
}

/// What linear sensing has to do with the table.
pub(super) fn words(two: &TableTwo) -> Option<String> {
    let noise_mm = two.fingers.iter().flat_map(|finger| &finger.rows).map(|row| row.noise_mm).fold(0.0, f64::max);
    let of = |group: &ContactGroup, truth: &str, estimator: &str| two.group(group, truth, noise_mm, estimator);
    let [_, neighbours, apart] = CONTACT_GROUPS;
    let near = of(&neighbours, "corotational", "least-squares")?;
    let far = of(&apart, "corotational", "least-squares")?;
    let alone = of(&neighbours, "linear", "least-squares")?;
    let nonlinear = of(&neighbours, "corotational", "nonlinear")?;
    let sums = near.sum?.max(far.sum?);
    let mut words = format!(
        "Least squares on the co-rotational finger errs by {} for each of two neighbours, by {} for each of two nodes apart, and by no \
         more than {} in a sum.",
        percent(near.force),
        percent(far.force),
        percent(sums),
    );
    if alone.force < MINOR * near.force {
        let range =
            |group: &ContactGroup| two.condition_range(group).map(|[low, high]| format!("{low:.1} to {high:.1}"));
        words += &format!(
            " Noise is the lesser part: on the linear finger, with the same noise, neighbours err by {}. The rest is the error of \
             linearisation, enlarged by up to the condition number of the contacts, {} for neighbours and {} for nodes apart: \
             neighbours bend the finger nearly alike, and what linear theory gets wrong of the shape is taken for a shift of force from \
             one node to the other.",
            percent(alone.force),
            range(&neighbours)?,
            range(&apart)?,
        );
    }
    words += &format!(
        " The nonlinear estimator, which has the finger's own model, errs by {} for neighbours ({} of {} cases refused).",
        percent(nonlinear.force),
        nonlinear.refused,
        nonlinear.refused + nonlinear.answered
    );
    Some(words)
}

/// Which of the paper's five figures its own method reproduces on the simulated finger.
fn paper_words(records: &[RecipeRow], recipe: &str, noise_mm: f64) -> Option<String> {
    let all = figures(records, recipe, noise_mm)?;
    let listed = |figures: &[&Figure]| {
        let one = |figure: &&Figure| {
            let Figure { group, quantity, paper, recorded } = figure;
            format!("{}, {quantity}: {} (paper {})", group.name, in_words(recorded), percent(*paper))
        };
        figures.iter().map(one).collect::<Vec<_>>().join("; ")
    };
    let (hit, missed): (Vec<&Figure>, Vec<&Figure>) = all.iter().partition(|figure| figure.reproduced());
    let seeds = all.iter().map(|figure| figure.recorded.seeds).min()?;
    let verdict = match (hit.len(), missed.len()) {
        (_, 0) => {
            format!("reproduces all five figures of Table II within a factor of {SAME_FACTOR}: {}.", listed(&hit))
        }
        (0, _) => format!(
            "reproduces none of the five figures of Table II within a factor of {SAME_FACTOR}: {}.",
            listed(&missed)
        ),
        (some, _) => format!(
            "does not reproduce Table II: {some} of its five figures are met within a factor of {SAME_FACTOR} ({}), the others are missed \
             ({}).",
            listed(&hit),
            listed(&missed)
        ),
    };
    let name = paper_network(recipe);
    let sets = recorded_in_words(records);
    Some(format!(
        "In simulation, on the co-rotational finger with {noise_mm} mm noise, the {name} (recorded at {sets}; {seeds} seeds) {verdict}"
    ))
}

/// The sets of contacts with records.
fn recorded_in_words(records: &[RecipeRow]) -> String {
    let of_group = |group: &ContactGroup| {
        let sets = recorded_sets(records, PAPER_RECIPES[0], group);
        sets.iter().map(|set| nodes_in_words(set, " and ")).collect::<Vec<_>>()
    };
    format!("nodes {}", CONTACT_GROUPS.iter().flat_map(of_group).collect::<Vec<_>>().join("; "))
}

/// `5.1 % (4.2\u{2013}6.0)`: mean, least and greatest.
fn in_words(over: &OverSeeds) -> String {
    let bare = |share: f64| percent(share).trim_end_matches(" %").to_owned();
    let [least, greatest] = [over.least, over.greatest].map(bare);
    if least == greatest { percent(over.mean) } else { format!("{} ({least}\u{2013}{greatest})", percent(over.mean)) }
}

/// A row for the paper, then one for each finger, noise and estimator; a bound where there is noise.
fn table(two: &TableTwo, records: &[RecipeRow]) -> Table {
    let paper = CONTACT_GROUPS.map(|group| errors(Some(group.paper_force), group.paper_sum, group.paper_sum.is_some()));
    let words = ["the paper's gripper", "-", "network"].map(Cell::plain);
    let cells = words.into_iter().chain(paper.into_iter().flatten()).chain([Cell::plain("")]);
    let mut rows = vec![Row { cells: cells.collect() }];
    let settings = settings(two);
    for finger in &two.fingers {
        let of_finger: Vec<_> = settings.iter().filter(|(truth, ..)| *truth == finger.truth).collect();
        let mut levels: Vec<f64> = of_finger.iter().map(|(_, noise_mm, _)| *noise_mm).collect();
        levels.dedup();
        for noise_mm in levels {
            rows.extend(recorded_lines(records, finger.truth, noise_mm));
            let of_level = of_finger.iter().filter(|(_, level, _)| *level == noise_mm);
            rows.extend(level_rows(two, finger.truth, noise_mm, of_level.map(|(.., estimator)| estimator.as_str())));
        }
    }
    let columns = CONTACT_GROUPS.iter().flat_map(|group| {
        let sum = group.paper_sum.map(|_| Column::numbers("sum"));
        [Some(Column::numbers(group.name)), sum].into_iter().flatten()
    });
    Table {
        caption: format!(
            "Mean error of each force and of the sum, forces of {} to {} N, mean over the paper's contact sets; grey above 10 %, dark above \
             25 %",
            FORCES_N[0], FORCES_N[1]
        ),
        columns: ["finger", "noise, mm", "sensed by"]
            .map(Column::words)
            .into_iter()
            .chain(columns)
            .chain([Column::numbers("refused")])
            .collect(),
        rows,
        csv: Some(CSV.to_owned()),
    }
}

/// The bound, if there is one, and a row an estimator.
fn level_rows<'e>(
    two: &TableTwo,
    truth: &'static str,
    noise_mm: f64,
    estimators: impl Iterator<Item = &'e str>,
) -> Vec<Row> {
    let line = |what: &str, of: &dyn Fn(&ContactGroup) -> [Option<f64>; 2], refused: String| {
        let cells = CONTACT_GROUPS.iter().flat_map(|group| {
            let [force, sum] = of(group);
            errors(force, sum, group.paper_sum.is_some())
        });
        let words = [finger_name(truth), &noise_mm.to_string(), what].map(Cell::plain);
        Row { cells: words.into_iter().chain(cells).chain([Cell::plain(refused)]).collect() }
    };
    let mut rows = Vec::new();
    for estimator in estimators {
        let found = |group: &ContactGroup| two.group(group, truth, noise_mm, estimator);
        // The bound is the same beside all estimators; the first one saw all cases.
        if noise_mm > 0.0 && rows.is_empty() {
            let bound = |group: &ContactGroup| found(group).map_or([None, None], |of| [of.force_bound, of.sum_bound]);
            rows.push(line("bound", &bound, String::new()));
        }
        let mean = |group: &ContactGroup| found(group).map_or([None, None], |of: GroupErrors| [Some(of.force), of.sum]);
        rows.push(line(estimator, &mean, share_refused(two.of(truth, noise_mm, estimator))));
    }
    rows
}

/// The paper's network as recorded.
fn recorded_lines(records: &[RecipeRow], truth: &'static str, noise_mm: f64) -> Vec<Row> {
    let line = |recipe: &&str| {
        let of = |group: &ContactGroup, quantity: &str| recorded(records, [*recipe, truth], noise_mm, group, quantity);
        let found: Vec<OverSeeds> = CONTACT_GROUPS.iter().filter_map(|group| of(group, "each force")).collect();
        if found.is_empty() {
            return None;
        }
        let cell = |over: Option<OverSeeds>| match over {
            None => Cell::plain("not recorded"),
            Some(over) => Cell { text: in_words(&over), ..error(over.mean) },
        };
        let cells = CONTACT_GROUPS
            .iter()
            .flat_map(|group| quantities(group).map(|(quantity, _)| cell(of(group, quantity))).collect::<Vec<_>>());
        let words = [finger_name(truth).to_owned(), noise_mm.to_string(), paper_network(recipe) + " (recorded)"];
        let refused = share_in_words(found.iter().map(|over| [over.refused, over.answered]));
        Some(Row { cells: words.map(Cell::plain).into_iter().chain(cells).chain([Cell::plain(refused)]).collect() })
    };
    PAPER_RECIPES.iter().filter_map(line).collect()
}

pub(super) fn finger_name(truth: &str) -> &str {
    match truth {
        "linear" => "linear",
        _ => "co-rotational",
    }
}

/// The cells of one set of contacts: each force, and the sum where there is one.
pub(super) fn errors(force: Option<f64>, sum: Option<f64>, has_sum: bool) -> Vec<Cell> {
    let cell = |share: Option<f64>| match share {
        None => Cell::plain("-"),
        Some(rounding) if rounding < ROUNDING => Cell::plain("0 %"),
        Some(share) => error(share),
    };
    if has_sum { vec![cell(force), cell(sum)] } else { vec![cell(force)] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::networks::records::Records;
    use crate::settings::CAMERA_NOISE_MM;

    fn with(records: &[RecipeRow], error: impl Fn(&RecipeRow) -> f64) -> Vec<RecipeRow> {
        records.iter().map(|row| RecipeRow { mean_error: Some(error(row)), ..row.clone() }).collect()
    }

    fn papers(row: &RecipeRow) -> f64 {
        let of_set = |group: &ContactGroup| group.sets.iter().any(|set| nodes_in_words(set, " ") == row.nodes);
        let group = CONTACT_GROUPS.into_iter().find(of_set).expect("a set of the table");
        if row.quantity == "sum" { group.paper_sum.expect("a sum") } else { group.paper_force }
    }

    /// Four of five figures are not Table II: what is missed is named, with the paper's figure.
    #[test]
    fn table_two_is_reproduced_by_all_five_figures_alone() {
        let records = Records::shipped().expect("records").recipes;
        let said = |records: &[RecipeRow]| paper_words(records, "a", CAMERA_NOISE_MM).expect("recorded at all nodes");
        assert!(said(&with(&records, papers)).contains("reproduces all five figures"));
        let apart_missed = with(&records, |row| match (&row.nodes[..], &row.quantity[..]) {
            ("18 20" | "16 20", "each force") => 0.11,
            _ => papers(row),
        });
        let words = said(&apart_missed);
        assert!(words.contains("does not reproduce Table II: 4 of its five figures"), "{words}");
        assert!(words.contains("the others are missed (apart, each force: 11 % (paper 30 %))"), "{words}");
        let none = said(&with(&records, |row| 10.0 * papers(row)));
        assert!(none.contains("reproduces none of the five"), "{none}");
    }

    /// What is recorded today misses some of the paper's figures, and the page says so.
    #[test]
    fn the_recorded_network_does_not_reproduce_table_two() {
        let records = Records::shipped().expect("records").recipes;
        for recipe in PAPER_RECIPES {
            let words = paper_words(&records, recipe, CAMERA_NOISE_MM).expect("recorded at all nodes");
            assert!(words.contains("does not reproduce Table II") && words.contains("missed"), "{words}");
        }
    }
}
