//! True and sensed forces as table rows, one row for each contact.

use super::{ContactScene, SceneStep, SeenContact, SensedContact, SensedStep};
use serde::Serialize;

/// Row of one contact of a step, or of the total of a step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForceRow {
    /// Number of the step, from 1.
    pub step: usize,
    /// Length of the object's path, mm.
    pub travel_mm: f64,
    /// Name of the contact, as [`SeenContact::name`] gives it, or `total`.
    pub contact: String,
    /// Position along the touched plate, mm from its base, or along a rib, mm from the back plate; `None` for the total.
    pub s_mm: Option<f64>,
    /// Direction of the contact normal, degrees from the undeformed inward normal of the touched plate (for a rib, of the front plate), positive towards
    /// the tip; `None` for the total.
    pub angle_deg: Option<f64>,
    /// True force along the normal, N; for the total, along the object's motion, without forces on the clamp.
    pub force_n: f64,
    /// True force across the normal, positive towards the tip, N; `None` for the total.
    pub friction_n: Option<f64>,
    /// Sensed force, N; `None` if the force is not identifiable.
    pub sensed_n: Option<f64>,
    /// Stated standard deviation of the sensed force, N.
    pub sigma_n: Option<f64>,
    /// Position read by the camera, mm from the base; `None` if nothing was sensed.
    pub read_s_mm: Option<f64>,
    /// Direction read by the camera, degrees from the undeformed inward normal; `None` if nothing was sensed.
    pub read_angle_deg: Option<f64>,
}

/// Pairs each contact with its sensed force; clamped contacts have no sensed force.
pub fn contacts_sensed<'s>(
    contacts: &'s [SeenContact],
    sensed: Option<&'s SensedStep>,
) -> impl Iterator<Item = (&'s SeenContact, Option<SensedContact>)> {
    let mut felt = sensed.map(|sensed| sensed.contacts.iter().copied()).into_iter().flatten();
    contacts.iter().map(move |seen| (seen, if seen.clamped { None } else { felt.next() }))
}

/// Rows of one step: its contacts from base to tip, then the total.
pub fn force_rows(scene: &ContactScene, number: usize, step: &SceneStep, sensed: Option<&SensedStep>) -> Vec<ForceRow> {
    let contacts = contacts_sensed(&step.contacts, sensed).map(|(seen, sensed)| ForceRow {
        step: number,
        travel_mm: step.travel_mm,
        contact: seen.name(),
        s_mm: seen.contact.position_mm(scene.finger()),
        angle_deg: Some(seen.contact.angle_deg),
        force_n: seen.normal_n,
        friction_n: Some(seen.friction_n),
        sensed_n: sensed.map(|sensed| sensed.force.sensed_n),
        sigma_n: sensed.map(|sensed| sensed.force.sigma_n),
        read_s_mm: sensed.and_then(|sensed| sensed.read.contact.position_mm(scene.finger())),
        read_angle_deg: sensed.map(|sensed| sensed.read.contact.angle_deg),
    });
    let total = sensed.map(|sensed| sensed.total);
    let total = ForceRow {
        step: number,
        travel_mm: step.travel_mm,
        contact: "total".to_owned(),
        s_mm: None,
        angle_deg: None,
        force_n: step.total_n(),
        friction_n: None,
        sensed_n: total.map(|force| force.sensed_n),
        sigma_n: total.map(|force| force.sigma_n),
        read_s_mm: None,
        read_angle_deg: None,
    };
    contacts.chain([total]).collect()
}
