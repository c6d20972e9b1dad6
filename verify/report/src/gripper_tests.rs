//! Table II on the moving gripper: a table, curves over the motor angle as in the paper's Figs. 9 to 11, and a file.

use crate::drawings::true_and_sensed;
use crate::format::{list, share_of_counts};
use crate::prelude::*;
use finray_studies::experiments::grasp::modules::{ModuleStudy, ModuleTest};
use finray_studies::experiments::table_two::CONTACT_GROUPS;

const CSV: &str = "gripper_tests.csv";
/// Estimators in the file and in the table.
const ESTIMATORS: [EstimatorId; 3] = [EstimatorId::LeastSquares, EstimatorId::Nonlinear, EstimatorId::Network];
/// Contact nodes of the drawn tests, one set for each of the paper's Figs. 9 to 11.
const DRAWN: [&[usize]; 3] = [&[19], &[19, 20], &[18, 20]];

/// A row of the file: one node in one noise sample of one step.
struct Line {
    nodes: &'static [usize],
    turned_deg: f64,
    axis_deg: f64,
    sample: usize,
    node: usize,
    force_n: f64,
    sensed_n: [Option<f64>; 3],
}

pub(super) fn datasets<'s>(Results { study }: Results<'s>) -> Vec<Dataset<'s>> {
    let columns = Columns::<Line>::new()
        .file("nodes", |line| list(line.nodes, " "))
        .file("turned_deg", |line| line.turned_deg)
        .file("axis_deg", |line| line.axis_deg)
        .file("sample", |line| line.sample)
        .file("node", |line| line.node)
        .file("force_n", |line| line.force_n)
        .file("least_squares_n", |line| line.sensed_n[0])
        .file("nonlinear_n", |line| line.sensed_n[1])
        .file("network_n", |line| line.sensed_n[2]);
    let tests = study.modules.iter().flat_map(|modules| &modules.tests);
    vec![Dataset::new(CSV, &columns, tests.flat_map(lines).collect::<Vec<_>>()).csv_alone()]
}

fn lines(test: &ModuleTest) -> Vec<Line> {
    let nodes = test.nodes;
    let mut lines = Vec::new();
    for step in &test.steps {
        for sample in 0..step.of(ESTIMATORS[0]).len() {
            lines.extend(nodes.iter().enumerate().map(|(i, &node)| Line {
                nodes,
                turned_deg: step.turned_deg,
                axis_deg: step.axis_deg,
                sample: sample + 1,
                node,
                force_n: step.true_n[i],
                sensed_n: ESTIMATORS.map(|estimator| Some(step.of(estimator).get(sample)?.as_ref()?[i])),
            }));
        }
    }
    lines
}

pub(super) fn section(Results { study }: Results) -> Result<Option<Section>, ReportError> {
    let Some(modules) = &study.modules else { return Ok(None) };
    let mut figures = Vec::new();
    for test in DRAWN.iter().filter_map(|nodes| modules.test(nodes)) {
        let caption = "Lines: true forces; symbols: forces sensed by the nonlinear estimator.";
        figures.push(Figure::narrow(drawing(test)?, caption, CSV));
    }
    let blocks = vec![text(about(modules.noise_mm)), Block::Table(table(modules)), Block::Figures(figures)];
    Ok(Some(Section::new("gripper-tests", "Table II on the closing gripper", blocks)))
}

/// Text on how the gripper closes, and on how its forces are sensed.
fn about(noise_mm: f64) -> String {
    format!(
        "The tests of Table II on a simulated closing gripper: the motor moves the finger's base by eqs (6) to \
            (9). The rods at the nodes press on fixed frictionless sensors in one plane, which is initially inclined \
            to the plate by 12 degrees. Forces are sensed along the sensors' axis (by the network along the undeformed \
            normal), with {noise_mm} mm noise. Errors are averaged over 0.3 to 3 N. The lengths of the linkage are \
            assumed. Both fingers bend equally."
    )
}

/// Chart of the true and sensed forces over the motor angle.
fn drawing(test: &ModuleTest) -> Result<String, FigureError> {
    let mut series = Vec::new();
    for (i, node) in test.nodes.iter().enumerate() {
        let truth = test.steps.iter().map(|step| [step.turned_deg, step.true_n[i]]).collect();
        let sensed = test.steps.iter().filter_map(|step| {
            let first = step.of(EstimatorId::Nonlinear).first()?.as_ref()?;
            Some([step.turned_deg, first[i]])
        });
        series.extend(true_and_sensed(i, format!("node {node}"), truth, (sensed.collect(), Vec::new())));
    }
    let plural = if test.nodes.len() > 1 { "s" } else { "" };
    let title = format!("The gripper closes on sensors at node{plural} {}", list(test.nodes, " and "));
    let alt = format!("{title}: true and sensed forces over the motor's angle.");
    let axes = [Axis::linear("motor angle closed, deg"), Axis::linear("force, N")];
    Chart::new(Frame::third(title, alt), axes, series).svg()
}

/// Table of the mean errors, in the rows and columns of the paper's Table II.
fn table(modules: &ModuleStudy) -> Table {
    let figures = CONTACT_GROUPS.into_iter().flat_map(|group| {
        let each = (format!("{}: each", group.name), group.paper_force);
        let sum = group.paper_sum.map(|paper| (format!("{}: sum", group.name), paper));
        std::iter::once(each).chain(sum).enumerate().map(move |(n, (name, paper))| (group, n == 1, name, paper))
    });
    Columns::<Option<EstimatorId>>::new()
        .page("sensed by", Format::Words, |by| by.map_or("the paper, measured", |estimator| estimator.label()))
        .each(figures, |columns, (group, is_sum, name, paper)| {
            columns.page(name, Format::Error, move |by| match by {
                None => Some(paper),
                Some(estimator) => {
                    modules.group(&group, *estimator).and_then(|of| if is_sum { of.sum } else { Some(of.force) })
                }
            })
        })
        .page("refused", Format::Words, |by| {
            let counts = CONTACT_GROUPS.iter().filter_map(|group| modules.group(group, (*by)?));
            by.map(|_| share_of_counts(counts.map(|of| [of.refused, of.answered])))
        })
        .table(
            "On the closing gripper: mean error of each force and of the sum",
            CSV,
            std::iter::once(None).chain(ESTIMATORS.map(Some)),
        )
}
