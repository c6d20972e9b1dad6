//! Records of the paper's network, compared with the paper's five figures.

use finray_studies::experiments::networks::paper::{
    PAPER_RECIPES, figures, nodes_in_records, recorded, recorded_sets, reproduces,
};
use finray_studies::experiments::networks::records::{RecipeRow, Records};
use finray_studies::experiments::table_two::CONTACT_GROUPS;
use finray_studies::settings::CAMERA_NOISE_MM;
use finray_studies::statistics::Span;
use finray_studies::truths::TruthId;

#[test]
fn a_figure_is_reproduced_within_the_factor_on_both_sides() {
    assert!(reproduces(0.298, 0.200) && reproduces(0.298, 0.446));
    assert!(!reproduces(0.298, 0.198) && !reproduces(0.298, 0.448));
    // The errors recorded at nodes 18 and 20 do not reproduce the paper's 29.8 %.
    assert!([0.08, 0.14].into_iter().all(|ours| !reproduces(0.298, ours)));
    assert!(!reproduces(0.298, f64::NAN));
}

/// Each of the paper's recipes has records of four seeds for every set of contacts in every group of the table. If the records of a group's sets are
/// missing, `figures` returns `None`.
#[test]
fn the_papers_network_is_recorded_at_every_set_of_the_table() {
    let records = Records::shipped().expect("records").recipes;
    for recipe in PAPER_RECIPES {
        let all = figures(&records, recipe, CAMERA_NOISE_MM).expect("all five figures");
        assert_eq!(all.iter().map(|figure| figure.paper).collect::<Vec<_>>(), [0.065, 0.475, 0.074, 0.298, 0.076]);
        assert!(all.iter().all(|figure| figure.recorded.seeds == 4 && figure.recorded.refused == 0), "{all:?}");
    }
    for group in CONTACT_GROUPS {
        assert_eq!(recorded_sets(&records, "a", &group), group.sets);
        let names: Vec<String> = group.sets.iter().map(|nodes| nodes_in_records(nodes)).collect();
        let less: Vec<RecipeRow> = records.iter().filter(|row| !names.contains(&row.nodes)).cloned().collect();
        assert!(figures(&less, "a", CAMERA_NOISE_MM).is_none(), "without {}", group.name);
    }
}

/// Justifies the value of `SAME_FACTOR`: for two contacts, the errors of all seeds are within this factor of their mean.
#[test]
fn seeds_scatter_by_no_more_than_the_factor() {
    let records = Records::shipped().expect("records").recipes;
    let all = figures(&records, "a", CAMERA_NOISE_MM).expect("all five figures");
    for figure in all.iter().filter(|figure| figure.group.paper_sum.is_some()) {
        let Span { mean, least, greatest } = figure.recorded.errors;
        assert!(reproduces(mean, least) && reproduces(mean, greatest), "{figure:?}");
    }
}

#[test]
fn sets_are_averaged_seed_by_seed() {
    let row = |seed, nodes: &str, error| RecipeRow {
        recipe: "a".into(),
        seed,
        truth: TruthId::Corotational,
        noise_mm: 0.067,
        nodes: nodes.into(),
        quantity: "each force".into(),
        cases: 10,
        refused: 1,
        mean_error: Some(error),
    };
    let [one, _, _] = CONTACT_GROUPS;
    let records = [
        [row(1, "21", 0.1), row(1, "19", 0.2), row(1, "17", 0.3)],
        [row(2, "21", 0.3), row(2, "19", 0.3), row(2, "17", 0.6)],
    ]
    .concat();
    let found = recorded(&records, "a", TruthId::Corotational, 0.067, &one, "each force").expect("recorded");
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
    let Span { mean, least, greatest } = found.errors;
    assert!(close(mean, 0.3) && close(least, 0.2) && close(greatest, 0.4), "{found:?}");
    assert_eq!((found.seeds, found.answered, found.refused), (2, 60, 6));
    assert!(recorded(&records[..5], "a", TruthId::Corotational, 0.067, &one, "each force").is_none());
}
