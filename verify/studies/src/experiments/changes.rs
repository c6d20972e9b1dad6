//! What should a builder change? The trusted share of an unknown contact, and what it would be after one change at a time.

use super::{Context, Evidence, situations};
use crate::prelude::*;
use crate::sampling::map::AccuracyMap;
use crate::sampling::situation::{ContactKnowledge, HiddenMarkers, Situation};
use crate::settings::WEIGHED_MODULUS_SD;
use std::convert::Infallible;

/// Quotient of the noise and the noise after the change.
const LESS_NOISE: f64 = 2.0;

/// The trusted share after one change.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// The change in two or three words.
    pub change: String,
    /// What a builder does for it.
    pub means: String,
    /// Whether it is a condition of use, which no builder can choose, rather than a change of finger, camera or scene.
    pub is_condition: bool,
    /// Trusted share, dimensionless: the definition, grid and noise samples of the map of an unknown contact. `None` if no force has an equilibrium.
    pub share_trusted: Option<f64>,
}

impl Evidence for Change {}

/// The share as it is, then after each change. Empty without noise.
pub(crate) fn run(context: &Context, maps: &[AccuracyMap]) -> Result<Vec<Change>, Infallible> {
    let of_contact = |contact| Situation { contact, hidden: HiddenMarkers::None };
    let mapped = |contact| maps.iter().find(|map| map.situation == of_contact(contact));
    let (Some(unknown), stiffness) = (mapped(ContactKnowledge::Nothing), context.given.scene.stiffness_error) else {
        return Ok(Vec::new());
    };
    let finger = context.finger;
    let share = |map: &AccuracyMap| map.trust(finger).share();
    let new = |contact, noise_mm| {
        share(&situations::map(context, of_contact(contact), noise_mm, &|| context.progress.step()))
    };
    let quieter_mm = context.noise_mm / LESS_NOISE;
    let steps = unknown.request.contact_count();
    context.progress.part("changes", 2 * steps);
    let [.., least_n, _] = context.forces.of_maps_n();
    let change = |change: &str, means: String, share_trusted| Change {
        change: change.to_owned(),
        means,
        is_condition: false,
        share_trusted,
    };
    let mut all = vec![
        change("as it is", format!("unknown contact, {} mm noise", context.noise_mm), share(unknown)),
        change(
            "half the noise",
            format!("{quieter_mm} mm: a camera twice as near, or the mean of four images"),
            new(ContactKnowledge::Nothing, quieter_mm),
        ),
    ];
    let known = [
        ("friction known", "a range of the coefficient of friction (friction_range)", ContactKnowledge::Friction),
        ("position known", "an object that touches at one known point", ContactKnowledge::Position),
    ];
    let known = known.map(|(name, means, contact)| (name, means, mapped(contact).and_then(share)));
    all.extend(known.map(|(name, means, share)| change(name, means.to_owned(), share)));
    if stiffness.modulus > WEIGHED_MODULUS_SD {
        let weighed = unknown.weighed(finger, stiffness).map_or(share(unknown), |weighed| Some(weighed.share));
        let percent = |share: f64| 100.0 * share;
        let means = format!(
            "one hung weight (calibrate --weight): {:.0} % instead of {:.0} %",
            percent(WEIGHED_MODULUS_SD),
            percent(stiffness.modulus)
        );
        all.push(change("modulus weighed", means, weighed));
    }
    let conditions = [
        (
            "larger forces",
            format!("only forces of {least_n} N and more"),
            share(&unknown.with_forces(|force_n| force_n >= least_n)),
        ),
        (
            "direction known",
            "the angle between the force and the bent plate's normal, exactly".to_owned(),
            new(ContactKnowledge::Direction, context.noise_mm),
        ),
    ];
    let condition = |(name, means, share)| Change { is_condition: true, ..change(name, means, share) };
    all.extend(conditions.map(condition));
    Ok(all)
}
