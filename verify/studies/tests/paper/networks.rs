//! The paper's own method on Table II: recorded errors of the paper's network at the paper's contact nodes, beside the paper's five figures.
//!
//! Networks are trained as in sec. IV-A, on noise-free cases of the linear finger, with several seeds. `fixtures/networks/recipes.csv` contains the
//! networks' errors on simulated fingers. The paper does not state its scaling of displacements, so two scalings are recorded.

use super::joined;
use finray_studies::experiments::networks::records::{RecipeRow, Records};
use finray_studies::experiments::table_two::{CONTACT_GROUPS, ContactGroup};
use finray_studies::statistics::{Span, mean};
use finray_studies::truths::TruthId;
use finray_tests::CAMERA_NOISE_MM;

/// Recorded recipes that follow the paper: displacements scaled by the largest displacement, or by their spread.
pub const PAPER_RECIPES: [&str; 2] = ["a", "a, by spread"];
/// A figure of the paper counts as reproduced if the larger of our figure and the paper's is at most this multiple of the smaller. The factor 1.5 is
/// a choice. With inputs scaled by the largest displacement, errors of networks that differ only in their seed are within this factor of their mean.
pub const SAME_FACTOR: f64 = 1.5;

/// A mean relative error over the contact sets of a group, by seed.
#[derive(Debug, Clone, Copy)]
pub struct OverSeeds {
    pub errors: Span,
    pub seeds: usize,
    pub answered: usize,
    pub refused: usize,
}

/// One of the paper's five figures, with the recorded figure.
#[derive(Debug, Clone)]
pub struct Figure {
    pub group: ContactGroup,
    pub quantity: &'static str,
    pub paper: f64,
    pub recorded: OverSeeds,
}

impl Figure {
    /// Whether the mean over the seeds reproduces the paper's figure, by [`SAME_FACTOR`].
    pub fn reproduced(&self) -> bool {
        reproduces(self.paper, self.recorded.errors.mean)
    }
}

fn reproduces(paper: f64, ours: f64) -> bool {
    ours <= SAME_FACTOR * paper && SAME_FACTOR * ours >= paper
}

/// Quantities of a group in the paper's table, each with the paper's figure.
pub fn quantities(group: &ContactGroup) -> impl Iterator<Item = (&'static str, f64)> {
    [Some(("each force", group.paper_force)), group.paper_sum.map(|sum| ("sum", sum))].into_iter().flatten()
}

/// Error of a recipe on a finger at a noise level (mm), for one quantity of a group. Each seed contributes the mean over the group's sets. `None` if
/// a set is not recorded.
pub fn of_recipe(
    records: &[RecipeRow],
    recipe: &str,
    truth: TruthId,
    noise_mm: f64,
    group: &ContactGroup,
    quantity: &str,
) -> Option<OverSeeds> {
    let of_set = |nodes: &&[usize]| {
        let is = |row: &&RecipeRow| {
            (&*row.recipe, row.truth, row.noise_mm) == (recipe, truth, noise_mm)
                && (&*row.quantity, &row.nodes) == (quantity, &joined(*nodes, " "))
        };
        records.iter().filter(is).collect::<Vec<_>>()
    };
    let sets: Vec<Vec<&RecipeRow>> = group.sets.iter().map(of_set).collect();
    let of_seed = |first: &&RecipeRow| {
        let of_set = |set: &Vec<&RecipeRow>| set.iter().find(|row| row.seed == first.seed)?.mean_error;
        mean(sets.iter().map(of_set).collect::<Option<Vec<f64>>>()?)
    };
    let errors: Vec<f64> = sets[0].iter().map(of_seed).collect::<Option<_>>()?;
    Some(OverSeeds {
        seeds: errors.len(),
        errors: Span::of(errors)?,
        answered: sets.iter().flatten().map(|row| row.cases).sum(),
        refused: sets.iter().flatten().map(|row| row.refused).sum(),
    })
}

/// The paper's five figures, each with the figure recorded for a recipe on the co-rotational finger with noise.
pub fn figures(recipe: &str) -> Vec<Figure> {
    let records = Records::shipped().expect("records").recipes;
    let figure = |group: ContactGroup, (quantity, paper)| {
        let recorded = of_recipe(&records, recipe, TruthId::Corotational, CAMERA_NOISE_MM, &group, quantity);
        Figure { group, quantity, paper, recorded: recorded.expect("every set is recorded") }
    };
    CONTACT_GROUPS
        .into_iter()
        .flat_map(|group| quantities(&group).map(|of| figure(group, of)).collect::<Vec<_>>())
        .collect()
}

/// Justifies the value of [`SAME_FACTOR`]: for two contacts, the errors of all four seeds are within this factor of their mean.
#[test]
fn seeds_scatter_by_no_more_than_the_factor() {
    assert!(
        !reproduces(0.298, 0.198) && reproduces(0.298, 0.200) && reproduces(0.298, 0.446) && !reproduces(0.298, 0.448)
    );
    for recipe in PAPER_RECIPES {
        let all = figures(recipe);
        assert_eq!(all.iter().map(|figure| figure.paper).collect::<Vec<_>>(), [0.065, 0.475, 0.074, 0.298, 0.076]);
        for figure in all {
            let OverSeeds { errors: Span { mean, least, greatest }, seeds, refused, .. } = figure.recorded;
            assert_eq!((seeds, refused), (4, 0));
            let scatters = recipe == "a" && figure.group.paper_sum.is_some();
            assert!(!scatters || reproduces(mean, least) && reproduces(mean, greatest), "{figure:?}");
        }
    }
}
