//! The paper's figures, one by one, against ours.

mod experiments;
mod rate;

use crate::check::worst;
use crate::study::{CAMERA_NOISE_MM, Study};
use crate::table_one::TableOneRow;
use crate::table_two::CONTACT_SETS;
use experiments::{Range, largest};
use finray_model::NodeId;
use finray_model::sensing::SensingError;
use serde::Serialize;

/// What became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClaimVerdict {
    /// We find the same.
    Reproduced,
    /// We find less than the paper's error.
    Better,
    /// We find the paper's figure and its cause.
    Explained,
    /// We find otherwise.
    Refuted,
    /// What it rests on is not published, or needs the finger itself.
    NotTestableHere,
}

impl ClaimVerdict {
    /// In words, for tables.
    pub fn in_words(self) -> &'static str {
        match self {
            ClaimVerdict::Reproduced => "reproduced",
            ClaimVerdict::Better => "better",
            ClaimVerdict::Explained => "explained",
            ClaimVerdict::Refuted => "refuted",
            ClaimVerdict::NotTestableHere => "not testable here",
        }
    }
}

/// One claim.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    /// What the paper says.
    pub claim: String,
    /// Its figure.
    pub paper: String,
    /// Our figure.
    pub ours: String,
    /// How ours was found.
    pub how: String,
    /// What became of it.
    pub verdict: ClaimVerdict,
}

fn claim(claim: &str, paper: &str, ours: String, how: impl Into<String>, verdict: ClaimVerdict) -> Claim {
    Claim { claim: claim.to_owned(), paper: paper.to_owned(), ours, how: how.into(), verdict }
}

fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        p if p < 0.01 => format!("{:.0e} %", 100.0 * share),
        p if p < 1.0 => format!("{:.2} %", 100.0 * share),
        _ => format!("{:.1} %", 100.0 * share),
    }
}

fn between([low, high]: Range, unit: impl Fn(f64) -> String) -> String {
    format!("{} to {}", unit(low), unit(high))
}

/// Friction at which neglected torques are judged: rubber on most things.
const FRICTION: f64 = 0.5;
/// Two forces are told apart if their mean error is less.
const TOLD_SHARE: f64 = 0.1;
/// Errors of Table I are the same if they differ by less: a node's six weights scatter as much.
const SAME_SHARE: f64 = 0.03;
/// A tangential force is told if its standard deviation is less, N.
const TOLD_N: f64 = 0.3;

/// All claims, for a study of the paper's finger.
///
/// # Errors
/// [`SensingError`] if a small experiment behind one of them fails.
pub fn ledger(study: &Study) -> Result<Vec<Claim>, SensingError> {
    let mut claims = deformation(study)?;
    claims.extend(table_one(study));
    claims.extend(table_two(study));
    claims.extend(limits(study)?);
    claims.extend(not_testable());
    Ok(claims)
}

/// Section III: force to deformation.
fn deformation(study: &Study) -> Result<Vec<Claim>, SensingError> {
    use ClaimVerdict::{Better, Explained, Refuted, Reproduced};
    let mut claims = Vec::new();
    let of_source = |source: &str, what: &str| {
        let rows = study.checks.iter().filter(|check| check.source.contains(source) && check.problem.contains(what));
        worst(rows.map(|check| (check.ours - check.reference).abs()))
    };
    let opensees = of_source("OpenSees", "linear");
    claims.push(claim(
        "The 25-node model agrees with a commercial code on the same mesh",
        "within 1.5 %",
        format!("within {} of the largest displacement", percent(opensees)),
        "linear, against OpenSees; checks of this report",
        if opensees < 0.015 { Better } else { Refuted },
    ));
    let coarse = study.convergence.error(0, 3.0);
    claims.push(claim(
        "A finer mesh (684 nodes) is not necessary",
        "within 0.26 %",
        format!(
            "linear: equal to rounding; with large rotations 25 nodes are {} off at 3 N",
            coarse.map_or("-".to_owned(), percent)
        ),
        "linear frames are exact at the nodes on any mesh; with rotations, mesh convergence of this report",
        if coarse.is_some_and(|error| error < 0.01) { Reproduced } else { Refuted },
    ));
    let stiffer = experiments::stiffened(&study.finger, 0.45, 1.25)?;
    claims.push(claim(
        "A 3-D solid model differs widely from the frame",
        "not given",
        format!("{} times as stiff", between(stiffer, |x| format!("{x:.2}"))),
        "plates of this width bend in plane strain (Poisson's ratio 0.45 assumed: 1 / (1 - 0.45^2) = 1.25), and rods of 3 mm shorten the free \
         plates by rigid arms (1.25 mm assumed)",
        Explained,
    ));
    Ok(claims)
}

/// Sections V-A and V-B: the single finger.
fn table_one(study: &Study) -> Vec<Claim> {
    use ClaimVerdict::{Better, Refuted, Reproduced};
    let Some(table) = study.tables_one.first() else { return Vec::new() };
    let rows: Vec<&TableOneRow> = table.rows.iter().collect();
    let mut claims = Vec::new();
    let listed = |rows: &[&TableOneRow], figure: &dyn Fn(&TableOneRow) -> f64| {
        rows.iter().map(|row| format!("{} at {}", percent(figure(row)), row.node)).collect::<Vec<_>>().join(", ")
    };
    let (middle, ends): (Vec<_>, Vec<_>) = rows.into_iter().partition(|row| row.paper_mean_error < 0.1);
    let as_good = middle.iter().all(|row| row.mean_error <= row.paper_mean_error + 0.02);
    claims.push(claim(
        "Table I: weights in the middle of the finger are sensed well",
        &listed(&middle, &|row| row.paper_mean_error),
        listed(&middle, &|row| row.mean_error),
        format!(
            "the paper's linear model on the large-rotation finger, weights at {} deg (assumed), no noise",
            table.angle_deg
        ),
        if as_good { Reproduced } else { Refuted },
    ));
    let explained = ends.iter().all(|row| row.mean_error > 0.5 * row.paper_mean_error);
    claims.push(claim(
        "Table I: errors near tip and base come from the finger's geometric nonlinearity",
        &listed(&ends, &|row| row.paper_mean_error),
        listed(&ends, &|row| row.mean_error),
        "the same finger: large rotation is all that the linear model lacks there",
        if explained { Reproduced } else { Refuted },
    ));
    if let Some(noise) = &study.noise {
        let at_ends: Vec<(usize, f64)> = noise
            .single
            .iter()
            .filter_map(|row| Some((*row.nodes.first()?, row.mean_error()?)))
            .filter(|(node, _)| ends.iter().any(|row| row.node == *node))
            .collect();
        let ours = at_ends.iter().map(|(node, error)| format!("{} at {node}", percent(*error))).collect::<Vec<_>>();
        let better = ends
            .iter()
            .all(|row| at_ends.iter().any(|(node, error)| *node == row.node && *error < row.paper_mean_error));
        claims.push(claim(
            "Table I: what can be sensed near tip and base",
            &listed(&ends, &|row| row.paper_mean_error),
            ours.join(", "),
            format!(
                "nonlinear estimator, {} mm noise, forces of 0.5 to 3 N along the normal, if the finger is what the model takes it for",
                noise.noise_mm
            ),
            if better { Better } else { Refuted },
        ));
    }
    if let Some(twin) = &study.twin {
        let after: Vec<&TableOneRow> = twin.after.rows.iter().collect();
        let off = worst(after.iter().map(|row| (row.mean_error - row.paper_mean_error).abs()));
        let all: Vec<&TableOneRow> = table.rows.iter().collect();
        claims.push(claim(
            "The real modulus is lower near tip and base (a guess, not tested there)",
            &listed(&all, &|row| row.paper_mean_error),
            listed(&after, &|row| row.mean_error),
            "a finger with softer base and tip, fitted to these six figures: it shows that the guess suffices, not that it is true; other zones fit \
             as well",
            if off < SAME_SHARE { ClaimVerdict::Explained } else { Refuted },
        ));
    }
    claims.push(claim(
        "Young's modulus by eq. (11)",
        "47.976 MPa",
        format!("{:.2} of the true one", table.modulus_factor),
        "the paper's measured shapes are not published; on shapes of the large-rotation finger eq. (11) finds this share of the true modulus",
        ClaimVerdict::NotTestableHere,
    ));
    claims
}

/// Section V-C: the gripper.
fn table_two(study: &Study) -> Vec<Claim> {
    let Some(table) = &study.table_two else { return Vec::new() };
    let noise_mm = study.noise.as_ref().map_or(CAMERA_NOISE_MM, |noise| noise.noise_mm);
    let linear: Vec<_> = table.of("corotational", noise_mm, "least-squares").collect();
    let nonlinear: Vec<_> = table.of("corotational", noise_mm, "nonlinear").collect();
    let mut claims = Vec::new();
    for (i, set) in CONTACT_SETS.iter().enumerate() {
        let (Some(linear), Some(nonlinear)) = (linear.get(i), nonlinear.get(i)) else { continue };
        let (Some(by_linear), Some(by_nonlinear)) = (linear.mean_error(), nonlinear.mean_error()) else { continue };
        let verdict = if by_nonlinear < set.paper_force { ClaimVerdict::Better } else { ClaimVerdict::Refuted };
        claims.push(claim(
            &format!("Table II: mean error of each force, {}", set.name),
            &percent(set.paper_force),
            format!("{} (linear model: {})", percent(by_nonlinear), percent(by_linear)),
            format!(
                "nonlinear estimator on the large-rotation finger, {noise_mm} mm noise, nodes {}: the linear model errs by large rotation, \
                 times a condition number of {:.0}",
                set.nodes.iter().map(usize::to_string).collect::<Vec<_>>().join(" and "),
                table.condition_numbers.get(i).copied().unwrap_or(f64::NAN)
            ),
            verdict,
        ));
        let sums = (
            set.paper_sum,
            nonlinear.sum.as_ref().map(|sum| sum.mean_error),
            linear.sum.as_ref().map(|sum| sum.mean_error),
        );
        if let (Some(paper), Some(by_nonlinear), Some(by_linear)) = sums {
            claims.push(claim(
                &format!("Table II: mean error of their sum, {}", set.name),
                &percent(paper),
                format!("{} (linear model: {})", percent(by_nonlinear), percent(by_linear)),
                "the same cases",
                if by_nonlinear < paper { ClaimVerdict::Better } else { ClaimVerdict::Refuted },
            ));
        }
    }
    claims
}

/// What the paper says cannot be done, or need not be considered.
fn limits(study: &Study) -> Result<Vec<Claim>, SensingError> {
    use ClaimVerdict::{Explained, Refuted, Reproduced};
    let finger = &study.finger;
    let all = experiments::all_forces(finger, CAMERA_NOISE_MM)?;
    let near = experiments::redistributed(finger, [18, 19].map(NodeId))?;
    let far = experiments::redistributed(finger, [17, 21].map(NodeId))?;
    let across = experiments::unknown_direction(finger, CAMERA_NOISE_MM)?;
    let off = experiments::wrong_direction(finger, 12.5)?;
    let torque = experiments::neglected_torque(finger, FRICTION)?;
    let noise_mm = study.noise.as_ref().map_or(CAMERA_NOISE_MM, |noise| noise.noise_mm);
    let neighbours = study.table_two.as_ref().and_then(|table| {
        let neighbours = CONTACT_SETS.iter().position(|set| set.name == "neighbours")?;
        table.of("corotational", noise_mm, "nonlinear").nth(neighbours)?.mean_error()
    });
    let newtons = |x: f64| format!("{x:.2} N");
    Ok(vec![
        claim(
            "Least squares for all forces at once is poor and sensitive",
            "no figure",
            format!("standard deviation of each of {} forces {}", all.forces, between(all.sigmas_n, newtons)),
            format!(
                "linear, {CAMERA_NOISE_MM} mm noise; singular values span {:.0}. With few known contacts it is as good as any",
                all.span
            ),
            Explained,
        ),
        claim(
            "Forces shared differently by two near nodes bend the finger nearly alike (Fig. 12)",
            "(1, 4) and (4, 1) N at 18, 19 alike; 17, 21 not",
            format!("shapes differ by {} at 18 and 19, by {} at 17 and 21", percent(near), percent(far)),
            "large rotations; of the largest displacement",
            if near < far { Reproduced } else { Refuted },
        ),
        claim(
            "... so how near nodes share a force cannot be told",
            "47.5 % (nodes 19, 20 and 16, 17)",
            neighbours.map_or("-".to_owned(), |error| format!("mean error {}", percent(error))),
            "nonlinear estimator, neighbours of Table II: shapes are nearly alike, but 23 nodes see the difference",
            if neighbours.is_some_and(|error| error < TOLD_SHARE) { Refuted } else { Reproduced },
        ),
        claim(
            "Force and direction both unknown will not work (Fig. 13)",
            "no figure",
            format!("standard deviation of the force across the normal {}", between(across, newtons)),
            format!(
                "linear, {CAMERA_NOISE_MM} mm noise; under {TOLD_N} N in places: there the direction of a force of some newtons is told"
            ),
            if across[0] < TOLD_N { Refuted } else { Reproduced },
        ),
        claim(
            "A direction that is 12.5 deg off costs 1 - cos 12.5 deg",
            "2.4 %",
            format!("{} (sensed over true, less one)", between(off, percent)),
            "linear, nodes 14 to 24, force turned towards the tip: the tangential part bends the finger too, and is taken for normal force",
            if largest(off) > 2.0 * 0.024 { Refuted } else { Reproduced },
        ),
        claim(
            "Torques of the contact are negligible: a rod's radius is 1.5 mm",
            "no figure",
            format!("{} of the force", between(torque, percent)),
            format!("linear, nodes 14 to 24, friction of {FRICTION}: its moment alone"),
            if largest(torque) < 0.05 { Reproduced } else { Refuted },
        ),
        rate::sensing_rate(&study.speed_error),
    ])
}

fn not_testable() -> Vec<Claim> {
    let row =
        |what: &str, paper: &str, why: &str| claim(what, paper, "-".to_owned(), why, ClaimVerdict::NotTestableHere);
    vec![
        row(
            "Camera: worst error of a node's position",
            "0.2 mm",
            "needs the camera; taken as three standard deviations of 0.067 mm",
        ),
        row(
            "Gripper: from the motor's angle to the finger, eqs. (6) to (10)",
            "-",
            "its dimensions are in a figure that was not at hand",
        ),
    ]
}
