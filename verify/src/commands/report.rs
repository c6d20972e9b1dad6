//! The command `finray report`.

use crate::commands::prelude::*;
use finray_files::image_named;
use finray_files::views;
use finray_studies::experiments::contact_scene::file::load_scene_with_outline;
use finray_studies::experiments::contact_scene::study::SceneWithOutline;
use finray_studies::experiments::measured::{self, NamedImage};
use finray_studies::settings::{Effort, Progress, ReportForces};
use finray_studies::study::Study;
use indicatif::ProgressBar;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray report --open
  finray report my-finger.toml --force-n 0.06 --out my-report
  finray report calibrated.toml --measurements new.csv --forces forces.csv --image photo*.jpg

Guide: finray guide reading-the-report";

/// Run all checks and maps of a finger, and write them as HTML pages.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input [default: the finger of Xu et al. 2021]
    scene: Option<PathBuf>,
    /// Folder for the report; created if missing
    #[arg(long, value_name = "DIR", default_value = "finray-report")]
    out: PathBuf,
    /// Largest force F, N; the report has maps for the forces F/6, F/3, 2F/3 and F
    #[arg(long, value_name = "F", value_parser = positive, default_value_t = ReportForces::PAPER.drawn_n())]
    force_n: f64,
    /// Compute coarser maps and fewer cases, in a fraction of the time
    #[arg(long)]
    quick: bool,
    /// Markers located in your images (file from `finray locate`)
    #[arg(long, help_heading = "Your photographs", value_name = "FILE", requires = "scene", requires = "forces")]
    measurements: Option<PathBuf>,
    /// Measured forces in the frame in which the scene states the camera's pose (CSV: image,fx_n,fy_n)
    #[arg(long, help_heading = "Your photographs", value_name = "FILE", requires = "measurements")]
    forces: Option<PathBuf>,
    /// Images (PNG, JPEG) named in the file of --measurements; the page draws marker residuals over these images
    #[arg(long, help_heading = "Your photographs", value_name = "FILE", num_args = 1.., requires = "measurements")]
    image: Vec<PathBuf>,
    /// Open the first page in the browser when done
    #[arg(long)]
    open: bool,
}

/// A warning is printed if a marker's position in the file differs from its position with this scene by more than this, mm. The limit is far below
/// any noise and far above rounding errors.
const SAME_MM: f64 = 1e-3;

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let scene = match &arguments.scene {
        Some(path) => load_scene_with_outline(path)?,
        None => SceneWithOutline::from_toml(finray_fixtures::PAPER_SCENE).map_err(not_computed)?,
    };
    if let Some(path) = &arguments.scene {
        hints::of_scene(path, &scene.scene);
        hints::of_neglected_thickness(&scene.scene);
    }
    let seen = match &arguments.measurements {
        None => None,
        Some(located) => {
            let seen = views::load(located, arguments.forces.as_deref(), &scene.scene)?;
            hints::of_refused(&seen.refused);
            if seen.misplaced_mm > SAME_MM {
                print_message(format_args!(
                    "warning: {}: the images were located with another scene, or with --rest: positions of markers \
                        differ by up to {:.2} mm from the positions with this scene; locate the images again with this \
                        scene",
                    located.display(),
                    seen.misplaced_mm
                ));
            }
            Some(seen.views)
        }
    };
    let located: Vec<&str> = seen.iter().flatten().map(|seen| seen.view.name.as_str()).collect();
    let images = arguments.image.iter().map(|path| named_image(path, &located)).collect::<Result<Vec<_>, _>>()?;
    require_folder(&arguments.out)?;
    let effort = if arguments.quick { Effort::Quick } else { Effort::Full };
    let bar = Bar(progress_bar(0, "report"));
    let mut study = Study::run(&scene, ReportForces::up_to(arguments.force_n), effort, &bar).map_err(not_computed)?;
    bar.0.finish_and_clear();
    if let Some(seen) = seen {
        study.measured = Some(measured::run(&scene.scene, &seen, &images).map_err(bad_input)?);
    }
    let report = finray_report::report(&study).map_err(not_computed)?;
    write_folder(&arguments.out, &report.files)?;
    let page = arguments.out.join("index.html");
    let mut lines = report.short;
    lines.push(format!("The report is in {}\n", page.display()));
    write_file(Path::new("-"), lines.join("\n"))?;
    if arguments.open
        && let Err(error) = open::that_detached(&page)
    {
        // The report is written and its path is printed, so a browser that does not open is no error.
        print_message(format_args!(
            "note: the page could not be opened ({}); open {} in a browser",
            // The browser opener's message may have several lines; only the first is printed.
            error.to_string().lines().next().unwrap_or_default(),
            page.display()
        ));
    }
    Ok(summary("report", [&page]))
}

/// Loads an image and finds its name among the located images.
fn named_image(path: &Path, located: &[&str]) -> Result<NamedImage, FileError> {
    let (image, _) = load_image(path)?;
    let none = |_| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        FileError::content(path, format!("image {name:?} is not among the located images"))
    };
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let name = image_named(&whole.to_string_lossy(), located).map_err(none)?;
    Ok((name.to_owned(), image))
}

/// Progress bar that starts anew for each part of the study.
struct Bar(ProgressBar);

impl Progress for Bar {
    fn part(&self, name: &str, steps: usize) {
        self.0.reset();
        self.0.set_length(steps as u64);
        self.0.set_message(name.to_owned());
    }

    fn step(&self) {
        self.0.inc(1);
    }
}
