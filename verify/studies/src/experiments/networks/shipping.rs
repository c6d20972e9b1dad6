//! Training recipes of the shipped networks.

use crate::experiments::table_two::contact_sets;
use crate::prelude::*;
use finray_model::finger::NodeId;
use finray_train::TrainingRecipe;

/// Number of the tip's node. The paper's single contacts are the nodes with higher numbers, 14 to 24.
const TIP: usize = 13;

/// A shipped network.
#[derive(Debug, Clone, PartialEq)]
pub struct Shipping {
    /// Name of the network's file, without extension.
    pub name: String,
    /// Training recipe.
    pub recipe: TrainingRecipe,
}

/// All shipped networks, in the order of the list of files.
pub fn shipping(finger: &Finger) -> Vec<Shipping> {
    let fixed = |nodes: &[usize]| Shipping {
        name: nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join("-"),
        recipe: TrainingRecipe::nonlinear(
            nodes.iter().map(|&node| Contact::at_node(NodeId(node))).collect(),
            CAMERA_NOISE_MM,
        ),
    };
    let singles = finger.contact_nodes().filter(|node| node.0 != TIP).map(|node| fixed(&[node.0]));
    let pairs = contact_sets().into_iter().filter(|set| set.len() > 1).map(fixed);
    let any_of = Shipping {
        name: "any".to_owned(),
        recipe: TrainingRecipe::any_of(finger.contact_nodes().map(Contact::at_node).collect(), CAMERA_NOISE_MM),
    };
    singles.chain(pairs).chain([any_of]).collect()
}
