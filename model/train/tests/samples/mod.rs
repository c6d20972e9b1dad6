//! Random load cases. Draws are reproducible on any number of threads and within the requested ranges (`draws`). The shapes in the load cases agree
//! with the sparse solver (`shapes`). Impossible requests are refused (`refusals`).

use finray_model::Kinematics;
use finray_tests::{STANDARD_ERRORS, at_node, paper};
use finray_train::samples::{SampleRecipe, Samples, Stream};

mod draws;
mod refusals;
mod shapes;

/// A recipe with normal forces at the given nodes of the linear finger.
fn linear(nodes: impl IntoIterator<Item = usize>) -> SampleRecipe {
    SampleRecipe::paper(nodes.into_iter().map(|node| at_node(node, 0.0)).collect(), Kinematics::Linear)
}

fn draw(recipe: &SampleRecipe, count: usize) -> Samples {
    recipe.draw(&paper(), count, 1, Stream::Test).expect("forces that the finger carries")
}

/// Checks that numbers have the mean and the standard deviation of the distribution from which they were drawn.
fn assert_normal(numbers: &[f64], mean: f64, deviation: f64) {
    let count = numbers.len() as f64;
    let found = numbers.iter().sum::<f64>() / count;
    let scatter = (numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
    assert!((found - mean).abs() <= STANDARD_ERRORS * deviation / count.sqrt(), "mean {found}, not {mean}");
    let relative = STANDARD_ERRORS / (2.0 * count).sqrt();
    assert!((scatter / deviation - 1.0).abs() <= relative, "standard deviation {scatter}, not {deviation}");
}
