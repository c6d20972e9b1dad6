//! A digital twin of the finger behind Table I of Xu et al. (2021): the paper's finger with one of several possible sets of softer ends.
//!
//! The paper infers from its errors that the modulus "at the tip and base should be lower", and does not test it. Here the modulus factors of zones,
//! and the modulus outside the zones, are [fitted](fit) to the six published mean errors. The consequences are [studied](study). Six numbers, with an
//! assumed direction of the weights, do not determine a finger: other zones fit equally well, some even better. The twin's moduli are below those of
//! TPU. Soft ends are an assumption of the fit, so their effect on the twin is no evidence that the real finger has soft ends.

pub mod fit;
pub mod study;

use finray_model::Finger;
use finray_model::finger::Part;

/// One zone: part of the finger, and its start and end along that part from the base, in member lengths.
pub type Section = (Part, f64, f64);

/// Zones of the paper's finger, in groups that share a modulus factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoneSet {
    /// Name in tables.
    pub name: &'static str,
    /// Groups of zones, each with the factor at which its fit starts. This factor is the result of an earlier fit that started from 0.2.
    pub groups: &'static [(&'static [Section], f64)],
}

/// Length of a plate member of the paper's finger, mm.
const MEMBER_MM: f64 = 12.75;

const BASE: &[Section] = &[(Part::Front, 0.0, 1.0), (Part::Back, 0.0, 1.0)];
const NEXT: &[Section] = &[(Part::Front, 8.0, 10.0), (Part::Back, 8.0, 10.0)];
const TIP: &[Section] = &[(Part::Front, 10.0, 12.0), (Part::Back, 10.0, 12.0)];

/// Zones of the twin on each plate: the member at the base, the two members next to the tip zone, and the two members at the tip.
pub const TWIN: ZoneSet =
    ZoneSet { name: "base, before the tip, tip (drawn here)", groups: &[(BASE, 0.72), (NEXT, 0.153), (TIP, 0.064)] };

/// Alternative sets of zones; some of them fit Table I as well as the twin's zones do.
pub const OTHERS: [ZoneSet; 6] = [
    ZoneSet {
        name: "base of the front plate alone, members before the tip, tip",
        groups: &[(&[(Part::Front, 0.0, 1.0)], 0.55), (NEXT, 0.155), (TIP, 0.062)],
    },
    ZoneSet {
        name: "base of the back plate alone, members before the tip, tip",
        groups: &[(&[(Part::Back, 0.0, 1.0)], 0.35), (NEXT, 0.165), (TIP, 0.062)],
    },
    ZoneSet {
        name: "two members at the base, members before the tip, tip",
        groups: &[(&[(Part::Front, 0.0, 2.0), (Part::Back, 0.0, 2.0)], 0.71), (NEXT, 0.153), (TIP, 0.064)],
    },
    ZoneSet {
        name: "base, ribs before the tip, tip",
        groups: &[(BASE, 0.7), (&[(Part::Ribs, 7.9, 12.0)], 0.28), (TIP, 0.051)],
    },
    ZoneSet {
        name: "base, four members of tip alike",
        groups: &[(BASE, 0.72), (&[(Part::Front, 8.0, 12.0), (Part::Back, 8.0, 12.0)], 0.117)],
    },
    ZoneSet { name: "half a member at the base of the front plate", groups: &[(&[(Part::Front, 0.0, 0.5)], 0.014)] },
];

/// Young's modulus of each zone of a fitted finger, MPa.
pub fn moduli_mpa(finger: &Finger) -> Vec<f64> {
    let described = finger.description();
    let of_part = |part: Part| match part {
        Part::Front => Some(described.front.youngs_modulus_mpa),
        Part::Back => Some(described.back.youngs_modulus_mpa),
        Part::Ribs => described.ribs.strip.map(|strip| strip.youngs_modulus_mpa),
    };
    described.zones.iter().filter_map(|zone| Some(zone.modulus_factor * of_part(zone.part)?)).collect()
}
