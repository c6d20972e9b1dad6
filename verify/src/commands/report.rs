//! `finray report`

use super::{Failure, progress};
use finray_model::Scene;
use finray_verify::contact_scene::study::SceneWithOutline;
use finray_verify::files::{load_scene_with_outline, write_folder, write_text};
use finray_verify::fixtures;
use finray_verify::report;
use finray_verify::study::{Effort, Progress, Study};
use indicatif::ProgressBar;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Run every cross-check and map, and write a page that shows them.
///
/// Writes DIR/index.html, DIR/summary.json and a CSV behind every figure. Without SCENE it is about
/// the paper's finger; what exists for that finger alone is left out for others, and the page says
/// so.
///
/// Examples:
///   finray report --open
///   finray report my-finger.toml --out my-report
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input [default: the finger of Xu et al. 2021]
    scene: Option<PathBuf>,
    /// Folder for the report; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "finray-report")]
    out: PathBuf,
    /// Coarse maps and fewer cases: a quarter of a minute instead of one and a half
    #[arg(long)]
    quick: bool,
    /// Open the page in the browser when it is done
    #[arg(long)]
    open: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scene = match &arguments.scene {
        Some(path) => load_scene_with_outline(path)?,
        None => {
            let scene = Scene::from_toml(fixtures::PAPER_SCENE);
            let scene = scene.map_err(|error| Failure::NotComputed(error.to_string()))?;
            SceneWithOutline { scene, corners: Vec::new() }
        }
    };
    let effort = if arguments.quick { Effort::Quick } else { Effort::Full };
    let bars = Bars(Mutex::new(ProgressBar::hidden()));
    let study = Study::run(&scene, effort, &bars).map_err(|error| Failure::NotComputed(error.to_string()))?;
    bars.finish();
    let files = report::files(&study).map_err(|error| Failure::NotComputed(error.to_string()))?;
    write_folder(&arguments.out, &files)?;
    let page = arguments.out.join("index.html");
    let mut sentences = report::Summary::of(&study).verdict;
    sentences.push(format!("The report is in {}\n", page.display()));
    write_text(Path::new("-"), &sentences.join("\n"))?;
    if arguments.open {
        open::that_detached(&page)
            .map_err(|error| Failure::NotComputed(format!("{} cannot be opened: {error}", page.display())))?;
    }
    Ok(())
}

/// A progress bar a part.
struct Bars(Mutex<ProgressBar>);

impl Bars {
    fn with(&self, act: impl FnOnce(&mut ProgressBar)) {
        // A poisoned lock only means that another thread failed while drawing its bar.
        act(&mut self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner));
    }

    fn finish(&self) {
        self.with(|bar| bar.finish_and_clear());
    }
}

impl Progress for Bars {
    fn part(&self, name: &str, steps: usize) {
        self.with(|bar| {
            bar.finish_and_clear();
            *bar = progress::bar(steps as u64, name);
        });
    }

    fn step(&self) {
        self.with(|bar| bar.inc(1));
    }
}
